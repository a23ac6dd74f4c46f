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


def dyad(solution: Dyad, poses: Array) -> DyadFound:
    """A dyad, how far it misses the poses, and whether its fixed hinge is outside the polyline of their tips."""
    return DyadFound(
        moving_point_mm=pair(solution.point * 1e3),
        centre_mm=pair(solution.centre * 1e3),
        radius_mm=solution.radius * 1e3,
        multiplicity=solution.multiplicity,
        largest_miss_mm=float(misses(poses, solution.vector).max()) * 1e3,
        outside=is_outside(solution.centre, poses[:, :2]),
    )


def is_outside(place: Array, corners: Array) -> bool:
    """Whether a place (2,) is outside the closed polyline through corners (n, 2), by the rule of even and odd."""
    (x, y), (x1, y1) = place, corners.T
    x2, y2 = np.roll(corners, -1, axis=0).T
    spans = (y1 > y) != (y2 > y)
    rise = np.where(spans, y2 - y1, 1)
    return bool(np.sum(spans & (x < x1 + (y - y1) * (x2 - x1) / rise)) % 2 == 0)


def straight(line: Straight) -> StraightFound:
    """A dyad with a hinge at infinity: its point and its line normal . place = offset."""
    return StraightFound(
        kind=line.kind,
        point_mm=pair(line.point * 1e3),
        normal=pair(line.normal),
        offset_mm=line.offset * 1e3,
        multiplicity=line.multiplicity,
    )


def standing(number: int, position: Standing) -> AtPose:
    return AtPose(
        pose=number,
        crank_angle_deg=degrees(position.crank_angle),
        assembly=position.assembly,
        circuit=position.circuit,
        hinges_mm=(pair(position.hinges[0] * 1e3), pair(position.hinges[1] * 1e3)),
        position_error_mm=position.position_error * 1e3,
        angle_error_deg=degrees(position.angle_error),
        transmission_deg=degrees(position.transmission),
    )


def monotone(reversals: Sequence[Reversal]) -> OneSense:
    turned = [Back(r.start + 1, r.end + 1, degrees(r.angle)) for r in reversals]
    return OneSense(not turned, turned)


class Slopes(TypedDict):
    """Return the slopes of an angle curve and their angles."""

    monotone: bool
    slope_min: float
    slope_min_at_deg: float
    slope_max: float
    slope_max_at_deg: float


def slopes(curve: AngleCurve) -> Slopes:
    lowest, largest = curve.extremes
    return {
        "monotone": curve.monotone,
        "slope_min": lowest.value,
        "slope_min_at_deg": degrees(lowest.angle % TURN),
        "slope_max": largest.value,
        "slope_max_at_deg": degrees(largest.angle % TURN),
    }


def miss(number: int, deviation: Miss) -> Missed:
    """Return the miss of a pose where the curve meets it."""
    return Missed(
        pose=number,
        carrier_deg=degrees(deviation.carrier % TURN),
        position_error_mm=deviation.tip * 1e3,
        hinge_error_mm=deviation.hinge * 1e3,
        angle_error_deg=degrees(deviation.angle),
    )
