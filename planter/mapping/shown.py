"""Results in mm and deg."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from planter.kernels import Array
from planter.mapping.curve import AngleCurve
from planter.mapping.defects import Reversal, Standing
from planter.mapping.dyads import Dyad, Straight, misses
from planter.mapping.nearest import Miss
from planter.mapping.results import AtPose, Back, DyadFound, Four, Missed, OneSense, Pair, StraightFound
from planter.numerics.angles import TURN


def pair(place: Array) -> Pair:
    x, y = place
    return float(x), float(y)


def four(lengths: Array) -> Four:
    """A length of each gear [m] in mm."""
    a, b, c, d = (float(x) * 1e3 for x in lengths)
    return a, b, c, d


def degrees(angle: float) -> float:
    return float(np.degrees(angle))


def dyad(found: Dyad, poses: Array) -> DyadFound:
    """A dyad, how far it misses the poses, and whether its fixed hinge is outside the polyline of their tips."""
    return DyadFound(
        moving_point_mm=pair(found.point * 1e3),
        centre_mm=pair(found.centre * 1e3),
        radius_mm=found.radius * 1e3,
        multiplicity=found.multiplicity,
        largest_miss_mm=float(misses(poses, found.vector).max()) * 1e3,
        outside=is_outside(found.centre, poses[:, :2]),
    )


def is_outside(place: Array, corners: Array) -> bool:
    """Whether a place (2,) is outside the closed polyline through corners (n, 2), by the rule of even and odd."""
    (x, y), (x1, y1) = place, corners.T
    x2, y2 = np.roll(corners, -1, axis=0).T
    spans = (y1 > y) != (y2 > y)
    rise = np.where(spans, y2 - y1, 1)
    return bool(np.sum(spans & (x < x1 + (y - y1) * (x2 - x1) / rise)) % 2 == 0)


def straight(found: Straight) -> StraightFound:
    """A dyad with a hinge at infinity: its point and its line normal . place = offset."""
    return StraightFound(
        kind=found.kind,
        point_mm=pair(found.point * 1e3),
        normal=pair(found.normal),
        offset_mm=found.offset * 1e3,
        multiplicity=found.multiplicity,
    )


def standing(number: int, found: Standing) -> AtPose:
    return AtPose(
        pose=number,
        crank_angle_deg=degrees(found.crank_angle),
        assembly=found.assembly,
        circuit=found.circuit,
        hinges_mm=(pair(found.hinges[0] * 1e3), pair(found.hinges[1] * 1e3)),
        position_error_mm=found.position_error * 1e3,
        angle_error_deg=degrees(found.angle_error),
        transmission_deg=degrees(found.transmission),
    )


def monotone(found: Sequence[Reversal]) -> OneSense:
    turned = [Back(r.start + 1, r.end + 1, degrees(r.angle)) for r in found]
    return OneSense(not turned, turned)


class Slopes(TypedDict):
    """What is told of any angle curve."""

    monotone: bool
    slope_min: float
    slope_min_at_deg: float
    slope_max: float
    slope_max_at_deg: float


def slopes(found: AngleCurve) -> Slopes:
    least, largest = found.extremes
    return {
        "monotone": found.monotone,
        "slope_min": least.value,
        "slope_min_at_deg": degrees(least.angle % TURN),
        "slope_max": largest.value,
        "slope_max_at_deg": degrees(largest.angle % TURN),
    }


def miss(number: int, found: Miss) -> Missed:
    """How a pose is missed where the curve meets it."""
    return Missed(
        pose=number,
        carrier_deg=degrees(found.carrier % TURN),
        position_error_mm=found.tip * 1e3,
        hinge_error_mm=found.hinge * 1e3,
        angle_error_deg=degrees(found.angle),
    )
