"""What the path of a seedling pick-up must do, each requirement with its value, its target and its margin.

The targets are those of Table 1 of Yu et al. (2023), whose body is lost: their numbers stand in the text, with "about".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from planter.kernels import Array
from planter.numerics.angles import TURN, turn_deg
from planter.numerics.extremes import least
from planter.pickup.file import Pickup
from planter.pickup.model import Train
from planter.pickup.results import Demand
from planter.pickup.tray import Cell, Entry

SAMPLES = 1441


@dataclass(frozen=True)
class Requirement:
    """A value in shown units, what is wanted of it, and by how much that holds: negative where it does not."""

    name: str
    value: float
    unit: str
    wanted: str
    margin: float
    t: float | None = None

    @property
    def holds(self) -> bool:
        return self.margin >= 0

    @property
    def t_deg(self) -> float | None:
        """Its place as it is shown [deg]; None where it has none."""
        return None if self.t is None else turn_deg(self.t)

    def shown(self) -> Demand:
        return Demand(
            name=self.name, value=self.value, unit=self.unit, wanted=self.wanted, margin=self.margin,
            t_deg=self.t_deg, holds=self.holds,
        )  # fmt: skip


def push(train: Train) -> tuple[float, float]:
    """Where the needle pushes, and how far it has turned back from the pick [rad].

    It pushes where it rests between turning back and turning on: where the arm's heading is least.
    """
    t = np.linspace(0.0, TURN, SAMPLES)
    heading = train.arm_heading(t)
    best = int(np.argmin(heading))
    where = _level(train, float(t[max(best - 1, 0)]), float(t[min(best + 1, SAMPLES - 1)]))
    return where, float(heading[0] - train.arm_heading(np.array([where]))[0])


def _level(train: Train, low: float, high: float) -> float:
    """Where the slope is 1 between two angles, or the one that is closest to it: the slope may jump past 1."""
    from scipy.optimize import brentq

    def beyond(t: float) -> float:
        return float(train.slope(np.array([t]))[0]) - 1

    if beyond(low) * beyond(high) > 0:
        return low if train.arm_heading(np.array([low])) < train.arm_heading(np.array([high])) else high
    return float(brentq(beyond, low, high, xtol=1e-14))


def pick_angle_deg(machine: Pickup) -> float:
    """Elevation of the needle where it picks: along the axis of a cell, which is square to the tray box."""
    return 90 - machine.tray.box_inclination_deg


def requirements(machine: Pickup, train: Train) -> list[Requirement]:
    """All of them, in the order of the paper, then those of the gears, then the points that the path must pass."""
    return [*_angles(machine, train), *_entry(machine, train), *_gears(train), *_points(machine, train)]


def _angles(machine: Pickup, train: Train) -> list[Requirement]:
    targets = machine.targets
    where, swing = push(train)
    turned = float(np.degrees(swing))
    angle = pick_angle_deg(machine) + turned
    return [
        _about("push angle", angle, "deg", targets.push_deg, targets.push_tolerance_deg, where),
        _about("push angle less pick angle", turned, "deg", targets.swing_deg, targets.swing_tolerance_deg, where),
    ]


def _entry(machine: Pickup, train: Train) -> list[Requirement]:
    targets, entry = machine.targets, Entry(train, Cell.of(machine))
    depth, deepest = entry.depth()
    straight = entry.straight(targets.straightness_mm / 1000) * 1000
    gap, tight = entry.clearance()
    return [
        _about("entry depth", depth * 1000, "mm", targets.entry_depth_mm, targets.entry_depth_tolerance_mm, deepest),
        _at_least("straight entry", straight, "mm", targets.straight_entry_mm),
        _at_least("needle to tray", gap * 1000, "mm", targets.clearance_mm, tight),
    ]


def _gears(train: Train) -> list[Requirement]:
    t = train.samples(SAMPLES)
    slopes = train.law.slopes(t)[0]
    curves = train.pitch(t)
    least = int(np.argmin(slopes))
    found = [_at_least("slope on the teeth", float(slopes[least]), "", 0.0, float(t[least]))]
    for name, key in (("sun's pitch curve convex", "kappa1"), ("intermediate gear's convex", "kappa2")):
        found.append(_convex(name, curves[key], t))
    return found


def _points(machine: Pickup, train: Train) -> Iterator[Requirement]:
    """How far from each point the path passes it, at the nearest."""
    t = np.arange(SAMPLES - 1) * TURN / (SAMPLES - 1)
    for number, (x, y, tube) in enumerate(machine.tip_path.points_mm if machine.tip_path else (), 1):
        nearest = least(partial(_apart, train, (x, y)), t, closed=True)
        name, wanted = f"path by point {number}", f"at most {tube:g}"
        yield Requirement(name, nearest.value, "mm", wanted, tube - nearest.value, nearest.place)


def _apart(train: Train, point: tuple[float, float], t: Array) -> Array:
    """Distance of the tip from a point [mm] at carrier angles (n,)."""
    found: Array = np.hypot(*(train.tip(t) * 1000 - point).T)
    return found


def _convex(name: str, curvature: Array, t: Array) -> Requirement:
    worst = int(np.argmin(curvature))
    return _at_least(name, float(curvature[worst]) / 1000, "1/mm", 0.0, float(t[worst]))


def _about(name: str, value: float, unit: str, target: float, tolerance: float, t: float) -> Requirement:
    wanted = f"{target:g} \N{PLUS-MINUS SIGN} {tolerance:g}"
    return Requirement(name, value, unit, wanted, tolerance - abs(value - target), t)


def _at_least(name: str, value: float, unit: str, least: float, t: float | None = None) -> Requirement:
    return Requirement(name, value, unit, f"at least {least:g}", value - least, t)
