"""The catalogue of small changes of a formula's LaTeX: what a slip of the pen does to it, and what
undoes it.

Corrections try these changes on a row that does not hold, and the benchmark draws slips from them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from .formula import (
    FUNCTIONS,
    Bracket,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    RelationChain,
    Sum,
    Symbol,
    Token,
    list_nodes,
    read_formula,
    tokenize_formula,
)
from .interpretation import look_up_spelling
from .names import StatedNames
from .values import Scalar, Value

SWAPS = {
    r"\sin": r"\cos",
    r"\cos": r"\sin",
    r"\tan": r"\cot",
    r"\sinh": r"\cosh",
    r"\cosh": r"\sinh",
}
FACTORS = ("2", r"\frac{1}{2}", r"\frac{1}{3}", r"\frac{1}{12}")
NUMBERS = (12, 3, 4, 6)
"""Numbers that stand below moments of inertia."""
MINUS = ("-", "\u2212")


@dataclass(frozen=True)
class LatexChange:
    """A change of a source: what replaces the range from ``start`` to ``end``, once or at several
    places.
    """

    pieces: tuple[tuple[int, int, str], ...]
    text: str

    def apply(self, latex: str) -> str:
        """Return the source after the change."""
        for start, end, new in sorted(self.pieces, reverse=True):
            before, after = latex[:start], latex[end:]
            glue = " " if re.search(r"\\[A-Za-z]+$", before) and new[:1].isalpha() else ""
            tail = " " if re.search(r"\\[A-Za-z]+$", new) and after[:1].isalpha() else ""
            latex = f"{before}{glue}{new}{tail}{after}"
        return latex


def change_at(start: int, end: int, new: str, text: str) -> LatexChange:
    """Return the change of one range, with its description."""
    return LatexChange(((start, end, new),), text)


@dataclass(frozen=True)
class PrintedFormula:
    """An equation in its own LaTeX with its tree, its tokens outside macros, and the names of the
    text that have a meaning.
    """

    latex: str
    chain: RelationChain
    tokens: tuple[Token, ...]
    names: StatedNames
    vocabulary: tuple[str, ...]

    @classmethod
    def read(
        cls,
        latex: str,
        macros: Mapping[str, tuple[int, str]],
        names: StatedNames,
        vocabulary: Sequence[str],
    ) -> PrintedFormula:
        """Read an equation. Raises FormulaError if it cannot be read."""
        tokens = tuple(token for token in tokenize_formula(latex, macros) if not token.fixed)
        return cls(latex, read_formula(latex, macros), tokens, names, tuple(vocabulary))

    @cached_property
    def nodes(self) -> list[Node]:
        """All parts of the equation."""
        return list(list_nodes(self.chain))

    @property
    def named(self) -> list[Name]:
        """The names in the equation, at each of their places."""
        return [node for node in self.nodes if isinstance(node, Name)]

    @property
    def terms(self) -> list[Node]:
        """The terms of all sums, and the sides that are no sum."""
        terms = [term for node in self.nodes if isinstance(node, Sum) for _, term in node.terms]
        return terms + [side for side in self.chain.sides if not isinstance(side, Sum)]

    def show(self, start: int, end: int | None = None) -> str:
        """Return a range of the source in short, without what marks rows."""
        remarks = r"\\(?:label|tag)\*?\s*\{[^{}]*\}|\\(?:nonumber|notag)(?![A-Za-z])|\\\\|&"
        text = " ".join(re.sub(remarks, " ", self.latex[start:end]).split())
        return shorten_latex(text)


LONGEST = 24
"""Characters of a piece of LaTeX that is shown, if it can end there."""


def shorten_latex(latex: str) -> str:
    """Return the beginning of a piece of LaTeX, which ends between names and outside of groups."""
    depth = 0
    for token in re.finditer(r"\\[A-Za-z]+|\\.|[A-Za-z0-9.]+|.", latex):
        depth += {"{": 1, "}": -1}.get(token.group(), 0)
        at = token.end()
        goes_on = re.match(r"\s*[{_^]", latex[at:]) or token.group() in ("_", "^", " ")
        if at >= LONGEST and depth <= 0 and not goes_on and latex[at:].strip():
            return f"{latex[:at]} ..."
    return latex


def change_signs(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield other signs, signs lost at a line break, and signs before a side or a bracket's part."""
    leading = {node.start for node in printed.nodes}
    for token in printed.tokens:
        if token.text in ("+", *MINUS):
            new = "-" if token.text == "+" else "+"
            place = _describe_place(printed, token.end)
            if new == "+" and token.start in leading:
                yield change_at(token.start, token.end, "", f"without {token.text}{place}")
            else:
                yield change_at(token.start, token.end, new, f"{new} for {token.text}{place}")
    for match in re.finditer(r"\\\\(?:\s*\[[^\]]*\])?\s*&*|\n\s*&*", printed.latex):
        for sign in "+-":
            text = f"{sign} after the line break{_describe_place(printed, match.end())}"
            yield change_at(match.end(), match.end(), f"{sign} ", text)
    for node in printed.nodes:
        parts: tuple[Node, ...] = node.sides if isinstance(node, RelationChain) else ()
        for part in node.parts if isinstance(node, Bracket) else parts:
            if printed.latex[part.start : part.start + 1] not in ("-", "+"):
                yield change_at(part.start, part.start, "-", f"- before {printed.show(part.start)}")


