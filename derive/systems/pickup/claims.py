"""The seedling pick-up from first principles: spline, carrier and tip, gear train, teeth (yu2023)."""

from __future__ import annotations

import random
from functools import cache

from mpmath import mpf

from ...formulas import Formulas
from ...quantity import Quantity
from . import geometry, points, spline, teeth, train

ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "M1 lies counter-clockwise of O1 as seen from O",
    "the helical gears of stage 2 are equal",
    "L2 is longer than L1",
    "pitch curves convex where teeth mesh",
)


@cache
def formulas() -> Formulas:
    """What the geometry of the pick-up makes true."""
    f = Formulas("pickup_exact")
    for part in (spline, geometry, train, teeth):
        part.state(f)
    return f


def admissible(rng: random.Random) -> dict[Quantity, mpf]:
    """A random pick-up at a random moment: a value for every symbol, all of them consistent."""
    return points.complete(formulas(), points.random_base(rng))


def reference(count: int) -> list[dict[Quantity, mpf]]:
    """The built-in pick-up at equal steps of the carrier, without those in the dwell.

    There the total ratio is infinite and no teeth mesh. The first step lies half a step after the farthest point.
    """
    return [points.complete(formulas(), base) for base in points.cycle(formulas(), count)]
