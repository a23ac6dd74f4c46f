"""Results in mm and deg, under the names of the JSON output."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.mapping.curve import AngleCurve
from planter.mapping.defects import Reversal, Standing
from planter.mapping.dyads import Dyad, Straight, misses
from planter.mapping.linkage import TURN, FourBar
from planter.mapping.nearest import Miss


def mm(lengths: Array) -> list[float]:
    return [float(x) * 1e3 for x in lengths]


def degrees(angle: float) -> float:
    return float(np.degrees(angle))


def dyad(found: Dyad, poses: Array) -> dict[str, Any]:
    """A dyad, how far it misses the poses, and whether its fixed hinge is outside the polyline of their tips."""
    return {
        "moving_point_mm": mm(found.point),
        "centre_mm": mm(found.centre),
        "radius_mm": found.radius * 1e3,
        "multiplicity": found.multiplicity,
        "largest_miss_mm": float(misses(poses, found.vector).max()) * 1e3,
        "outside": is_outside(found.centre, poses[:, :2]),
    }


def is_outside(place: Array, corners: Array) -> bool:
    """Whether a place (2,) is outside the closed polyline through corners (n, 2), by the rule of even and odd."""
    (x, y), (x1, y1) = place, corners.T
    x2, y2 = np.roll(corners, -1, axis=0).T
    spans = (y1 > y) != (y2 > y)
    rise = np.where(spans, y2 - y1, 1)
    return bool(np.sum(spans & (x < x1 + (y - y1) * (x2 - x1) / rise)) % 2 == 0)


def straight(found: Straight) -> dict[str, Any]:
    """A dyad with a hinge at infinity: its point and its line normal . place = offset."""
    return {
        "kind": found.kind,
        "point_mm": mm(found.point),
        "normal": [float(c) for c in found.normal],
        "offset_mm": found.offset * 1e3,
        "multiplicity": found.multiplicity,
    }


def four_bar(bar: FourBar) -> dict[str, Any]:
    frame, crank, coupler, rocker = (length * 1e3 for length in bar.lengths)
    return {
        "frame_mm": frame,
        "crank_mm": crank,
        "coupler_mm": coupler,
        "rocker_mm": rocker,
        "type": bar.type,
        "grashof": bar.grashof,
        "circuits": len(bar.reaches),
        "transmission_min_deg": degrees(bar.least_transmission),
        "arm_length_mm": float(np.hypot(*bar.crank.point)) * 1e3,
    }


def standing(number: int, found: Standing) -> dict[str, Any]:
    return {
        "pose": number,
        "crank_angle_deg": degrees(found.crank_angle),
        "assembly": found.assembly,
        "circuit": found.circuit,
        "hinges_mm": [mm(hinge) for hinge in found.hinges],
        "position_error_mm": found.position_error * 1e3,
        "angle_error_deg": degrees(found.angle_error),
        "transmission_deg": degrees(found.transmission),
    }


def monotone(found: Sequence[Reversal]) -> dict[str, Any]:
    turned = [{"from_pose": r.start + 1, "to_pose": r.end + 1, "deg": degrees(r.angle)} for r in found]
    return {"possible": not turned, "reversals": turned}


def curve(found: AngleCurve) -> dict[str, Any]:
    least, largest = found.extremes
    return {
        "monotone": found.monotone,
        "slope_min": least.value,
        "slope_min_at_deg": degrees(least.angle % TURN),
        "slope_max": largest.value,
        "slope_max_at_deg": degrees(largest.angle % TURN),
    }


def miss(number: int, found: Miss) -> dict[str, Any]:
    """How a pose is missed where the curve meets it."""
    return {
        "pose": number,
        "carrier_deg": degrees(found.carrier % TURN),
        "position_error_mm": found.tip * 1e3,
        "hinge_error_mm": found.hinge * 1e3,
        "angle_error_deg": degrees(found.angle),
    }
