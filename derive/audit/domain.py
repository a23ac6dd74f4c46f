"""Where an equation is used: what holds all along the machine's own cycle, and near it, holds for the machine.

A rewriting may hold on one branch alone, as that of an angle in one quadrant. Equality on the cycle is not enough to
confirm it, since a datum that is zero there hides a wrong term: it must hold for data and places near those of the
cycle too, where nothing is special.
"""

from __future__ import annotations

import mpmath
import sympy as sp

from ..dimensions import is_consistent
from ..equations import Equation
from ..evaluate import Point
from .case import Case
from .comparison import say_the_same, solved
from .judgement import FAULTS, Judgement
from .terms import Points, value
from .unclaimed import holds
from .wording import Piece, Said, joined

SHOWN = 3
"""Symbols of which a remark gives the values."""


def confirm_in_use(case: Case, printed: Equation, derived: Equation | None, found: Judgement) -> Judgement:
    """Return the judgement, or that the equation holds where the machine uses it, with a place where it does not."""
    if found.verdict not in FAULTS or not is_consistent(printed.residual):
        return found
    where = sp.true if derived is None else derived.where
    for points in (case.cycle, case.nearby):
        if not _says_the_same(case, printed, derived, [point for point in points if point.holds(where)]):
            return found
    outside = next((p for p in case.points_where(where) if not _says_the_same(case, printed, derived, [p])), None)
    if outside is None:
        return found
    domain = _describe_failure(printed, derived, outside)
    finding = Said("it holds where the machine uses it, and not everywhere: ", domain)
    return Judgement("confirmed as rebuilt" if printed.rebuilt else "confirmed", finding, domain=domain)


def _says_the_same(case: Case, printed: Equation, derived: Equation | None, points: list[Point]) -> bool:
    needed = printed.residual.free_symbols | (derived.residual.free_symbols if derived else set())
    if not points or not all(symbol in point for point in points for symbol in needed):
        return False
    at: Points = tuple(points)
    if derived is None:
        return printed.relation == "=" and holds(printed.residual, at)
    return say_the_same(printed, derived, at, printed.defines in case.directions)


def _describe_failure(printed: Equation, derived: Equation | None, point: Point) -> Said:
    """Return where an equation does not hold: values of its symbols if they are few, and of both sides."""
    symbols = sorted(printed.residual.free_symbols - {printed.defines}, key=str)
    places: list[Piece] = [Said(s, f" = {mpmath.nstr(point(s), 4)}") for s in symbols[:SHOWN]]
    where = Said("at ", joined(", ", places)) if len(symbols) <= SHOWN else Said("at a random point")
    if derived is None:
        return Said(where, f" {_shown(printed, point)} is left")
    return Said(where, f" it gives {_shown(printed, point)} for {_shown(derived, point)}")


def _shown(side: Equation, point: Point) -> str:
    """The value of what an equation defines its symbol as, or of its residual."""
    given = value(side.residual if side.defines is None else solved(side, side.defines), point)
    return "no real value" if given is None else mpmath.nstr(given, 6)
