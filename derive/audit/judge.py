"""Holds a printed equation against its derivation: the verdict, the smallest correction, the missing terms."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import mpmath
from sympy import Expr

from ..dimensions import is_consistent
from ..equations import Equation, Unclaimed
from ..evaluate import Point
from ..quantity import Quantity
from .comparison import FLIPPED, Comparison, aligned, list_orientations
from .definition import defined
from .difference import lacking
from .edits import Edit
from .independent import explained
from .judgement import UNJUDGED, Judgement
from .terms import Points, value
from .unclaimed import held
from .wording import Said, joined

PROMISING = 12
"""First edits that a second one is tried on."""
MOST_OF_A_CONDITION = 2
"""Edits of a condition: more of them make any condition any other."""


def judge(
    printed: Equation,
    derived: Equation | None,
    points: Sequence[Point],
    words: Iterable[Quantity],
    directions: frozenset[Quantity] = frozenset(),
) -> Judgement:
    """The verdict on one equation, both sides in the same symbols; a direction is the same a whole turn on."""
    if derived is None:
        return held(printed, tuple(points), words) if isinstance(printed.claims, Unclaimed) else defined(printed)
    if printed.legibility == "lost":
        return Judgement("reconstructed", "the print is lost; the derivation stands alone")
    consistent, at = is_consistent(printed.residual), tuple(points)
    if unknown := sorted(str(s) for s in printed.residual.free_symbols if any(s not in point for point in at)):
        return Judgement(UNJUDGED, f"{', '.join(unknown)} has no value here, and nothing says what it stands for")
    is_direction, remark = printed.defines in directions, "" if consistent else "not dimensionally consistent; "
    compared = [(side, aligned(side, derived, at, is_direction)) for side in list_orientations(printed)]
    edits = [_relation(side, printed, derived) for side, comparison in compared if comparison.same]
    if () in edits and consistent:
        return _agreement(printed, derived)
    if edits and () not in edits:
        return Judgement("misprint", "the relation is another", (edits[0],))
    known = _vocabulary(printed, derived, at, words)
    found = [_corrected(comparison, known, _relation(side, printed, derived), remark) for side, comparison in compared]
    return min(found, key=lambda judgement: judgement.severity)


def _relation(side: Equation, printed: Equation, derived: Equation) -> tuple[Said, ...]:
    """The edit of the relation that a side needs, if any, in terms of the print."""
    if side.relation == derived.relation:
        return ()
    meant = derived.relation if side is printed else FLIPPED[derived.relation]
    return (Said(f"{meant} for {printed.relation}"),)


def _vocabulary(printed: Equation, derived: Equation, points: Points, words: Iterable[Quantity]) -> list[Quantity]:
    """Quantities that may have been meant: those of both papers and derivation that have a value."""
    known = {*words, *(s for s in derived.residual.free_symbols if isinstance(s, Quantity))} - {printed.defines}
    return sorted((s for s in known if all(s in point for point in points)), key=str)


def _agreement(printed: Equation, derived: Equation) -> Judgement:
    if derived.stated:
        return Judgement("untested", "so its symbols are meant; nothing here can test it")
    if printed.rebuilt:
        return Judgement("confirmed as rebuilt", "no difference left in what was read and rebuilt")
    return Judgement("confirmed", "no difference left")


def _corrected(start: Comparison, words: list[Quantity], done: tuple[Said, ...], remark: str) -> Judgement:
    """The verdict on a difference; ``done`` are edits that are needed beside those of the residual."""
    first = start.edits(words)
    exact = [edit for edit in first if _solves(start, edit)]
    if exact:
        return _misprint([(*done, edit.what) for edit in exact], remark, exact[:1])
    missing = lacking(start, words) if not done else ()
    if missing:
        return Judgement("incomplete", f"{remark}terms of the derivation are missing", missing=missing)
    found = explained(start, first, words)
    if found.comparison.same and not (start.bounds and len(found.edits) > MOST_OF_A_CONDITION):
        return _misprint([(*done, *(edit.what for edit in found.edits))], remark, found.edits)
    pairs = _pairs(start, first, words) if found.comparison.gap.unexplained and not done else []
    if pairs:
        return _misprint([(one.what, two.what) for one, two in pairs], remark, pairs[0])
    if start.bounds:
        return _another_condition(start, remark)
    return _left_over(found.comparison, (*done, *(edit.what for edit in found.edits)), found.edits, remark)


def _another_condition(start: Comparison, remark: str) -> Judgement:
    """A condition that no edit makes the derived one; terms that are left over say nothing of when it holds."""
    where = next((point for point in start.points if not start.equal_at(point)), start.points[0])
    given, meant = (_shown(side, where) for side in (start.printed, start.derived))
    finding = (
        f"{remark}another condition than the derived one; at a random point its sides differ by {given}, not {meant}"
    )
    return Judgement("contradicted", finding, unexplained=(start.printed,))


def _pairs(start: Comparison, first: list[Edit], words: list[Quantity]) -> list[tuple[Edit, Edit]]:
    """Two edits that remove the difference together, the first of them one of those that leave least."""
    tried = [edit for edit, _ in _ranked(start, first)[:PROMISING]]
    return [(one, two) for one in tried for two in start.edited(one.result).edits(words) if _solves(start, two)]


def _misprint(corrections: Sequence[tuple[Said, ...]], remark: str, edits: Sequence[Edit]) -> Judgement:
    distinct = tuple(dict.fromkeys(tuple(sorted(c)) for c in corrections))
    return Judgement("misprint", f"{remark}removed by {len(distinct[0])} edit(s)", distinct, edits=tuple(edits))


def _left_over(found: Comparison, done: tuple[Said, ...], edits: tuple[Edit, ...], remark: str) -> Judgement:
    """What the print lacks after the edits that explain its terms, or what in it has no explanation."""
    corrections, left = (tuple(sorted(done)),) if done else (), found.match()
    if not left.printed:
        finding = f"{remark}terms of the derivation are missing"
        return Judgement("incomplete", finding, corrections, left.derived, edits=edits)
    where = next((point for point in found.points if not found.equal_at(point)), found.points[0])
    given, meant = (_shown(side, where) for side in (found.printed, found.derived))
    fails = f"; it fails at a random point: {given} against {meant}"
    finding = Said(f"{remark}printed, but not derived: ", joined(", ", left.printed), fails)
    return Judgement("contradicted", finding, corrections, left.derived, left.printed, edits=edits)


def _shown(expr: Expr, point: Point) -> str:
    found = value(expr, point)
    return "no real value" if found is None else mpmath.nstr(found, 6)


def _solves(start: Comparison, edit: Edit) -> bool:
    try:
        return start.edited(edit.result).same
    except (ZeroDivisionError, ValueError):
        return False


def _ranked(start: Comparison, tried: Iterable[Edit]) -> list[tuple[Edit, int]]:
    """Edits that leave fewer terms without their like, best first. None may take a real value away."""
    real: Points = tuple(point for point in start.points if value(start.printed, point) is not None)
    before, better = start.gap.size, []
    for edit in tried:
        left = start.edited(edit.result).gap.size
        if left < before and all(value(edit.result, point) is not None for point in real):
            better.append((edit, left))
    return sorted(better, key=lambda pair: (pair[1], pair[0].what))