def _describe_place(printed: PrintedFormula, position: int) -> str:
    text = printed.show(position)
    return f" before {text}" if text else ""


def change_functions(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield the function that is mistaken most for a function, then the tangent."""
    for swaps in (SWAPS, dict.fromkeys((r"\sin", r"\cos"), r"\tan")):
        for token in printed.tokens:
            if token.text in swaps:
                new = swaps[token.text]
                yield change_at(token.start, token.end, new, f"{new} for {token.text}")


def change_names(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield names of equal dimension for a name, at one place and throughout."""
    yield from _replace_names(printed, _list_alike, throughout=True)


def change_to_unlike_names(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield all other names for a name."""
    yield from _replace_names(printed, _list_unlike)


def change_dots(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield a name with other dots for a name."""
    yield from _replace_names(printed, _list_dotted)


def _replace_names(
    printed: PrintedFormula,
    list_others: Callable[[PrintedFormula, Symbol], list[str]],
    throughout: bool = False,
) -> Iterator[LatexChange]:
    places: dict[Symbol, list[Name]] = {}
    for node in printed.named:
        places.setdefault(node.symbol, []).append(node)
    for symbol, nodes in places.items():
        spelling = symbol.spell()
        spellings = [other for other in list_others(printed, symbol) if other != spelling]
        for other in spellings:
            for node in nodes:
                text = f"{other} for {printed.latex[node.start : node.end]}"
                yield change_at(node.start, node.end, other, text)
        if len(nodes) > 1 and throughout:
            for other in spellings:
                pieces = tuple((node.start, node.end, other) for node in nodes)
                yield LatexChange(pieces, f"{other} for {spelling} throughout")


def _list_alike(printed: PrintedFormula, symbol: Symbol) -> list[str]:
    """List names that have the kind and dimension of a symbol, and the symbol with other dots."""
    names = printed.names
    value = names.look_up(symbol) if names.is_known(symbol) else None
    look_ups = ((spelling, look_up_spelling(names, spelling)) for spelling in printed.vocabulary)
    fitting = [spelling for spelling, other in look_ups if _are_alike(value, other)]
    return list(dict.fromkeys([*fitting, *_list_dotted(printed, symbol)]))


def _list_unlike(printed: PrintedFormula, symbol: Symbol) -> list[str]:
    alike = _list_alike(printed, symbol)
    return [other for other in printed.vocabulary if other not in alike]


def _list_dotted(printed: PrintedFormula, symbol: Symbol) -> list[str]:
    """List a name with other dots, where that has a meaning and moves at all."""
    dotted = (replace(symbol, dots=dots) for dots in range(3) if dots != symbol.dots)
    names = printed.names
    return [
        other.spell()
        for other in dotted
        if names.is_known(other) and _is_moving(names.look_up(other))
    ]


def _is_moving(value: Value) -> bool:
    return not isinstance(value, Scalar) or value.value != 0


def _are_alike(first: Value | None, second: Value | None) -> bool:
    if second is None or type(first) is not type(second):
        return False
    if isinstance(first, Scalar) and isinstance(second, Scalar):
        return first.dimension == second.dimension
    return True


def change_powers(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield powers left out, added, fallen to the line, and indices that are powers."""
    latex = printed.latex
    for node in printed.nodes:
        if isinstance(node, Power):
            base_end = node.base.end
            tail = latex[base_end : node.end].strip()
            if tail.startswith("^"):
                yield change_at(base_end, node.end, "", f"without {tail}")
                for power in ("^3", "^2"):
                    if tail not in (power, f"^{{{power[1]}}}"):
                        yield change_at(base_end, node.end, power, f"{power} for {tail}")
        elif isinstance(node, Name | Bracket):
            for power in ("^2", "^3"):
                text = f"{power} on {printed.show(node.start, node.end)}"
                yield change_at(node.end, node.end, power, text)
    for match in re.finditer(r"\\(sin|cos|tan)(?![A-Za-z^])(?!\s*\^)", latex):
        yield change_at(match.end(), match.end(), "^2", f"^2 on {match.group()}")
    for match in re.finditer(r"(?<=[A-Za-z}])(\d)(?=[^\d]|$)|_\{?(\d)(\d)\}?", latex):
        factor, index, power = match.groups()
        new, text = f"^{factor}", "a factor is a power"
        if power:
            new, text = f"_{index}^{power}", "an index is a power"
        yield change_at(match.start(), match.end(), new, text)


def change_numbers(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield other numbers for a number, and none."""
    for token in printed.tokens:
        if re.fullmatch(r"\d+", token.text):
            number = int(token.text)
            halves = [number // 2] if number % 2 == 0 else []
            for other in (number + 1, number - 1, 2 * number, *halves, *NUMBERS):
                if other > 0 and other != number:
                    yield change_at(token.start, token.end, str(other), f"{other} for {number}")
            yield change_at(token.start, token.end, "", f"without {number}")


def drop_fractions(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield fractions of numbers left out of products."""
    for node in printed.nodes:
        if isinstance(node, Product):
            for operator, factor in node.factors:
                is_number = isinstance(factor, Quotient) and all(
                    isinstance(part, Number) for part in (factor.above, factor.below)
                )
                if is_number and not operator:
                    text = printed.show(factor.start, factor.end)
                    blanks = re.compile(r"\s*").match(printed.latex, factor.end)
                    end = factor.end if blanks is None else blanks.end()
                    yield change_at(factor.start, end, "", f"without {text}")


def turn_fractions(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield fractions upside down."""
    for node in printed.nodes:
        if isinstance(node, Quotient):
            above, below = (_find_group(printed.latex, part) for part in (node.above, node.below))
            if above and below:
                pieces = (
                    (*above, printed.latex[slice(*below)]),
                    (*below, printed.latex[slice(*above)]),
                )
                text = f"the fraction {printed.show(node.start, node.end)} upside down"
                yield LatexChange(pieces, text)


def _find_group(latex: str, node: Node) -> tuple[int, int] | None:
    """Return the range of the braced group around a part, None if it is not alone in one."""
    start, end = node.start, node.end
    while start > 0 and latex[start - 1].isspace():
        start -= 1
    while end < len(latex) and latex[end].isspace():
        end += 1
    is_braced = start > 0 and end < len(latex) and latex[start - 1] == "{" and latex[end] == "}"
    return (start, end) if is_braced else None


def multiply_terms(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield factors on terms."""
    yield from _put_before_terms(printed, FACTORS)


def drop_names(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield names left out of products, without and with their power."""
    for node in printed.named:
        text = printed.latex[node.start : node.end]
        yield change_at(node.start, node.end, "", f"without {text}")
        power = re.match(r"\s*\^(?:\{[^{}]*\}|.)", printed.latex[node.end :])
        if power:
            described = f"without {text}{power.group().strip()}"
            yield change_at(node.start, node.end + power.end(), "", described)


def add_names(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield names that a term lacks as a factor, those of the equation first."""
    used = {node.symbol.spell() for node in printed.named}
    further = (name for name in printed.vocabulary if name not in used)
    yield from _put_before_terms(printed, [*sorted(used), *further])


def _put_before_terms(printed: PrintedFormula, factors: Sequence[str]) -> Iterator[LatexChange]:
    for term in printed.terms:
        for factor in factors:
            text = f"{factor} on {printed.show(term.start)}"
            yield change_at(term.start, term.start, f"{factor} ", text)


def drop_terms(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield terms left out with the sign before them."""
    for term in printed.terms:
        before = re.search(r"[+\-\u2212]\s*$", printed.latex[: term.start])
        if before:
            text = f"without {printed.show(before.start(), term.end)}"
            yield change_at(before.start(), term.end, "", text)


def drop_functions(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield sines and cosines left out with their argument."""
    argument = re.compile(
        r"\s*(?:\([^()]*\)|\\left\([^()]*\\right\)|\\?[A-Za-z]+(?:_\{[^{}]*\}|_\w)?|\{[^{}]*\})"
    )
    for match in re.finditer(r"\\(sin|cos)(?![A-Za-z])", printed.latex):
        following = argument.match(printed.latex, match.end())
        if following and match.group(1) in FUNCTIONS:
            text = f"without {printed.show(match.start(), following.end())}"
            yield change_at(match.start(), following.end(), "", text)


Changes = Callable[[PrintedFormula], Iterator[LatexChange]]
LIKELY: tuple[Changes, ...] = (
    change_signs,
    change_functions,
    change_names,
    change_powers,
    drop_fractions,
    change_numbers,
    turn_fractions,
)
"""Changes that put one thing for another, in the order in which they are tried."""
FURTHER: tuple[Changes, ...] = (
    multiply_terms,
    drop_names,
    add_names,
    drop_terms,
    drop_functions,
)
"""Changes by which something is lacking or too much."""
SLIPS: dict[str, Changes] = {
    "sign": change_signs,
    "number": change_numbers,
    "name": change_names,
    "dots": change_dots,
    "power": change_powers,
    "function": change_functions,
    "term": drop_terms,
    "factor": drop_names,
    "fraction": turn_fractions,
}
"""Changes of each class of slips that the benchmark draws."""


def list_rewrites(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield changes that say the same: sides exchanged, brackets, larger fractions, room."""
    latex, chain = printed.latex, printed.chain
    starts_bare = any(latex[side.start : side.start + 1] == "^" for side in chain.sides)
    is_plain = not re.search(r"\\\\|&|\\begin|\\tag|\\label", latex)
    if chain.relations == ("=",) and not starts_bare and is_plain:
        left, right = chain.sides
        first, second = (latex[side.start : side.end] for side in (left, right))
        pieces = (left.start, left.end, second), (right.start, right.end, first)
        yield LatexChange(pieces, "sides exchanged")
        yield change_at(right.start, right.end, rf"\left( {second} \right)", "brackets")
    for token in printed.tokens:
        if token.text == r"\frac":
            yield change_at(token.start, token.end, r"\dfrac", "a larger fraction")
        elif token.text in ("+", "-"):
            yield change_at(token.end, token.end, r"\,", "room")
    for node in printed.nodes:
        if isinstance(node, Product) and len(node.factors) > 1:
            (_, first_factor), (_, second_factor) = node.factors[:2]
            if not latex[first_factor.end : second_factor.start].strip():
                yield change_at(first_factor.end, second_factor.start, r" \, ", "room")
