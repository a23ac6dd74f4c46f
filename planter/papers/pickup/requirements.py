"""What the path of a seedling pick-up must do, with the tray before the needle.

The targets are those of Table 1 of Yu et al. (2023), whose body is lost: their numbers are in the
text, with about."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy

from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics import extrema
from planter.numerics.arrays import TURN, to_degrees
from planter.numerics.extrema import find_minimum
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.law import MODEL, NEEDLE
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.results import Demand

FLOOR_MM, BELOW_MM = 1.0, 500.0
"""Thickness of a cell's floor as drawn, and as counted: a needle that goes through it has not left
the tray.
"""
CELLS_BESIDE = 2
"""Cells of the tray on either side of the one that is picked, in the plane of the needle."""
SAMPLES = 720
"""Carrier angles at which the needle is held against the tray; the tightest is refined."""
BRANCH = 721
"""Points of a branch of the path on which its straightness is judged."""


@dataclass(frozen=True)
class Cell:
    """A tray's cell and needle in SI."""

    depth: float
    top: float
    bottom: float
    pitch: float
    entry: float
    needle_length: float
    needle_width: float
    mounting: float

    @staticmethod
    def from_pickup(machine: Pickup) -> Cell:
        """Return the cell and needle of a pick-up's file."""
        depth, top, bottom, pitch = (
            machine.si(f"tray.cell_{part}_mm") for part in ("depth", "top", "bottom", "pitch")
        )
        length, width, mounting = (
            machine.si(f"needle.{key}") for key in ("length_mm", "width_mm", "mounting_deg")
        )
        return Cell(
            depth, top, bottom, pitch, machine.si("targets.entry_depth_mm"), length, width, mounting
        )

    def walls(self) -> Any:
        """Return the solid of the tray in the frame of the cell, as a shapely geometry in mm; cells
        have a floor.
        """
        return self._filled(FLOOR_MM)

    def solid(self) -> tuple[Any, Any]:
        """The tray with all that lies below it, and the free space before it, within reach of the
        needle [mm].
        """
        from shapely import box

        walls = self._filled(BELOW_MM)
        _, low, _, high = walls.bounds
        return walls, box(-BELOW_MM, low - BELOW_MM, walls.bounds[2], high + BELOW_MM) - walls

    def _filled(self, floor: float) -> Any:
        from shapely import Polygon, box, unary_union

        half = (CELLS_BESIDE + 0.5) * self.pitch * 1000
        depth, top, bottom = (value * 1000 for value in (self.depth, self.top, self.bottom))
        holes = [
            Polygon(
                [
                    (-1, c - top / 2),
                    (0, c - top / 2),
                    (depth, c - bottom / 2),
                    (depth, c + bottom / 2),
                    (0, c + top / 2),
                    (-1, c + top / 2),
                ]
            )
            for c in (k * self.pitch * 1000 for k in range(-CELLS_BESIDE, CELLS_BESIDE + 1))
        ]
        return box(0, -half, depth + floor, half) - unary_union(holes)


