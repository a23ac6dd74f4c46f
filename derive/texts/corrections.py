"""Corrections of a formula in its own LaTeX: small changes of the source, tried at points of the
motion.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..audit.judge import holds
from ..evaluate import Point
from .formula import (
    FUNCTIONS,
    Bracket,
    FormulaError,
    Heading,
    Matrix,
    Name,
    Node,
    Power,
    Quotient,
    RelationChain,
    Sum,
    Symbol,
    Token,
    list_nodes,
    read_formula,
    tokenize_formula,
)
from .interpretation import Interpreter, interpret_formula, list_scalars
from .monomials import MonomialSearch
from .names import PointNames, StatedNames
from .rereading import Rereader
from .values import OperandError, Scalar, Value
from .vector_terms import list_vector_terms

TOLERANCE = 1e-9
"""Residual that counts as zero, as a share of the largest term: far above the rounding of 15
digits.
"""
MOST_LISTED = 5
"""Corrections that are listed."""
MOST_SIGNS = 60
"""Terms of which any number may have another sign."""
SPARE = 4
"""Points by which there are more than terms, of which the signs are sought."""
DEPENDENT = 1e-8
"""Length of a sum of unit vectors that is zero but for rounding."""
UNREADABLE = (
    FormulaError,
    OperandError,
    TypeError,
    ValueError,
    ZeroDivisionError,
    RecursionError,
    IndexError,
)
"""Errors of a formula that cannot be read or evaluated."""
MOST_CANDIDATES = 20_000
SOLVED = 1e-13
"""Residual at which what is lacking has been found, as a share of the sides."""
MOST_TOKENS = 400_000
"""Tokens of all candidates of a group of changes, each of which is read again: fewer candidates of
a longer row.
"""


@dataclass(frozen=True)
class Repair:
    """A change of a row: its LaTeX after it, the change in words, and other changes that would do
    as well.
    """

    latex: str
    text: str
    alternatives: tuple[str, ...] = ()


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


def find_repairs(
    latex: str,
    index: int,
    names: StatedNames,
    points: Sequence[Point],
    macros: Mapping[str, tuple[int, str]],
    vocabulary: Sequence[str],
    draw: Callable[[int], Sequence[Point]],
    outcomes: dict[str, list[bool] | None] | None = None,
) -> Repair | None:
    """Return the smallest change of a row after which its residual of an index vanishes at points,
    None without one.

    ``draw`` returns a number of random admissible points, for changes of several signs.
    ``outcomes`` holds what earlier searches for the same row and points found of each source, and
    is added to. Residuals of the row that hold before must hold after it, and a change after which
    more of them hold is better. Changes are tried in floating point; what is found is confirmed by
    the exact reading, so that it holds to all digits and is no identity.
    """
    at_points = PointNames(names, points)
    in_row = [
        spelling
        for spelling, meaning in names.table.meanings.items()
        if meaning.strip() and "#" not in spelling
    ]
    vocabulary = list(dict.fromkeys([*vocabulary, *in_row]))
    outcomes, memory = {} if outcomes is None else outcomes, _Memory()
    try:
        chain = read_formula(latex, macros)
        before = _outcomes(chain, at_points, _Memory())
    except (FormulaError, OperandError, TypeError, ValueError):
        return None
    if before is None or not index < len(before):
        return None
    is_mixed = _mixes_units(chain, index, names)
    rereader = Rereader(latex, chain, macros, memory.brackets)
    changes: list[tuple[int, LatexChange]] = []
    seen_sources: set[str] = {latex}
    limit = min(MOST_CANDIDATES, MOST_TOKENS // len(tokenize_formula(latex, macros)))
    tiers = (
        *_list_tiers(latex, chain, macros, names, vocabulary),
        _sign_groups(latex, index, chain, macros, names, draw),
        _list_completions(latex, index, chain, macros, at_points, vocabulary),
        _replacements(latex, chain, names, vocabulary, are_alike=False),
    )
    for tier in tiers:
        for count, change in enumerate(tier):
            if count >= limit or len(changes) >= MOST_LISTED:
                break
            changed = change.apply(latex)
            if changed in seen_sources:
                continue
            seen_sources.add(changed)
            if changed not in outcomes:
                outcomes[changed] = _try(change, changed, rereader, at_points, memory)
            after = outcomes[changed]
            if after is None or len(after) != len(before) or not after[index]:
                continue
            if all(now or not then for now, then in zip(after, before, strict=True)) and _confirmed(
                changed, index, macros, names, points, is_mixed
            ):
                changes.append((sum(not holds_now for holds_now in after), change))
        if changes:
            first, *rest = (change for _, change in sorted(changes, key=lambda pair: pair[0]))
            return Repair(first.apply(latex), first.text, tuple(change.text for change in rest))
    return None


def _mixes_units(chain: RelationChain, index: int, names: StatedNames) -> bool:
    """Return whether a row joins what has different units, as a matrix of a state space does."""
    _, _, left, right = interpret_formula(chain, names).residuals(names)[index]
    return (left + (-right)).mixed


@dataclass
class _Memory:
    """Brackets of the candidates of a row, read once, with their values and the size of the largest
    term in them.

    Values are by the identity of the parts of their bracket, which they hold, so that no other can
    have it.
    """

    brackets: dict[tuple[str, ...], Bracket] = field(default_factory=dict)
    values: dict[int, tuple[tuple[Node, ...], Value, Any]] = field(default_factory=dict)


class _Sizing(Interpreter):
    """An interpreter at points that notes the size of the largest term."""

    largest: Any = 0.0
    memory: _Memory

    def _bracket(self, node: Bracket) -> Value:
        if id(node.parts) in self.memory.values:
            _, value, largest = self.memory.values[id(node.parts)]
        else:
            before, options, self.largest = self.largest, len(self.options), 0.0
            value = super()._bracket(node)
            largest, self.largest = self.largest, before
            if len(self.options) == options:
                self.memory.values[id(node.parts)] = node.parts, value, largest
        self.largest = np.maximum(self.largest, largest)
        return value

    def _added(self, first: Value, second: Value) -> Value:
        for value in (*list_scalars(first), *list_scalars(second)):
            self.largest = np.maximum(self.largest, np.abs(value.value))
        return super()._added(first, second)


def _outcomes(chain: RelationChain, names: PointNames, memory: _Memory) -> list[bool] | None:
    """Return for each residual of a row whether it vanishes at all points; None for one of no
    consistent reading.
    """
    reader = _Sizing(names, [])
    reader.memory = memory
    with np.errstate(all="ignore"):
        try:
            read = reader.read(chain)
            if reader.options or not read.is_consistent(names):
                read = interpret_formula(chain, names)
        except FormulaError:
            if not reader.options:
                raise
            read = interpret_formula(chain, names)
        return [
            _vanishes(left, right, reader.largest) for _, _, left, right in read.residuals(names)
        ]


def _vanishes(left: Scalar, right: Scalar, largest: Any) -> bool:
    gap = np.abs(np.asarray(left.value, dtype=float) - np.asarray(right.value, dtype=float))
    size = np.maximum(np.maximum(np.abs(left.value), np.abs(right.value)), largest)
    return bool(
        np.all(gap <= TOLERANCE * size)
        and np.all(np.isfinite(gap))
        and np.any(np.asarray(size) > 0)
    )


def _try(
    change: LatexChange, changed: str, rereader: Rereader, names: PointNames, memory: _Memory
) -> list[bool] | None:
    try:
        return _outcomes(rereader.read(change.pieces, changed), names, memory)
    except UNREADABLE:
        return None


def _confirmed(
    latex: str,
    index: int,
    macros: Mapping[str, tuple[int, str]],
    names: StatedNames,
    points: Sequence[Point],
    is_mixed: bool,
) -> bool:
    """Return whether the exact reading of a changed row holds, is no identity, and mixes units only
    if the row did.

    A row may be one where a name in it stands for what is computed of the mechanism, as its kinetic
    energy is.
    """
    try:
        chain = read_formula(latex, macros)
        _, relation, left, right = interpret_formula(chain, names).residuals(names)[index]
    except (FormulaError, OperandError, TypeError, ValueError, IndexError):
        return False
    residual = left.value - right.value
    if relation != "=" or ((left + (-right)).mixed and not is_mixed):
        return False
    if residual == 0:
        sides = {"".join(latex[side.start : side.end].split()) for side in chain.sides}
        named = [node.symbol for node in list_nodes(chain) if isinstance(node, Name)]
        return len(sides) > 1 and any(map(names.is_computed, named))
    return holds(residual, tuple(points))


def _list_tiers(
    latex: str,
    chain: RelationChain,
    macros: Mapping[str, tuple[int, str]],
    names: StatedNames,
    vocabulary: Sequence[str],
) -> Iterator[Iterator[LatexChange]]:
    """Yield changes in groups: a single character or name first, then factors and names of a
    product.
    """
    tokens = [token for token in tokenize_formula(latex, macros) if not token.fixed]
    yield _single_changes(latex, tokens, chain, names, vocabulary)
    yield _factor_changes(latex, tokens, chain, names, vocabulary)


def _single_changes(
    latex: str,
    tokens: Sequence[Token],
    chain: RelationChain,
    names: StatedNames,
    vocabulary: Sequence[str],
) -> Iterator[LatexChange]:
    yield from _signs(latex, tokens, chain)
    yield from _functions(tokens)
    yield from _replacements(latex, chain, names, vocabulary)
    yield from _powers(latex, chain)
    yield from _numbers(tokens)
    yield from _turned(latex, chain)


def _signs(latex: str, tokens: Sequence[Token], chain: RelationChain) -> Iterator[LatexChange]:
    """Yield other signs, signs before terms without one, and signs lost at line breaks."""
    for token in tokens:
        if token.text in ("+", "-", "\u2212"):
            new = "-" if token.text == "+" else "+"
            yield LatexChange(
                ((token.start, token.end, new),),
                f"{new} for {token.text}{_describe_place(latex, token.end)}",
            )
    for match in re.finditer(r"\\\\(?:\s*\[[^\]]*\])?\s*&*|\n\s*&*", latex):
        for sign in "+-":
            text = f"{sign} after the line break{_describe_place(latex, match.end())}"
            yield LatexChange(((match.end(), match.end(), f"{sign} "),), text)
    for node in list_nodes(chain):
        starts = [side.start for side in node.sides] if isinstance(node, RelationChain) else []
        if isinstance(node, Bracket):
            starts = [part.start for part in node.parts]
        for start in starts:
            if latex[start : start + 1] not in ("-", "+"):
                yield LatexChange(((start, start, "-"),), f"- before {_shorten(latex[start:])}")


def _describe_place(latex: str, position: int) -> str:
    text = _shorten(latex[position:])
    return f" before {text}" if text else ""


def _shorten(text: str) -> str:
    """Return the beginning of a source on one line."""
    text = re.sub(
        r"\\(?:label|tag)\*?\s*\{[^{}]*\}|\\(?:nonumber|notag)(?![A-Za-z])|\\\\|&", " ", text
    )
    text = " ".join(text.split())
    return text if len(text) <= 24 else f"{text[:24]} ..."


def _functions(tokens: Sequence[Token]) -> Iterator[LatexChange]:
    swaps = {
        "\\sin": "\\cos",
        "\\cos": "\\sin",
        "\\tan": "\\cot",
        "\\sinh": "\\cosh",
        "\\cosh": "\\sinh",
    }
    for token in tokens:
        if token.text in swaps:
            new = swaps[token.text]
            yield LatexChange(((token.start, token.end, new),), f"{new} for {token.text}")
    for token in tokens:
        if token.text in ("\\sin", "\\cos"):
            yield LatexChange(((token.start, token.end, "\\tan"),), f"\\tan for {token.text}")


def _replacements(
    latex: str,
    chain: RelationChain,
    names: StatedNames,
    vocabulary: Sequence[str],
    are_alike: bool = True,
) -> Iterator[LatexChange]:
    """Yield other names of the text for a name, at one place and everywhere: of its dimension or
    dots, or others.
    """
    places: dict[Symbol, list[Node]] = {}
    for node in list_nodes(chain):
        if isinstance(node, Name):
            places.setdefault(node.symbol, []).append(node)
    for symbol, nodes in places.items():
        alike = _alternatives(symbol, names, vocabulary)
        alternatives = alike if are_alike else [other for other in vocabulary if other not in alike]
        alternatives = [other for other in alternatives if other != symbol.spell()]
        for other in alternatives:
            for place in nodes:
                yield LatexChange(
                    ((place.start, place.end, other),),
                    f"{other} for {latex[place.start : place.end]}",
                )
        if len(nodes) > 1 and are_alike:
            for other in alternatives:
                pieces = tuple((node.start, node.end, other) for node in nodes)
                yield LatexChange(pieces, f"{other} for {symbol.spell()} throughout")


def _alternatives(symbol: Symbol, names: StatedNames, vocabulary: Sequence[str]) -> list[str]:
    """Return names that may have been meant: those of the dimension, and the name with other dots
    or another index.
    """
    value = names.look_up(symbol) if names.is_known(symbol) else None
    fitting = []
    for spelling in vocabulary:
        node = read_formula(f"{spelling} = 0").sides[0]
        other = (
            names.look_up(node.symbol)
            if isinstance(node, Name) and names.is_known(node.symbol)
            else None
        )
        if _alike(value, other):
            fitting.append(spelling)
    return list(dict.fromkeys([*fitting, *(other.spell() for other in list_dotted(symbol, names))]))


def list_dotted(symbol: Symbol, names: StatedNames) -> list[Symbol]:
    """List a name with other numbers of dots that has a meaning: dots on a constant are no error
    that a text has.
    """
    dotted = (replace(symbol, dots=dots) for dots in range(3) if dots != symbol.dots)
    return [other for other in dotted if names.is_known(other) and _is_moving(names.look_up(other))]


def _is_moving(value: Value) -> bool:
    return not isinstance(value, Scalar) or value.value != 0


def _alike(first: Value | None, second: Value | None) -> bool:
    if first is None or second is None or type(first) is not type(second):
        return False
    if isinstance(first, Scalar) and isinstance(second, Scalar):
        return first.dimension == second.dimension
    return True


def _powers(latex: str, chain: RelationChain) -> Iterator[LatexChange]:
    """Yield powers left out, added, fallen to the line, and indices that are powers."""
    for node in list_nodes(chain):
        if isinstance(node, Power) and latex[node.base.end : node.base.end + 1] in (
            "^",
            "_",
            " ",
            "{",
            "",
        ):
            tail = latex[node.base.end : node.end]
            if tail.lstrip().startswith("^"):
                yield LatexChange(((node.base.end, node.end, ""),), f"without {tail.strip()}")
                if tail.strip() not in ("^3", "^{3}"):
                    yield LatexChange(((node.base.end, node.end, "^3"),), f"^3 for {tail.strip()}")
                if tail.strip() not in ("^2", "^{2}"):
                    yield LatexChange(((node.base.end, node.end, "^2"),), f"^2 for {tail.strip()}")
        elif isinstance(node, Name | Bracket):
            for power in ("^2", "^3"):
                change = ((node.end, node.end, power),)
                yield LatexChange(change, f"{power} on {_shorten(latex[node.start : node.end])}")
    for match in re.finditer(r"\\(sin|cos|tan)(?![A-Za-z^])(?!\s*\^)", latex):
        yield LatexChange(((match.end(), match.end(), "^2"),), f"^2 on {match.group()}")
    for match in re.finditer(r"(?<=[A-Za-z}])(\d)(?=[^\d]|$)|_\{?(\d)(\d)\}?", latex):
        if match.group(3):
            yield LatexChange(
                ((match.start(), match.end(), f"_{match.group(2)}^{match.group(3)}"),),
                "an index is a power",
            )
        else:
            yield LatexChange(
                ((match.start(), match.end(), f"^{match.group(1)}"),), "a factor is a power"
            )


def _numbers(tokens: Sequence[Token]) -> Iterator[LatexChange]:
    """Yield other numbers for a number, and none."""
    for token in tokens:
        if re.fullmatch(r"\d+", token.text):
            number = int(token.text)
            for other in (
                number + 1,
                number - 1,
                2 * number,
                *([number // 2] if number % 2 == 0 else []),
                12,
                3,
                4,
                6,
            ):
                if other > 0 and other != number:
                    yield LatexChange(
                        ((token.start, token.end, str(other)),), f"{other} for {number}"
                    )
            yield LatexChange(((token.start, token.end, ""),), f"without {number}")


def _turned(latex: str, chain: RelationChain) -> Iterator[LatexChange]:
    """Yield fractions upside down, and brackets around neighbouring terms."""
    for node in list_nodes(chain):
        if isinstance(node, Quotient):
            above, below = (_group_of(latex, part) for part in (node.above, node.below))
            if above and below:
                pieces = ((*above, latex[slice(*below)]), (*below, latex[slice(*above)]))
                yield LatexChange(
                    pieces, f"the fraction {_shorten(latex[node.start : node.end])} upside down"
                )


def _group_of(latex: str, node: Node) -> tuple[int, int] | None:
    """Return the range of the braced group around a part, None if it is not alone in one."""
    start, end = node.start, node.end
    while start > 0 and latex[start - 1].isspace():
        start -= 1
    while end < len(latex) and latex[end].isspace():
        end += 1
    if start > 0 and end < len(latex) and latex[start - 1] == "{" and latex[end] == "}":
        return start, end
    return None


def _factor_changes(
    latex: str,
    tokens: Sequence[Token],
    chain: RelationChain,
    names: StatedNames,
    vocabulary: Sequence[str],
) -> Iterator[LatexChange]:
    """Yield factors 2 and 1/2 on terms, names left out of products, and names that a product
    lacks.
    """
    terms = [
        (sign, term)
        for node in list_nodes(chain)
        if isinstance(node, Sum)
        for sign, term in node.terms
    ]
    terms += [(1, side) for side in chain.sides if not isinstance(side, Sum)]
    for _, term in terms:
        for factor in ("2", "\\frac{1}{2}", "\\frac{1}{3}", "\\frac{1}{12}"):
            yield LatexChange(
                ((term.start, term.start, f"{factor} "),),
                f"{factor} on {_shorten(latex[term.start :])}",
            )
    for node in list_nodes(chain):
        if isinstance(node, Name):
            text = latex[node.start : node.end]
            yield LatexChange(((node.start, node.end, ""),), f"without {text}")
            power = re.match(r"\s*\^(?:\{[^{}]*\}|.)", latex[node.end :])
            if power:
                yield LatexChange(
                    ((node.start, node.end + power.end(), ""),),
                    f"without {text}{power.group().strip()}",
                )
    used = {node.symbol.spell() for node in list_nodes(chain) if isinstance(node, Name)}
    lacking = [*sorted(used), *(name for name in vocabulary if name not in used)]
    for _, term in terms:
        for name in lacking:
            yield LatexChange(
                ((term.start, term.start, f"{name} "),),
                f"{name} on {_shorten(latex[term.start :])}",
            )
    for _, term in terms:
        yield from _without_term(latex, term)
    for match in re.finditer(r"\\(sin|cos)(?![A-Za-z])", latex):
        yield from _without_function(latex, match)


def _without_term(latex: str, term: Node) -> Iterator[LatexChange]:
    before = re.search(r"[+\-\u2212]\s*$", latex[: term.start])
    if before:
        yield LatexChange(
            ((before.start(), term.end, ""),),
            f"without {_shorten(latex[before.start() : term.end])}",
        )


def _without_function(latex: str, match: re.Match[str]) -> Iterator[LatexChange]:
    argument = re.match(
        r"\s*(?:\([^()]*\)|\\left\([^()]*\\right\)|\\?[A-Za-z]+(?:_\{[^{}]*\}|_\w)?|\{[^{}]*\})",
        latex[match.end() :],
    )
    if argument and match.group(1) in FUNCTIONS:
        end = match.end() + argument.end()
        yield LatexChange(
            ((match.start(), end, ""),), f"without {_shorten(latex[match.start() : end])}"
        )


LACKING = Symbol("\\Xi", subscript="lacking")
"""Name of what a row lacks at a place."""
MOST_PLACES = 80
"""Places of a row at which something may be lacking."""
ITERATIONS = 8
"""Steps of the secant method by which the values of what is lacking are found."""


class _Completed(PointNames):
    """The meanings of names at points, and values (points,) of what a row lacks, whose dimension is
    not known.
    """

    def __init__(self, names: PointNames, lacking: Any) -> None:
        super().__init__(names.names, names.points)
        self._meanings, self._derivatives, self._turns = (
            names._meanings,
            names._derivatives,
            names._turns,
        )
        self.lacking = Scalar(lacking, None)

    def is_known(self, symbol: Symbol) -> bool:
        """Return whether a name has a meaning."""
        return symbol == LACKING or super().is_known(symbol)

    def look_up(self, symbol: Symbol) -> Value:
        """Return the values of a name at the points."""
        return self.lacking if symbol == LACKING else super().look_up(symbol)


def _list_completions(
    latex: str,
    index: int,
    chain: RelationChain,
    macros: Mapping[str, tuple[int, str]],
    names: PointNames,
    vocabulary: Sequence[str],
) -> Iterator[LatexChange]:
    """Yield terms and factors that the row lacks at any place, found by the values that they should
    have.
    """
    spelled = [node.symbol.spell() for node in list_nodes(chain) if isinstance(node, Name)]
    words = list(dict.fromkeys([*spelled, *vocabulary]))
    search = MonomialSearch(names, words)
    for place, term in list_vector_terms(chain, index, names, words, search):
        yield LatexChange(
            ((place, place, term),), f"{term.strip()} after {_shorten(latex[:place][-24:])}"
        )
    ends, starts = _list_places(chain)
    for place, is_term in [*((end, True) for end in ends), *((start, False) for start in starts)][
        :MOST_PLACES
    ]:
        word = f" + {LACKING.spell()}" if is_term else f"{LACKING.spell()} "
        completed = LatexChange(((place, place, word),), "").apply(latex)
        values = _solve_for_lacking(completed, index, macros, names, 0.0 if is_term else 1.0)
        for product in search.find(values, None) if values is not None else ():
            is_negative = product.startswith("-")
            if is_term:
                text = f" {product}" if is_negative else f" + {product}"
                yield LatexChange(
                    ((place, place, text),), f"{text.strip()} after {_shorten(latex[:place][-24:])}"
                )
            elif not is_negative:
                yield LatexChange(
                    ((place, place, f"{product} "),), f"{product} on {_shorten(latex[place:])}"
                )


def _list_places(chain: RelationChain) -> tuple[list[int], list[int]]:
    """List the ends of sums, at which a term may be lacking, and the starts of terms, at which a
    factor may be.
    """
    parts: list[Node] = [side for side in chain.sides if not isinstance(side, Heading)]
    for node in list_nodes(chain):
        if isinstance(node, Bracket):
            parts += node.parts
        elif isinstance(node, Matrix):
            parts += [entry for row in node.rows for entry in row]
        elif isinstance(node, Quotient):
            parts += [node.above, node.below]
    terms = [
        term
        for part in parts
        for _, term in (part.terms if isinstance(part, Sum) else ((1, part),))
    ]
    return list(dict.fromkeys(part.end for part in parts)), list(
        dict.fromkeys(term.start for term in terms)
    )


def _solve_for_lacking(
    latex: str, index: int, macros: Mapping[str, tuple[int, str]], names: PointNames, neutral: float
) -> Any:
    """Return the values (points,) of what is lacking for a residual to vanish, None if there are
    none.
    """
    try:
        chain = read_formula(latex, macros)
        count = len(names.points)
        before, now = np.full(count, neutral), np.full(count, neutral + 1.0)
        gap_before, size = _evaluate_gap(chain, index, _Completed(names, before))
        for _ in range(ITERATIONS):
            gap, _ = _evaluate_gap(chain, index, _Completed(names, now))
            if np.all(np.abs(gap) <= SOLVED * size):
                return now
            with np.errstate(all="ignore"):
                step = gap * (now - before) / (gap - gap_before)
            if not np.all(np.isfinite(step)):
                return None
            before, now, gap_before = now, now - step, gap
    except UNREADABLE:
        return None
    return None


def _evaluate_gap(chain: RelationChain, index: int, names: PointNames) -> tuple[Any, Any]:
    """Return a residual at the points (points,), and the size of what it is the difference of."""
    with np.errstate(all="ignore"):
        _, _, left, right = Interpreter(names, []).read(chain).residuals(names)[index]
        first, second = (np.asarray(side.value, dtype=float) for side in (left, right))
        return first - second, np.maximum(np.abs(first), np.abs(second))


def _sign_groups(
    latex: str,
    index: int,
    chain: RelationChain,
    macros: Mapping[str, tuple[int, str]],
    names: StatedNames,
    draw: Callable[[int], Sequence[Point]],
) -> Iterator[LatexChange]:
    """Yield other signs of several terms: of the outermost sums, then of the innermost ones.

    A residual is linear in the signs of such terms. Its part that a sign turns is half of what it
    changes by when the sign does; the combination of those parts that vanishes at more points than
    there are parts gives the signs.
    """
    for terms in _list_signed_terms(chain):
        if not 1 < len(terms) <= MOST_SIGNS:
            continue
        flips = [_flip(latex, term) for term in terms]
        try:
            at_points = PointNames(names, draw(len(terms) + 1 + SPARE))
            gap, _ = _evaluate_gap(chain, index, at_points)
            changed = [
                read_formula(LatexChange((flip,), "").apply(latex), macros) for flip in flips
            ]
            parts = np.array(
                [(gap - _evaluate_gap(other, index, at_points)[0]) / 2 for other in changed]
            )
        except UNREADABLE:
            continue
        wrong = _find_wrong_signs(np.vstack([parts, gap - parts.sum(axis=0)]))
        if wrong:
            where = ", ".join(_shorten(latex[terms[place].start :]) for place in wrong)
            yield LatexChange(tuple(flips[place] for place in wrong), f"other signs of {where}")


def _list_signed_terms(chain: RelationChain) -> tuple[list[Node], list[Node]]:
    """List the terms of the sides of a row, and the terms of all its sums that contain no other
    sum.
    """
    sums = [node for node in list_nodes(chain) if isinstance(node, Sum)]
    sides = [
        term
        for side in chain.sides
        for term in ([t for _, t in side.terms] if side in sums else [side])
    ]
    inner = [
        t
        for some in sums
        for _, t in some.terms
        if not any(isinstance(part, Sum) for part in list_nodes(t))
    ]
    return sides, inner


def _flip(latex: str, term: Node) -> tuple[int, int, str]:
    """Return the piece of a change that gives a term the other sign."""
    before = re.search(r"([+\-\u2212])(?:\s|\\\\|\\[,;:!]|&)*$", latex[: term.start])
    if before is None:
        return term.start, term.start, "-"
    return before.start(1), before.end(1), "-" if before.group(1) == "+" else "+"


def _find_wrong_signs(parts: Any) -> list[int]:
    """Return the fewest parts, but not the last, that need another sign to add up to zero: indices
    of (parts, points).

    Nothing unless the parts have a single combination that vanishes, and all of one size in it.
    """
    sizes = np.linalg.norm(parts, axis=1)
    used = np.flatnonzero(sizes > DEPENDENT * sizes.max(initial=0))
    if len(used) < 2 or not np.all(np.isfinite(parts)):
        return []
    _, lengths, rows = np.linalg.svd((parts[used] / sizes[used, None]).T)
    if lengths[-1] > DEPENDENT or lengths[-2] <= np.sqrt(DEPENDENT):
        return []
    shares = rows[-1] / sizes[used]
    signs = np.sign(shares)
    if np.ptp(np.abs(shares)) > np.sqrt(DEPENDENT) * np.abs(shares).max():
        return []
    last = len(parts) - 1
    groups = [[int(place) for place in used[signs == sign]] for sign in (-1, 1)]
    return min(
        (group for group in groups if last not in group), key=lambda group: (len(group), 0 in group)
    )
