"""The seedling pick-up from first principles: spline, carrier and tip, gear train, teeth (yu2023)."""

from __future__ import annotations

import random
from dataclasses import replace
from functools import cache

from mpmath import mpf

from ...equations import Claimed, Equation, Relation, among, by_claim, defined, derived
from ...quantity import Quantity
from . import geometry, spline, teeth, train
from . import points as pickup_points
from . import quantities as q
from .geometry import Formula
from .vocabulary import PickupClaim

ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "M1 lies counter-clockwise of O1 as seen from O",
    "the helical gears of stage 2 are equal",
    "L2 is longer than L1",
    "pitch curves convex where teeth mesh",
)


@cache
def formulas() -> dict[Claimed, Formula]:
    """Every claim that defines a symbol, with the symbol and its expression."""
    parts = (spline, geometry, train, teeth)
    return {claim: formula for part in parts for claim, formula in part.formulas().items()}


def formula(claim: Claimed) -> Formula:
    """The symbol that a claim defines, and its expression; raises ClaimError for one that defines none."""
    return among(formulas(), claim)


def claims() -> dict[Claimed, Equation]:
    """What the geometry of the pick-up makes true, by claim."""
    return dict(_derived())


@cache
def _derived() -> dict[Claimed, Equation]:
    found = [
        replace(defined(claim, *formula), stated=claim in spline.NAMED or claim in train.NAMED)
        for claim, formula in formulas().items()
    ]
    found.append(derived(PickupClaim.KNOT_ROW, spline.row()))
    slopes: list[tuple[PickupClaim, bool, Quantity, Relation]] = [
        (PickupClaim.GROWS_WITH_ADDENDUM, teeth.grows_with_addendum(), q.epsilon_ha, ">"),
        (PickupClaim.FALLS_WITH_MODULE, teeth.falls_with_module(), q.epsilon_m, "<"),
    ]
    found += [derived(claim, slope, relation=relation) for claim, holds, slope, relation in slopes if holds]
    return by_claim(found)


def admissible(rng: random.Random) -> dict[Quantity, mpf]:
    """A random pick-up at a random moment: a value for every symbol, all of them consistent."""
    return pickup_points.complete(formulas(), pickup_points.random_base(rng))


def reference(points: int) -> list[dict[Quantity, mpf]]:
    """The built-in pick-up at ``points`` equal steps of the carrier, without those in the dwell.

    There the total ratio is infinite and no teeth mesh. The first step lies half a step after the farthest point.
    """
    return [pickup_points.complete(formulas(), base) for base in pickup_points.cycle(formulas(), points)]
