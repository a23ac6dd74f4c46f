"""The tray before the needle: entry, straightness of its path, and clearance between needle and
cell.

The cell's axis is the needle's direction where it picks, at the farthest tip, through that place.
The tray lies along the axis so that this place has the depth that is wanted. In the frame of the
cell, `along` runs into it from the tray's surface and `across` to the left of that.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics import extrema
from planter.numerics.arrays import TURN
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.law import MODEL, NEEDLE
from planter.papers.pickup.model import PickupTrain

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

    def straight(self, allowed: float, entering: bool = True) -> float:
        """Length of the chord from the deepest place [m] from which the path into it, or out of it,
        stays `allowed`.

        The path is followed to the dwell, or to the nearest tip without a dwell.
        """
        ends = (
            self.train.driven
            if self.train.law.dwell is not None
            else (self.train.nearest_angle - TURN, self.train.nearest_angle)
        )
        last = ends[0 if entering else 1]
        tips = self.train.tip(np.linspace(0.0, last, BRANCH))
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
