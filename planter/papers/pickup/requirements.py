"""What the path of a seedling pick-up must do, each requirement with its value, its target and its
margin.

The targets are those of Table 1 of Yu et al. (2023), whose body is lost: their numbers are in the
text, with "about".
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
import scipy

from planter.kernels import Array
from planter.numerics.arrays import TURN, to_degrees
from planter.numerics.extrema import find_minimum
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.results import Demand
from planter.papers.pickup.tray import Cell, CellEntry

SAMPLES = 1441


def find_push(train: PickupTrain) -> tuple[float, float]:
    """Return the carrier angle of the push, and the needle's rotation back from the pick [rad].

    It pushes where it rests between turning back and turning on: where the arm's heading is least.
    """
    t = np.linspace(0.0, TURN, SAMPLES)
    heading = train.arm_heading(t)
    best = int(np.argmin(heading))
    where = _level(train, float(t[max(best - 1, 0)]), float(t[min(best + 1, SAMPLES - 1)]))
    return where, float(heading[0] - train.arm_heading(np.array([where]))[0])


def _level(train: PickupTrain, low: float, high: float) -> float:
    """Return the angle of slope 1 between two angles, or of the closest slope if it jumps past
    1.
    """

    def beyond(t: float) -> float:
        return float(train.slope(np.array([t]))[0]) - 1

    if beyond(low) * beyond(high) > 0:
        return (
            low
            if train.arm_heading(np.array([low])) < train.arm_heading(np.array([high]))
            else high
        )
    return float(scipy.optimize.brentq(beyond, low, high, xtol=1e-14))


def pick_angle_deg(machine: Pickup) -> float:
    """Elevation of the needle where it picks: along the axis of a cell, which is square to the tray
    box.
    """
    return 90 - machine.tray.box_inclination_deg


def list_requirements(machine: Pickup, train: PickupTrain) -> list[Demand]:
    """Return all requirements, in the order of the paper, then of the gears, then the points of the
    path.
    """
    return [
        *_angles(machine, train),
        *_entry(machine, train),
        *_gears(train),
        *_points(machine, train),
    ]


def _angles(machine: Pickup, train: PickupTrain) -> list[Demand]:
    targets = machine.targets
    where, swing = find_push(train)
    turned = float(np.degrees(swing))
    angle = pick_angle_deg(machine) + turned
    return [
        _about("push angle", angle, "deg", targets.push_deg, targets.push_tolerance_deg, where),
        _about(
            "push angle less pick angle",
            turned,
            "deg",
            targets.swing_deg,
            targets.swing_tolerance_deg,
            where,
        ),
    ]


def _entry(machine: Pickup, train: PickupTrain) -> list[Demand]:
    targets, entry = machine.targets, CellEntry(train, Cell.from_pickup(machine))
    depth, deepest = entry.depth()
    straight = entry.straight(targets.straightness_mm / 1000) * 1000
    gap, tight = entry.clearance()
    return [
        _about(
            "entry depth",
            depth * 1000,
            "mm",
            targets.entry_depth_mm,
            targets.entry_depth_tolerance_mm,
            deepest,
        ),
        _at_least("straight entry", straight, "mm", targets.straight_entry_mm),
        _at_least("needle to tray", gap * 1000, "mm", targets.clearance_mm, tight),
    ]


def _gears(train: PickupTrain) -> list[Demand]:
    t = train.samples(SAMPLES)
    slopes = train.law.slopes(t)[0]
    curves = train.pitch(t)
    lowest = int(np.argmin(slopes))
    rows = [_at_least("slope on the teeth", float(slopes[lowest]), "", 0.0, float(t[lowest]))]
    for name, key in (
        ("sun's pitch curve convex", "kappa1"),
        ("intermediate gear's convex", "kappa2"),
    ):
        rows.append(_convex(name, curves[key], t))
    return rows


def _points(machine: Pickup, train: PickupTrain) -> Iterator[Demand]:
    """Yield the distance of the path from each prescribed point."""
    t = np.arange(SAMPLES - 1) * TURN / (SAMPLES - 1)
    for number, (x, y, tube) in enumerate(
        machine.tip_path.points_mm if machine.tip_path else (), 1
    ):
        nearest = find_minimum(partial(_point_distances, train, (x, y)), t, closed=True)
        name, bound = f"path by point {number}", f"at most {tube:g}"
        margin = tube - nearest.value
        yield _demand(name, nearest.value, "mm", bound, margin, nearest.place, (None, tube))


def _point_distances(train: PickupTrain, point: tuple[float, float], t: Array) -> Array:
    """Distance of the tip from a point [mm] at carrier angles (n,)."""
    distances: Array = np.hypot(*(train.tip(t) * 1000 - point).T)
    return distances


def _convex(name: str, curvature: Array, t: Array) -> Demand:
    worst = int(np.argmin(curvature))
    return _at_least(name, float(curvature[worst]) / 1000, "1/mm", 0.0, float(t[worst]))


def _demand(
    name: str,
    value: float,
    unit: str,
    bound: str,
    margin: float,
    t: float | None,
    limits: tuple[float | None, float | None],
) -> Demand:
    at = None if t is None else to_degrees(t)
    return Demand(name, value, unit, bound, margin, at, margin >= 0, *limits)


def _about(name: str, value: float, unit: str, target: float, tolerance: float, t: float) -> Demand:
    bound = f"{target:g} \N{PLUS-MINUS SIGN} {tolerance:g}"
    margin, limits = tolerance - abs(value - target), (target - tolerance, target + tolerance)
    return _demand(name, value, unit, bound, margin, t, limits)


def _at_least(name: str, value: float, unit: str, minimum: float, t: float | None = None) -> Demand:
    bound = f"at least {minimum:g}"
    return _demand(name, value, unit, bound, value - minimum, t, (minimum, None))
