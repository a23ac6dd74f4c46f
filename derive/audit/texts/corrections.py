"""Corrections of a formula in its own LaTeX: small changes of the source, tried at points of the
motion.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import chain as joined
from typing import Any

import numpy as np

from ...evaluate import Point
from ..paper import Repair
from ..terms import holds
from .changes import (
    FURTHER,
    LIKELY,
    LatexChange,
    PrintedFormula,
    change_at,
    change_to_unlike_names,
)
from .formula import (
    Bracket,
    FormulaError,
    FunctionCall,
    Heading,
    Magnitude,
    Matrix,
    Name,
    Node,
    Quotient,
    RelationChain,
    Sum,
    Symbol,
    build_sum,
    list_nodes,
    read_formula,
    read_terms,
    tokenize_formula,
)
from .interpretation import Interpreter, interpret_formula, list_scalars
from .monomials import MonomialSearch, list_vector_terms
from .names import PointNames, StatedNames
from .values import Scalar, Value

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
UNREADABLE = (TypeError, ValueError, ZeroDivisionError, RecursionError, IndexError)
"""Errors of a formula that cannot be read or evaluated."""
MOST_CANDIDATES = 20_000
SOLVED = 1e-13
"""Residual at which what is lacking has been found, as a share of the sides."""
MOST_TOKENS = 400_000
"""Tokens of all candidates of a group of changes, each of which is read again: fewer candidates of
a longer row.
"""


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
    words = list(dict.fromkeys([*vocabulary, *in_row]))
    outcomes, memory = {} if outcomes is None else outcomes, _Memory()
    try:
        printed = PrintedFormula.read(latex, macros, names, words)
        before = _outcomes(printed.chain, at_points, _Memory())
    except UNREADABLE:
        return None
    if before is None or not index < len(before):
        return None
    is_mixed = _mixes_units(printed.chain, index, names)
    rereader = Rereader(latex, printed.chain, macros, memory.brackets)
    changes: list[tuple[tuple[int, bool], LatexChange]] = []
    seen_sources: set[str] = {latex}
    limit = min(MOST_CANDIDATES, MOST_TOKENS // len(tokenize_formula(latex, macros)))
    tiers = (
        joined.from_iterable(changes(printed) for changes in LIKELY),
        joined.from_iterable(changes(printed) for changes in FURTHER),
        _sign_groups(printed, index, macros, draw),
        _list_completions(printed, index, macros, at_points),
        change_to_unlike_names(printed),
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
                failing = sum(not holds_now for holds_now in after)
                changes.append(((failing, _touches_subject(change, printed.chain)), change))
        if changes:
            first, *rest = (change for _, change in sorted(changes, key=lambda pair: pair[0]))
            return Repair(first.apply(latex), first.text, tuple(change.text for change in rest))
    return None


def _touches_subject(change: LatexChange, chain: RelationChain) -> bool:
    """Return whether a change is one of the name alone that a row gives."""
    subject = chain.sides[0]
    starts = [start for start, _, _ in change.pieces]
    return isinstance(subject, Name) and len(starts) == 1 and starts[0] <= subject.end


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
    except UNREADABLE:
        return False
    residual = left.value - right.value
    if relation != "=" or ((left + (-right)).mixed and not is_mixed):
        return False
    if residual == 0:
        sides = {"".join(latex[side.start : side.end].split()) for side in chain.sides}
        named = [node.symbol for node in list_nodes(chain) if isinstance(node, Name)]
        says = (names.is_computed(s) or s.base.spell() in names.abbreviations for s in named)
        return len(sides) > 1 and any(says)
    return holds(residual, tuple(points))


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
    printed: PrintedFormula,
    index: int,
    macros: Mapping[str, tuple[int, str]],
    names: PointNames,
) -> Iterator[LatexChange]:
    """Yield terms and factors that the row lacks at any place, found by the values that they should
    have.
    """
    spelled = [node.symbol.spell() for node in printed.named]
    words = list(dict.fromkeys([*spelled, *printed.vocabulary]))
    search = MonomialSearch(names, words)
    for place, term in list_vector_terms(printed.chain, index, names, words, search):
        yield change_at(place, place, term, _describe_term(printed, place, term))
    ends, starts = _list_places(printed)
    for place, is_term in [*((end, True) for end in ends), *((start, False) for start in starts)][
        :MOST_PLACES
    ]:
        word = f" + {LACKING.spell()}" if is_term else f"{LACKING.spell()} "
        completed = change_at(place, place, word, "").apply(printed.latex)
        values = _solve_for_lacking(completed, index, macros, names, 0.0 if is_term else 1.0)
        for product in search.find(values, None) if values is not None else ():
            is_negative = product.startswith("-")
            if is_term:
                sign = "-" if is_negative else "+"
                text = f" {sign} {product.removeprefix('-').strip()}"
                yield change_at(place, place, text, _describe_term(printed, place, text))
            elif not is_negative:
                text = f"{product} on {printed.show(place)}"
                yield change_at(place, place, f"{product} ", text)


def _describe_term(printed: PrintedFormula, place: int, term: str) -> str:
    before = [node.start for node in printed.terms if node.end == place]
    return f"{term.strip()} after {printed.show(max(before, default=max(place - 24, 0)), place)}"


def _list_places(printed: PrintedFormula) -> tuple[list[int], list[int]]:
    """List the ends of sums, at which a term may be lacking, and the starts of terms, at which a
    factor may be.
    """
    parts = [side for side in printed.chain.sides if not isinstance(side, Heading)]
    for node in printed.nodes:
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
    parts.sort(key=lambda part: isinstance(part, Name))  # a name alone is what the row gives
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
    printed: PrintedFormula,
    index: int,
    macros: Mapping[str, tuple[int, str]],
    draw: Callable[[int], Sequence[Point]],
) -> Iterator[LatexChange]:
    """Yield other signs of several terms: of the outermost sums, then of the innermost ones.

    A residual is linear in the signs of such terms. Its part that a sign turns is half of what it
    changes by when the sign does; the combination of those parts that vanishes at more points than
    there are parts gives the signs.
    """
    for terms in _list_signed_terms(printed):
        if not 1 < len(terms) <= MOST_SIGNS:
            continue
        flips = [_flip(printed.latex, term) for term in terms]
        try:
            at_points = PointNames(printed.names, draw(len(terms) + 1 + SPARE))
            gap, _ = _evaluate_gap(printed.chain, index, at_points)
            flipped = [LatexChange((flip,), "").apply(printed.latex) for flip in flips]
            changed = [read_formula(latex, macros) for latex in flipped]
            parts = np.array(
                [(gap - _evaluate_gap(other, index, at_points)[0]) / 2 for other in changed]
            )
        except UNREADABLE:
            continue
        wrong = _find_wrong_signs(np.vstack([parts, gap - parts.sum(axis=0)]))
        if wrong:
            where = ", ".join(printed.show(terms[place].start) for place in wrong)
            yield LatexChange(tuple(flips[place] for place in wrong), f"other signs of {where}")


def _list_signed_terms(printed: PrintedFormula) -> tuple[list[Node], list[Node]]:
    """List the terms of the sides of a row, and the terms of all its sums that contain no other
    sum.
    """
    sums = [node for node in printed.nodes if isinstance(node, Sum)]
    sides: list[Node] = []
    for side in printed.chain.sides:
        sides += [term for _, term in side.terms] if isinstance(side, Sum) else [side]
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


class Rereader:
    """Reads what small changes make of a formula, by the tree that it was read as.

    A formula is read as a whole after a change between its terms, and with macros, plus-minus signs
    or bars in it: what these mean does not stand in a term alone. ``brackets`` are those of
    `read_formula`.
    """

    def __init__(
        self,
        latex: str,
        chain: RelationChain,
        macros: Mapping[str, tuple[int, str]],
        brackets: dict[tuple[str, ...], Bracket],
    ) -> None:
        self.latex, self.chain, self.macros, self.brackets = latex, chain, macros, brackets
        is_plain = not any(token.fixed for token in tokenize_formula(latex, macros))
        for node in list_nodes(chain):
            is_signed = isinstance(node, Sum) and any(abs(sign) == 2 for sign, _ in node.terms)
            is_plain = is_plain and not is_signed and not isinstance(node, Magnitude)
        parts = _list_parts(chain) if is_plain else ()
        self._parts = sorted(parts, key=lambda part: part.end - part.start)

    def read(self, pieces: Sequence[tuple[int, int, str]], changed: str) -> RelationChain:
        """Return the tree of a changed source; ``pieces`` are the ranges that changed.

        Raises FormulaError.
        """
        first, last = min(start for start, _, _ in pieces), max(end for _, end, _ in pieces)
        part = next(
            (part for part in self._parts if part.start <= first and last <= part.end), None
        )
        source = changed[part.start : part.end + len(changed) - len(self.latex)] if part else ""
        if (
            part is None or source.strip() == "t" or source.strip().isdigit()
        ):  # x(t), x(0) are no products
            return read_formula(changed, self.macros, self.brackets)
        try:
            terms = read_terms(source, self.macros, self.brackets)
        except FormulaError:
            return read_formula(changed, self.macros, self.brackets)
        tree: RelationChain = _replace_part(self.chain, part, terms)
        return tree


def _list_parts(chain: RelationChain) -> Iterator[Node]:
    """Yield what is read up to a sign, a relation or the end of a bracket, whatever stands before
    it.
    """
    yield from (side for side in chain.sides if not isinstance(side, Heading))
    for node in list_nodes(chain):
        if isinstance(node, Bracket):
            yield from node.parts
        elif isinstance(node, FunctionCall):
            yield from node.arguments
        elif isinstance(node, Sum) and len(node.terms) > 1:
            yield from (term for _, term in node.terms)


def _replace_part(tree: Any, part: Node, new: tuple[tuple[int, Node], ...]) -> Any:
    """Return a tree with signs and terms in the place of a part; those in a sum become signs and
    terms of that.
    """
    if tree is part:
        return build_sum(part.start, new, part.end)
    if isinstance(tree, tuple):
        return tuple(_replace_part(entry, part, new) for entry in tree)
    if not isinstance(tree, Node) or not (tree.start <= part.start and part.end <= tree.end):
        return tree
    if isinstance(tree, Sum) and any(term is part for _, term in tree.terms):
        terms: list[tuple[int, Node]] = []
        for sign, term in tree.terms:
            (first_sign, first), *rest = new if term is part else ((1, term),)
            terms += [(sign * first_sign, first), *rest]
        return replace(tree, terms=tuple(terms))
    values = {field.name: getattr(tree, field.name) for field in fields(tree)}
    return type(tree)(**{name: _replace_part(value, part, new) for name, value in values.items()})
