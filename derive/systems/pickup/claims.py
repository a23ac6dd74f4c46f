"""The seedling pick-up from first principles: spline, carrier and tip, gear train, teeth (yu2023)."""

from __future__ import annotations

import random
from functools import cache

from mpmath import mpf
from sympy import Expr

from ...equations import Equation, Relation
from ...quantity import Quantity
from . import geometry, spline, teeth, train
from . import points as pickup_points
from . import quantities as q
from .geometry import Formula

ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "M1 lies counter-clockwise of O1 as seen from O",
    "the helical gears of stage 2 are equal",
    "L2 is longer than L1",
    "pitch curves convex where teeth mesh",
)


@cache
def formulas() -> dict[str, Formula]:
    """Every claim that defines a symbol, with the symbol and its expression."""
    parts = (spline, geometry, train, teeth)
    return {claim: formula for part in parts for claim, formula in part.formulas().items()}


def claims() -> dict[str, Equation]:
    """What the geometry of the pick-up makes true, by claim."""
    found = {claim: _equation(claim, symbol - expr, symbol) for claim, (symbol, expr) in formulas().items()}
    found["row of a knot"] = _equation("row of a knot", spline.row())
    slopes: list[tuple[str, bool, Quantity, Relation]] = [
        ("contact ratio grows with the addendum", teeth.grows_with_addendum(), q.epsilon_ha, ">"),
        ("contact ratio falls with the module", teeth.falls_with_module(), q.epsilon_m, "<"),
    ]
    found |= {claim: _equation(claim, slope, relation=relation) for claim, holds, slope, relation in slopes if holds}
    return found


def admissible(rng: random.Random) -> dict[Quantity, mpf]:
    """A random pick-up at a random moment: a value for every symbol, all of them consistent."""
    return pickup_points.complete(formulas(), pickup_points.random_base(rng))


def reference(points: int) -> list[dict[Quantity, mpf]]:
    """The built-in pick-up at ``points`` equal steps of the carrier, without those in the dwell.

    There the total ratio is infinite and no teeth mesh. The first step lies half a step after the farthest point.
    """
    return [pickup_points.complete(formulas(), base) for base in pickup_points.cycle(formulas(), points)]


def _equation(claim: str, residual: Expr, symbol: Quantity | None = None, relation: Relation = "=") -> Equation:
    return Equation(claim, residual, f"derived: {claim}", claim, defines=symbol, relation=relation)