@dataclass(frozen=True)
class CellEntry:
    """The path and the needle of a train in the frame of a cell."""

    train: PickupTrain
    cell: Cell

    def axis(self) -> float:
        """Direction of the cell's axis: that of the needle where it picks [rad]."""
        return float(self.train.arm_heading(np.zeros(1))[0] + self.cell.mounting)

    def place(self, t: Array) -> Array:
        """Places of the tip (n, 2), along and across [m]."""
        bottom, tips = self.train.tip(np.zeros(1))[0], self.train.tip(t)
        tip = {"x_S": tips[:, 0], "y_S": tips[:, 1], "x_bottom": bottom[0], "y_bottom": bottom[1]}
        frame = load(MODEL)("entry", **tip, axis=self.axis())
        return np.column_stack([frame["along"] + self.cell.entry, frame["across"]])

    def tilt(self, t: Array) -> Array:
        """The needle's angle from the cell's axis (n,) [rad]."""
        return np.asarray(self.train.arm_heading(t) - self.train.arm_heading(np.zeros(1))[0])

    def to_frame(self, places: Array) -> Array:
        """Places (n, 2) of the cell's frame in the machine's [same unit; the bottom of the entry in
        m is added].
        """
        depth, across = (places - [self.cell.entry, 0]).T
        place = load(NEEDLE)("placed", along=depth, across=across, axis=self.axis())
        return self.train.tip(np.zeros(1))[0] + np.column_stack([place["x"], place["y"]])

    def needle(self, t: float) -> Array:
        """Corners (4, 2) of the needle in the frame of the cell [m]: two at the tip, two at the
        root.
        """
        corners: Array = self.needles(np.array([t]))[0]
        return corners

    def needles(self, t: Array) -> Array:
        """Return the corners (n, 4, 2) of the needle at carrier angles (n,) [m]."""
        depth, across = self.place(t).T
        size = {"length": self.cell.needle_length, "width": self.cell.needle_width}
        corner_places = load(NEEDLE)(
            "needle", along=depth, across=across, tilt=self.tilt(t), **size
        )
        corners = ("tip_right", "tip_left", "root_left", "root_right")
        return np.stack(
            [
                np.column_stack([corner_places[f"{c}_along"], corner_places[f"{c}_across"]])
                for c in corners
            ],
            axis=1,
        )

    def depth(self) -> tuple[float, float]:
        """Largest depth of the tip below the tray's surface [m], and where [rad]."""
        t = np.arange(SAMPLES) * TURN / SAMPLES - TURN / 2
        deepest = extrema.find_maximum(lambda t: self.place(t)[:, 0], t, closed=True)
        return deepest.value, deepest.place

    def straight(self, allowed: float) -> float:
        """Length of the chord from the deepest place [m] from which the path into it
        stays `allowed`.

        The path is followed to the dwell, or to the nearest tip without a dwell.
        """
        train = self.train
        last = train.driven[0] if train.law.dwell is not None else train.nearest_angle - TURN
        tips = train.tip(np.linspace(0.0, last, BRANCH))
        chord = tips - tips[0]
        length = np.hypot(*chord.T)
        length[0] = 1.0
        ahead = chord / length[:, None]
        deviation = np.abs(
            chord[None, :, 0] * ahead[:, None, 1] - chord[None, :, 1] * ahead[:, None, 0]
        )
        worst = np.max(np.tril(deviation), axis=1)
        beyond = np.flatnonzero(worst > allowed)
        if len(beyond) == 0:
            return float(length[-1])
        i = int(beyond[0])
        share = (allowed - worst[i - 1]) / (worst[i] - worst[i - 1])
        before = 0.0 if i == 1 else float(length[i - 1])
        return before + float(share) * (float(length[i]) - before)

    def clearance(self) -> tuple[float, float]:
        """Least distance of needle and tray over a turn [m], negative where they cut, and where
        [rad].
        """
        walls, free = self.cell.solid()
        t = np.arange(SAMPLES) * TURN / SAMPLES
        tightest = extrema.find_minimum(
            lambda t: _gaps(self.needles(t), walls, free), t, closed=True
        )
        return tightest.value, tightest.place % TURN


def _gaps(corners: Array, walls: Any, free: Any) -> Array:
    """Distances (n,) of needles (n, 4, 2) from the walls [m]; where one cuts them, less the depth
    of the cut.
    """
    import shapely

    needles = shapely.polygons(corners * 1000)
    with np.errstate(
        invalid="ignore"
    ):  # Shapely 2.0 reports very thin needles, whose distance is right
        distances: Array = shapely.distance(needles, walls)
    for i in np.flatnonzero(shapely.intersects(needles, walls)):
        cut = shapely.points(shapely.get_coordinates(shapely.intersection(needles[i], walls)))
        distances[i] = -shapely.distance(cut, free).max()
    return distances / 1000


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
