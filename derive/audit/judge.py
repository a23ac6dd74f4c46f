"""Judgement of a printed equation: the verdict, the smallest correction, the missing terms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from itertools import islice
from typing import Any, Literal

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..equations import UNCLAIMED, Equation, Witness
from ..evaluate import NotEvaluated, Point, UnknownNodeError
from ..quantity import Quantity, is_consistent
from .comparison import (
    FLIPPED,
    Comparison,
    align_sides,
    are_equivalent,
    explain_by_edits,
    find_missing_terms,
    list_orientations,
    solve_for,
)
from .edits import SCREEN, Edit, EditValues, is_computable, propose_edits, screen_edits
from .products import ProductFactor, ProductSearch
from .terms import Points, evaluate_at, format_value, holds, largest_term, list_unknown
from .typesetting import Said, join_parts

Word = Literal[
    "confirmed",
    "confirmed as rebuilt",
    "untested",
    "misprint",
    "incomplete",
    "contradicted",
    "reconstructed",
    "definition",
    "not judged",
]
FAULTS: tuple[Word, ...] = ("misprint", "incomplete", "contradicted")
"""Verdicts that find fault with a print, the slightest first."""
UNJUDGED: Word = "not judged"
"""The verdict on an equation that stops the judge; its finding says why."""


@dataclass(frozen=True)
class Judgement:
    """A verdict with its evidence.

    ``missing`` are terms that the print lacks, of the derivation if there is one.

    ``domain`` says where an equation does not hold that holds at all angles that the machine uses,
    and is empty elsewhere. ``loose`` is what must vanish where a thing is held and does not, by its name;
    ``edits`` are those of the first correction, with what they replace, and ``ways`` those of all.
    They change ``start``: a residual, or what it says that a symbol is. ``edited`` is the residual
    that they leave, and ``corrected`` the print with it and with the terms that it lacks.
    ``edited`` and ``missing`` without ``unexplained`` are the derivation.
    """

    verdict: Word
    finding: str
    corrections: tuple[tuple[str, ...], ...] = ()
    missing: tuple[Expr, ...] = ()
    unexplained: tuple[Expr, ...] = field(default=())
    loose: Mapping[str, Expr] = field(default_factory=dict, hash=False)
    domain: str = ""
    edits: tuple[Edit, ...] = field(default=(), compare=False)
    ways: tuple[tuple[Edit, ...], ...] = field(default=(), compare=False)
    start: Expr | None = field(default=None, compare=False)
    edited: Expr | None = field(default=None, compare=False)
    corrected: Equation | None = field(default=None, compare=False)

    @property
    def severity(self) -> tuple[int, int, int]:
        """Return the key by which a judgement is milder: its verdict, the terms left over, the
        edits needed.
        """
        grades = ("", *FAULTS, UNJUDGED)
        grade = grades.index(self.verdict) if self.verdict in grades else 0
        needed = min(map(len, self.corrections), default=0)
        return grade, len(self.missing) + len(self.unexplained), needed


def explain_unjudged(error: Exception) -> Judgement:
    """Return the judgement on an equation of which judging raised an error, with the reason in
    words.
    """
    text = " ".join(str(error).split())
    plain = isinstance(error, NotEvaluated | UnknownNodeError)
    return Judgement(UNJUDGED, text if plain else f"{type(error).__name__}: {text}")


def judge_definition(printed: Equation) -> Judgement:
    """The verdict on a definition: whether it gives what else the paper says of its symbols, and
    untested without.
    """
    mixed = "" if is_consistent(printed.residual) else "; not dimensionally consistent"
    against = [
        witness for witness in printed.witnesses if not agrees_with_witness(printed, witness)
    ]
    if against:
        return Judgement("contradicted", "; ".join(map(_describe_witness, against)) + mixed)
    if printed.witnesses:
        return Judgement(
            "definition", f"agrees with {', '.join(w.where for w in printed.witnesses)}{mixed}"
        )
    return Judgement(
        "untested", f"nothing to derive, and nothing else in the paper tests it{mixed}"
    )


def agrees_with_witness(printed: Equation, witness: Witness) -> bool:
    """Whether a definition gives the printed value, to the last digit that is printed, of what it
    defines.
    """
    values = {symbol: mpf(digits) for symbol, digits in witness.values}
    missing = printed.residual.free_symbols - values.keys()
    if bounded := [bounds for bounds in witness.between if missing == {bounds[0]}]:
        return _agrees_within(printed, witness, *bounded[0])
    if missing:
        raise ValueError(
            f"{printed.source}: {witness.where} prints nothing of "
            f"{', '.join(sorted(map(str, missing)))}"
        )
    digits = dict(witness.values)
    first, _ = witness.values[0]  # decides where none is defined
    last = mpf(10) ** int(Decimal(digits.get(printed.defines or first, "0")).as_tuple().exponent)
    return bool(abs(Point(values)(printed.residual)) <= last / 2)


def _agrees_within(
    printed: Equation, witness: Witness, symbol: Quantity, low: Expr, high: Expr
) -> bool:
    """Whether a definition holds for some value between the bounds of the one symbol without a
    printed value.
    """
    values = {other: sp.Rational(digits) for other, digits in witness.values}
    roots = sp.solve(printed.residual.xreplace(values), symbol)
    smallest, largest = (bound.xreplace(values) for bound in (low, high))
    return any(root.is_real and smallest <= root <= largest for root in roots)


def _describe_witness(witness: Witness) -> str:
    values = ", ".join(f"{symbol} = {digits}" for symbol, digits in witness.values)
    return f"against {witness.where}: {values}"


def describe_dimensions(printed: Equation) -> str:
    """Return the beginning of a finding on an equation that mixes dimensions, else nothing."""
    return "" if is_consistent(printed.residual) else "not dimensionally consistent; "


MOST_OPERATIONS = 1000
"""Operations of an equation of which several edits are tried together: what vector algebra expanded
was not printed.
"""
MOST_SEARCHED = 10_000
"""Operations of an equation of which single edits and missing terms are tried."""
UNSEARCHED = (
    f"; its terms were not searched for an error, as they have more than {MOST_SEARCHED} operations"
)


def judge_by_values(printed: Equation, points: Points, words: Iterable[Quantity]) -> Judgement:
    """The verdict on an equation by values alone: whether it holds at every point, or which single
    edits make it.
    """
    lacking = list_unknown(printed.residual, points)
    if lacking or printed.relation != "=":
        reason = (
            f"{', '.join(lacking)} has no value here" if lacking else "a condition without a claim"
        )
        return Judgement("untested", f"{reason}, so that nothing tests it")
    if holds(printed.residual, points):
        return Judgement("confirmed", "it holds at every point that was tried")
    remark = describe_dimensions(printed)
    is_large = sp.count_ops(printed.residual) > MOST_SEARCHED
    edited = () if is_large else _edited(printed, words, points)
    repairs = [(edit, residual) for edit, residual in edited if holds(residual, points)]
    if repairs:
        corrected = replace(printed, residual=repairs[0][1])
        judgement = _misprint([(edit,) for edit, _ in repairs], (), remark)
        return replace(judgement, corrected=corrected)
    for term, residual in () if is_large else _list_lacking_terms(printed, words, points):
        corrected = replace(printed, residual=residual)
        finding = Said(f"{remark}it holds with a term more: ", term)
        return Judgement("incomplete", finding, missing=(term,), corrected=corrected)
    unsearched = UNSEARCHED if is_large else ""
    return Judgement(
        "contradicted", Said(f"{remark}{_failing(printed.residual, points)}{unsearched}")
    )


def judge_condition(printed: Equation, cycle: Sequence[Point]) -> Judgement:
    """The verdict on a condition by values alone: whether it holds all along the machine's own
    cycle.
    """
    residual = printed.residual
    values = [] if list_unknown(residual, cycle) else [evaluate_at(residual, p) for p in cycle]
    if not values or None in values:
        return Judgement("untested", "it has no value along the cycle, so that nothing tests it")
    order = {"<": mpf.__lt__, "<=": mpf.__le__, ">": mpf.__gt__, ">=": mpf.__ge__}[printed.relation]
    worst = (max if printed.relation in ("<", "<=") else min)(v for v in values if v is not None)
    share = mpmath.nstr(worst, 4)
    if all(order(value, mpf(0)) for value in values if value is not None):
        return Judgement(
            "confirmed",
            f"it holds all along the cycle: left less right is {share} at the most critical",
        )
    broken = sum(not order(value, mpf(0)) for value in values if value is not None)
    finding = (
        f"it fails at {broken} of {len(values)} places of the cycle: left less right "
        f"reaches {share}"
    )
    return Judgement("contradicted", finding, unexplained=(printed.residual,))


def _edited(
    printed: Equation, words: Iterable[Quantity], points: Points
) -> Iterator[tuple[Edit, Expr]]:
    """Edits that may be corrections, with the residuals that they leave, but for those that leave
    nothing to say.
    """
    candidates = [word for word in words if not list_unknown(word, points)]
    symbol = printed.defines
    side = solve_for(printed.residual, symbol)
    meant = np.array([float(point(symbol or sp.S.Zero)) for point in points])

    def may_hold(values: Any, sizes: Any) -> bool:
        limit = SCREEN * np.maximum(sizes, np.abs(meant))
        return bool(np.all(np.abs(values - meant) <= limit))

    proposals = propose_edits(side, candidates, overall=symbol is not None)
    for proposal in screen_edits(side, proposals, points, may_hold):
        edit = proposal.apply(side)
        residual = _restore_residual(printed, edit.result)
        if len(sp.Add.make_args(residual)) > 1:
            yield edit, residual


def _restore_residual(printed: Equation, side: Expr) -> Expr:
    """Return the residual of an equation with another side; see `solve_for`."""
    return side if printed.defines is None else printed.defines - side


MOST_FACTORS = 120
"""Factors of an equation of which products are tried as the term that it lacks, those of its own
terms first.
"""


def _list_lacking_terms(
    printed: Equation, words: Iterable[Quantity], points: Points
) -> Iterator[tuple[Expr, Expr]]:
    """Terms with which an equation holds, products of up to five of its factors, with the residuals
    that they leave.
    """
    symbol = printed.defines
    side = solve_for(printed.residual, symbol)
    gaps = [evaluate_at((symbol or sp.S.Zero) - side, point) for point in points]
    if not is_computable(side) or None in gaps:
        return
    edits = EditValues(side, points)
    evaluable_words = [word for word in words if word != symbol and not list_unknown(word, points)]
    factors = [
        ProductFactor(factor, edits.value(factor), None, str(factor.as_base_exp()[0]))
        for factor in islice(dict.fromkeys((*_list_factors(side), *evaluable_words)), MOST_FACTORS)
        if np.all(np.isfinite(edits.value(factor)) & (edits.value(factor) != 0))
    ]
    for number, some in ProductSearch(factors, max_factors=5).find(
        [float(gap) for gap in gaps if gap is not None], None
    ):
        term = sp.Mul(
            sp.Rational(number.numerator, number.denominator), *(factor.label for factor in some)
        )
        residual = _restore_residual(printed, side + term)
        if len(sp.Add.make_args(residual)) > 1 and holds(residual, points):
            yield term, residual


def _list_factors(expr: Expr) -> Iterator[Expr]:
    """Yield the symbols, functions and powers of an expression, and the sums in its products."""
    for node in sp.preorder_traversal(expr):
        parts = (
            node.args
            if isinstance(node, sp.Mul)
            else (node,)
            if not isinstance(node, sp.Add)
            else ()
        )
        yield from (part for part in parts if not part.is_number and not isinstance(part, sp.Mul))


def _failing(residual: Expr, points: Points) -> str:
    """Describe the residual at the first point where the equation fails, compared with its largest
    term.
    """
    where = next(point for point in points if not holds(residual, (point,)))
    largest = mpmath.nstr(largest_term(residual, where), 6)
    return f"it does not hold: {format_value(residual, where)} is left of terms of up to {largest}"


PROMISING = 12
"""First edits that a second one is tried on."""
MOST_OF_A_CONDITION = 2
"""Edits of a condition: more of them make any condition any other."""


def judge_equation(
    printed: Equation,
    derived: Equation | None,
    points: Sequence[Point],
    words: Iterable[Quantity],
    directions: frozenset[Quantity] = frozenset(),
) -> Judgement:
    """The verdict on one equation, both sides in the same symbols; a direction is the same a whole
    turn on.
    """
    if derived is None:
        return (
            judge_by_values(printed, tuple(points), words)
            if printed.claims == UNCLAIMED
            else judge_definition(printed)
        )
    if printed.legibility == "lost":
        return Judgement("reconstructed", "the print is lost; the derivation stands alone")
    remark, at = describe_dimensions(printed), tuple(points)
    if unknown := list_unknown(printed.residual, at):
        return Judgement(
            UNJUDGED, f"{', '.join(unknown)} has no value here, and nothing says what it stands for"
        )
    is_direction = printed.defines in directions
    compared = [
        (side, align_sides(side, derived, at, is_direction)) for side in list_orientations(printed)
    ]
    edits = [_relation(side, printed, derived) for side, comparison in compared if comparison.same]
    if () in edits and not remark:
        return _agreement(printed, derived)
    if edits and () not in edits:
        return Judgement("misprint", "the relation is another", (edits[0],))
    size = sp.count_ops(printed.residual) + sp.count_ops(derived.residual)
    is_large = size > MOST_OPERATIONS and not holds(printed.residual, at)
    if is_large and size > MOST_SEARCHED:
        return Judgement(
            "contradicted", Said(f"{remark}{_failing(printed.residual, at)}{UNSEARCHED}")
        )
    vocabulary = _vocabulary(printed, derived, at, words)
    judgements = []
    for side, comparison in compared:
        done = _relation(side, printed, derived)
        judgement = _find_simple_correction(comparison, vocabulary, done, remark)
        if judgement is None and is_large:
            judgement = Judgement("contradicted", Said(f"{remark}{_failing(printed.residual, at)}"))
        elif judgement is None:
            judgement = _corrected(comparison, vocabulary, done, remark)
        edited = _find_edited(side, comparison, judgement)
        judgement = replace(judgement, start=comparison.printed, edited=edited)
        judgements.append(
            replace(judgement, corrected=complete_print(side, derived, judgement, at, is_direction))
        )
    return min(judgements, key=lambda judgement: judgement.severity)


def _find_edited(side: Equation, comparison: Comparison, judgement: Judgement) -> Expr:
    """Return the residual of a printed equation after the edits of a judgement."""
    edited = judgement.edits[-1].result if judgement.edits else comparison.printed
    symbol = side.defines
    is_solved = symbol is not None and comparison.printed == solve_for(side.residual, symbol)
    return symbol - edited if is_solved else edited


def complete_print(
    printed: Equation,
    derived: Equation,
    judgement: Judgement,
    points: Points,
    is_direction: bool = False,
) -> Equation | None:
    """Return a printed equation after the edits of a judgement, with the terms that it lacks, if
    that is all there is.

    A factor by which it was divided is put back.
    """
    if (
        judgement.edited is None
        or judgement.unexplained
        or not (judgement.edits or judgement.missing)
    ):
        return None
    total = sp.Add(*judgement.missing)
    residuals = (judgement.edited + sign * total for sign in (1, -1))
    completed = (replace(printed, residual=residual) for residual in residuals)
    return next(
        (some for some in completed if are_equivalent(some, derived, points, is_direction)), None
    )


def _relation(side: Equation, printed: Equation, derived: Equation) -> tuple[Said, ...]:
    """The edit of the relation that a side needs, if any, in terms of the print."""
    if side.relation == derived.relation:
        return ()
    meant = derived.relation if side is printed else FLIPPED[derived.relation]
    return (Said(f"{meant} for {printed.relation}"),)


def _vocabulary(
    printed: Equation, derived: Equation, points: Points, words: Iterable[Quantity]
) -> list[Quantity]:
    """Quantities that may have been meant: those of both papers and derivation that have a
    value.
    """
    quantities = {
        *words,
        *(s for s in derived.residual.free_symbols if isinstance(s, Quantity)),
    } - {printed.defines}
    return sorted((s for s in quantities if not list_unknown(s, points)), key=str)


def _agreement(printed: Equation, derived: Equation) -> Judgement:
    if derived.stated:
        return Judgement("untested", "so its symbols are meant; nothing here can test it")
    if printed.rebuilt:
        return Judgement("confirmed as rebuilt", "no difference left in what was read and rebuilt")
    return Judgement("confirmed", "no difference left")


def _find_simple_correction(
    start: Comparison, words: list[Quantity], done: tuple[Said, ...], remark: str
) -> Judgement | None:
    """The verdict on a difference that one edit or a missing term makes, None for any other; see
    `_corrected`.
    """
    repairs = start.repairs(words)
    if repairs:
        return _misprint([(edit,) for edit in repairs], done, remark)
    missing = find_missing_terms(start, words) if not done else ()
    if missing:
        return Judgement(
            "incomplete", f"{remark}terms of the derivation are missing", missing=missing
        )
    return None


def _corrected(
    start: Comparison, words: list[Quantity], done: tuple[Said, ...], remark: str
) -> Judgement:
    """The verdict on a difference; ``done`` are edits that are needed in addition to those of the
    residual.
    """
    first = start.edits(words)
    # a number has no parts of which some are right
    is_number = start.printed.is_Rational
    explained, edits = (start, ()) if is_number else explain_by_edits(start, first, words)
    correction = (*done, *(edit.text for edit in edits))
    if explained.same and not (start.bounds and len(edits) > MOST_OF_A_CONDITION):
        return _misprint([edits], done, remark)
    pairs = _pairs(start, first, words) if explained.struck().printed and not done else []
    if pairs:
        return _misprint(pairs, done, remark)
    if start.bounds:
        return _another_condition(start, remark)
    return _left_over(explained, correction, edits, remark)


def _another_condition(start: Comparison, remark: str) -> Judgement:
    """A condition that no edit makes the derived one; terms that are left over say nothing of when
    it holds.
    """
    printed, derived = _format_difference(start)
    differ = f"at a random point its sides differ by {printed}, not {derived}"
    finding = f"{remark}another condition than the derived one; {differ}"
    return Judgement("contradicted", finding, unexplained=(start.printed,))


def _pairs(start: Comparison, first: list[Edit], words: list[Quantity]) -> list[tuple[Edit, Edit]]:
    """Two edits that remove the difference together, the first of them one of those that leave
    least.
    """
    candidates = [edit for edit, _ in _ranked(start, first)[:PROMISING]]
    return [
        (first, second)
        for first in candidates
        for second in start.edited(first.result).repairs(words)
    ]


def _misprint(ways: Sequence[tuple[Edit, ...]], done: tuple[Said, ...], remark: str) -> Judgement:
    """Build the judgement on a print that each of several ways of edits corrects."""
    distinct = {tuple(sorted((*done, *(edit.text for edit in edits)))): edits for edits in ways}
    corrections, edits = tuple(distinct), tuple(distinct.values())
    finding = f"{remark}removed by {_count_edits(corrections[0])}"
    return Judgement("misprint", finding, corrections, edits=edits[0], ways=edits)


def _count_edits(correction: Sequence[Said]) -> str:
    return "1 edit" if len(correction) == 1 else f"{len(correction)} edits"


def _left_over(
    comparison: Comparison, done: tuple[Said, ...], edits: tuple[Edit, ...], remark: str
) -> Judgement:
    """Build the judgement on terms that edits leave: missing from the print, or without an
    explanation.
    """
    corrections, left = (tuple(sorted(done)),) if done else (), comparison.match()
    if not left.printed:
        finding = f"{remark}terms of the derivation are missing"
        return Judgement(
            "incomplete", finding, corrections, left.derived, edits=edits, ways=(edits,)
        )
    printed, derived = _format_difference(comparison)
    fails = f"; it fails at a random point: {printed} against {derived}"
    finding = Said(f"{remark}printed, but not derived: ", join_parts(", ", left.printed), fails)
    return Judgement(
        "contradicted",
        finding,
        corrections,
        left.derived,
        left.printed,
        edits=edits,
        ways=(edits,),
    )


def _format_difference(comparison: Comparison) -> tuple[str, str]:
    """Return the values of both sides at the first point where they differ."""
    different = (point for point in comparison.points if not comparison.is_equal_at(point))
    where = next(different, comparison.points[0])
    return format_value(comparison.printed, where), format_value(comparison.derived, where)


def _ranked(start: Comparison, candidates: Iterable[Edit]) -> list[tuple[Edit, int]]:
    """Edits that leave fewer terms without their like, best first.

    None may take a real value away.
    """
    real: Points = tuple(
        point for point in start.points if evaluate_at(start.printed, point) is not None
    )
    before, better = start.struck().size, []
    for edit in candidates:
        left = start.edited(edit.result).struck().size
        if left < before and all(evaluate_at(edit.result, point) is not None for point in real):
            better.append((edit, left))
    return sorted(better, key=lambda pair: (pair[1], pair[0].text))
