"""Conversion of dyads, positions and curves to results in mm and deg."""

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
from planter.numerics.arrays import TURN


def to_pair(place: Array) -> Pair:
    """Return the two coordinates of a place (2,)."""
    x, y = place
    return float(x), float(y)


def to_four(lengths: Array) -> Four:
    """Return a length of each gear [m] in mm."""
    a, b, c, d = (float(x) * 1e3 for x in lengths)
    return a, b, c, d


def to_degrees(angle: float) -> float:
    """Return an angle [rad] in degrees."""
    return float(np.degrees(angle))


def dyad_result(solution: Dyad, poses: Array) -> DyadFound:
    """Return a dyad, how far it misses the poses, and whether its fixed hinge is outside the polyline of their tips."""
    return DyadFound(
        moving_point_mm=to_pair(solution.point * 1e3),
        centre_mm=to_pair(solution.centre * 1e3),
        radius_mm=solution.radius * 1e3,
        multiplicity=solution.multiplicity,
        largest_miss_mm=float(misses(poses, solution.vector).max()) * 1e3,
        outside=is_outside(solution.centre, poses[:, :2]),
    )


def is_outside(place: Array, corners: Array) -> bool:
    """Return whether a place (2,) is outside the closed polyline through corners (n, 2): even-odd rule."""
    (x, y), (x1, y1) = place, corners.T
    x2, y2 = np.roll(corners, -1, axis=0).T
    spans = (y1 > y) != (y2 > y)
    rise = np.where(spans, y2 - y1, 1)
    return bool(np.sum(spans & (x < x1 + (y - y1) * (x2 - x1) / rise)) % 2 == 0)


def straight_result(line: Straight) -> StraightFound:
    """Return a dyad with a hinge at infinity: its point and its line normal . place = offset."""
    return StraightFound(
        kind=line.kind,
        point_mm=to_pair(line.point * 1e3),
        normal=to_pair(line.normal),
        offset_mm=line.offset * 1e3,
        multiplicity=line.multiplicity,
    )


def standing_result(number: int, position: Standing) -> AtPose:
    """Return the position of a linkage at the pose of a number."""
    return AtPose(
        pose=number,
        crank_angle_deg=to_degrees(position.crank_angle),
        assembly=position.assembly,
        circuit=position.circuit,
        hinges_mm=(to_pair(position.hinges[0] * 1e3), to_pair(position.hinges[1] * 1e3)),
        position_error_mm=position.position_error * 1e3,
        angle_error_deg=to_degrees(position.angle_error),
        transmission_deg=to_degrees(position.transmission),
    )


def monotone_result(reversals: Sequence[Reversal]) -> OneSense:
    """Return whether the arm can turn in one sense only, and the reversals if not."""
    turned = [Back(r.start + 1, r.end + 1, to_degrees(r.angle)) for r in reversals]
    return OneSense(not turned, turned)


class Slopes(TypedDict):
    """Extremes of the slope [-] of an angle curve and their carrier angles."""

    monotone: bool
    slope_min: float
    slope_min_at_deg: float
    slope_max: float
    slope_max_at_deg: float


def slopes_result(curve: AngleCurve) -> Slopes:
    """Return the extremes of the slope [-] of an angle curve."""
    lowest, largest = curve.extremes
    return {
        "monotone": curve.monotone,
        "slope_min": lowest.value,
        "slope_min_at_deg": to_degrees(lowest.angle % TURN),
        "slope_max": largest.value,
        "slope_max_at_deg": to_degrees(largest.angle % TURN),
    }


def miss_result(number: int, deviation: Miss) -> Missed:
    """Return the miss of a pose where the curve meets it."""
    return Missed(
        pose=number,
        carrier_deg=to_degrees(deviation.carrier % TURN),
        position_error_mm=deviation.tip * 1e3,
        hinge_error_mm=deviation.hinge * 1e3,
        angle_error_deg=to_degrees(deviation.angle),
    )
