"""Holds a printed equation against its derivation: the verdict, the smallest correction, the missing terms."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import mpmath
from sympy import Expr

from ..dimensions import DimensionError, dimension
from ..equations import Equation, Relation
from ..evaluate import DIGITS, GUARD, TOLERANCE, NotEvaluated, Point
from ..quantity import Quantity
from .edits import Edit, edits
from .terms import Match, expanded, largest_term, matched, overall_factor, remainder_vanishes, value
from .wording import Said, joined

Word = Literal["confirmed", "misprint", "incomplete", "contradicted", "reconstructed", "definition"]
PROMISING = 12
"""First edits that a second one is tried on."""
EDITS = 2
"""Most edits of a correction."""
FLIPPED: dict[Relation, Relation] = {"=": "=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}


@dataclass(frozen=True)
class Judgement:
    """A verdict with its evidence. ``missing`` are terms of the derivation that the print lacks."""

    verdict: Word
    finding: str
    corrections: tuple[tuple[str, ...], ...] = ()
    missing: tuple[Expr, ...] = ()
    unexplained: tuple[Expr, ...] = field(default=())


@dataclass(frozen=True)
class Comparison:
    """A printed and a derived residual on the same footing: same sign of what both solve for, same points.

    ``scales`` says whether a constant factor on the whole says nothing: it does where ``residual = 0`` defines no
    symbol, for that has the same solutions as any multiple of it, and where it does, the factor is what is printed.
    """

    printed: Expr
    derived: Expr
    points: list[Point]
    scales: bool = False

    @property
    def equal(self) -> bool:
        """Whether both have the same value at every point, to 50 digits of the largest term."""
        return all(self.equal_at(point) for point in self.points)

    def equal_at(self, point: Point) -> bool:
        given, meant = value(self.printed, point), point(self.derived)
        return given is not None and abs(given - meant) <= TOLERANCE * max(
            largest_term(self.derived, point), abs(given)
        )

    @property
    def proportional(self) -> bool:
        """Whether one is a constant multiple of the other, of the same sign, though neither is zero at any point."""
        first = None
        with mpmath.workdps(DIGITS + GUARD):
            for point in self.points:
                given, meant = value(self.printed, point), point(self.derived)
                if given is None or abs(meant) <= TOLERANCE * largest_term(self.derived, point) or given / meant <= 0:
                    return False
                first = first or given / meant
                if abs(given / meant - first) > TOLERANCE * first:
                    return False
        return True

    @property
    def same(self) -> bool:
        """Whether both say the same."""
        return self.equal or (self.scales and self.proportional)

    @property
    def distance(self) -> tuple[int, int]:
        """How far apart they are: by the printed terms that are not derived, then by those that are not printed."""
        if self.same:
            return 0, 0
        left = self.match()
        return 1 + len(left.printed), len(left.derived)

    def match(self) -> Match:
        found = matched(expanded(self.printed), expanded(self.derived), self.points)
        return Match((), ()) if remainder_vanishes(found, self.points) else found

    def edited(self, result: Expr) -> Comparison:
        return replace(self, printed=result)

    def scaled(self, factor: Expr) -> Comparison:
        return replace(self, derived=factor * self.derived)

    def edits(self, words: list[Quantity]) -> list[Edit]:
        return list(edits(self.printed, words, whole=not self.scales))


def judge(printed: Equation, derived: Equation | None, points: list[Point], words: Iterable[Quantity]) -> Judgement:
    """The verdict on one equation, both sides in the same symbols."""
    if derived is None:
        mixed = "" if _consistent(printed.residual) else "; not dimensionally consistent"
        return Judgement("definition", f"nothing to derive{mixed}")
    if printed.legibility == "lost":
        return Judgement("reconstructed", "the print is lost; the derivation stands alone")
    consistent = _consistent(printed.residual)
    faced = turned(printed, derived, points)
    comparison = aligned(faced, derived, points)
    meant = derived.relation if faced is printed else FLIPPED[derived.relation]
    relation = () if printed.relation == meant else (f"{meant} for {printed.relation}",)
    if comparison.same and consistent and not relation:
        return Judgement("confirmed", "no difference left")
    if comparison.same and relation:
        return Judgement("misprint", "the relation is another", (relation,))
    known = {*words, *(s for s in derived.residual.free_symbols if isinstance(s, Quantity))} - {printed.defines}
    remark = "" if consistent else "not dimensionally consistent; "
    return _corrected(comparison, sorted(known, key=str), relation, remark)


def turned(printed: Equation, derived: Equation, points: list[Point]) -> Equation:
    """A printed condition with its sides exchanged, if so it is closer to the derived one."""
    if printed.relation == "=":
        return printed
    other = replace(printed, residual=-printed.residual, relation=FLIPPED[printed.relation])
    return min((printed, other), key=lambda e: aligned(e, derived, points).distance)


def aligned(printed: Equation, derived: Equation, points: list[Point]) -> Comparison:
    """Both sides on one footing: what they define a symbol as, else residuals with the factor that leaves less."""
    symbol = printed.defines
    if symbol is not None and derived.defines == symbol:
        return Comparison(symbol - printed.residual, symbol - derived.residual, points)
    start = Comparison(printed.residual, derived.residual, points, scales=symbol is None)
    found = [start.scaled(sign) for sign in ((1, -1) if printed.relation == "=" else (1,))]
    best = min(found, key=lambda c: c.distance)
    if best.same or not best.scales:
        return best
    factor = overall_factor(expanded(best.printed), expanded(best.derived), points)
    return min(best, best.scaled(abs(factor)), key=lambda c: c.distance)


def facing(printed: Equation, derived: Equation, points: list[Point]) -> Equation:
    """The derived equation with the sign that leaves less against the printed one."""
    if printed.legibility == "lost" or derived.relation != "=" or derived.defines is not None:
        return derived
    return replace(derived, residual=aligned(printed, derived, points).derived)


def _corrected(start: Comparison, words: list[Quantity], done: tuple[str, ...], remark: str) -> Judgement:
    """The verdict on a difference; ``done`` are edits that are needed beside those of the residual."""
    first = start.edits(words)
    exact = [edit for edit in first if _solves(start, edit)]
    if exact:
        return _misprint([(*done, edit.what) for edit in exact], remark)
    found = start.match()
    ranked = _ranked(start, first, found)
    tried = ranked[:PROMISING] if len(done) + 2 <= EDITS else []
    pairs = [(one, two) for one, _ in tried for two in start.edited(one.result).edits(words) if _solves(start, two)]
    if pairs:
        return _misprint([(one.what, two.what) for one, two in pairs], remark)
    return _incomplete(start, found, ranked, words, list(done), remark)


def _misprint(corrections: Sequence[tuple[str, ...]], remark: str) -> Judgement:
    distinct = tuple(dict.fromkeys(tuple(sorted(c)) for c in corrections))
    return Judgement("misprint", f"{remark}removed by {len(distinct[0])} edit(s)", distinct)


def _incomplete(
    start: Comparison,
    found: Match,
    ranked: list[tuple[Edit, Match]],
    words: list[Quantity],
    done: list[str],
    remark: str,
) -> Judgement:
    """After up to two edits that explain printed terms: what the print lacks, or what in it has no explanation."""
    while found.printed and ranked and len(done) < EDITS:
        best, left = ranked[0]
        if len(left.printed) >= len(found.printed):
            break
        done.append(best.what)
        start, found = start.edited(best.result), left
        ranked = _ranked(start, start.edits(words), found) if len(done) < EDITS else []
    corrections = (tuple(done),) if done else ()
    if not found.printed:
        return Judgement("incomplete", f"{remark}terms of the derivation are missing", corrections, found.derived)
    where = next((point for point in start.points if not start.equal_at(point)), start.points[0])
    given, meant = (_shown(side, where) for side in (start.printed, start.derived))
    fails = f"; it fails at a random point: {given} against {meant}"
    finding = Said(f"{remark}printed, but not derived: ", joined(", ", found.printed), fails)
    return Judgement("contradicted", finding, corrections, found.derived, found.printed)


def _shown(expr: Expr, point: Point) -> str:
    found = value(expr, point)
    return "no real value" if found is None else mpmath.nstr(found, 6)


def _solves(start: Comparison, edit: Edit) -> bool:
    try:
        return start.edited(edit.result).same
    except (NotEvaluated, ZeroDivisionError, ValueError):
        return False


def _ranked(start: Comparison, tried: Iterable[Edit], before: Match) -> list[tuple[Edit, Match]]:
    """Edits that leave less of the print unexplained, best first. None may take a real value away."""
    real = [point for point in start.points if value(start.printed, point) is not None]
    better: list[tuple[Edit, Match]] = []
    for edit in tried:
        try:
            if any(value(edit.result, point) is None for point in real):
                continue
            left = start.edited(edit.result).match()
        except (NotEvaluated, ZeroDivisionError, ValueError):
            continue
        if len(left.printed) < len(before.printed) or len(left.derived) < len(before.derived):
            better.append((edit, left))
    return sorted(better, key=lambda pair: (len(pair[1].printed) + len(pair[1].derived), pair[0].what))


def _consistent(residual: Expr) -> bool:
    try:
        dimension(residual)
    except DimensionError:
        return False
    return True
