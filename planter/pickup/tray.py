"""The tray before the needle: entry, straightness of its path, and room between needle and cell.

The cell's axis is the needle's direction where it picks, at the farthest tip, through that place. The tray lies along
the axis so that this place has the depth that is wanted. In the frame of the cell, `along` runs into it from the tray's
surface and `across` to the left of that.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics import extremes
from planter.numerics.angles import TURN
from planter.pickup.file import Pickup
from planter.pickup.law import MODEL, NEEDLE
from planter.pickup.model import Train

FLOOR_MM, BELOW_MM = 1.0, 500.0
"""Thickness of a cell's floor as drawn, and as counted: a needle that goes through it has not left the tray."""
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
    def of(machine: Pickup) -> Cell:
        depth, top, bottom, pitch = (machine.si(f"tray.cell_{part}_mm") for part in ("depth", "top", "bottom", "pitch"))
        length, width, mounting = (machine.si(f"needle.{key}") for key in ("length_mm", "width_mm", "mounting_deg"))
        return Cell(depth, top, bottom, pitch, machine.si("targets.entry_depth_mm"), length, width, mounting)

    def walls(self) -> Any:
        """What the tray fills, in the frame of the cell, as a shapely geometry in mm; cells have a floor."""
        return self._filled(FLOOR_MM)

    def solid(self) -> tuple[Any, Any]:
        """The tray with all that lies below it, and the room before it, within reach of the needle [mm]."""
        from shapely import box

        walls = self._filled(BELOW_MM)
        _, low, _, high = walls.bounds
        return walls, box(-BELOW_MM, low - BELOW_MM, walls.bounds[2], high + BELOW_MM) - walls

    def _filled(self, floor: float) -> Any:
        from shapely import Polygon, box, unary_union

        half = (CELLS_BESIDE + 0.5) * self.pitch * 1000
        depth, top, bottom = (value * 1000 for value in (self.depth, self.top, self.bottom))
        holes = [
            Polygon([(-1, c - top / 2), (0, c - top / 2), (depth, c - bottom / 2), (depth, c + bottom / 2),
                     (0, c + top / 2), (-1, c + top / 2)])
            for c in (k * self.pitch * 1000 for k in range(-CELLS_BESIDE, CELLS_BESIDE + 1))
        ]  # fmt: skip
        return box(0, -half, depth + floor, half) - unary_union(holes)


@dataclass(frozen=True)
class Entry:
    """The path and the needle of a train in the frame of a cell."""

    train: Train
    cell: Cell

    def axis(self) -> float:
        """Direction of the cell's axis: that of the needle where it picks [rad]."""
        return float(self.train.arm_heading(np.zeros(1))[0] + self.cell.mounting)

    def place(self, t: Array) -> Array:
        """Places of the tip (n, 2), along and across [m]."""
        bottom, tips = self.train.tip(np.zeros(1))[0], self.train.tip(t)
        given = {"x_S": tips[:, 0], "y_S": tips[:, 1], "x_bottom": bottom[0], "y_bottom": bottom[1]}
        found = load(MODEL)("entry", **given, axis=self.axis())
        return np.column_stack([found["along"] + self.cell.entry, found["across"]])

    def tilt(self, t: Array) -> Array:
        """The needle's angle from the cell's axis (n,) [rad]."""
        return np.asarray(self.train.arm_heading(t) - self.train.arm_heading(np.zeros(1))[0])

    def to_frame(self, places: Array) -> Array:
        """Places (n, 2) of the cell's frame in the machine's [same unit; the bottom of the entry in m is added]."""
        along, across = (places - [self.cell.entry, 0]).T
        found = load(NEEDLE)("placed", along=along, across=across, axis=self.axis())
        return self.train.tip(np.zeros(1))[0] + np.column_stack([found["x"], found["y"]])

    def needle(self, t: float) -> Array:
        """Corners (4, 2) of the needle in the frame of the cell [m]: two at the tip, two at the root."""
        found: Array = self.needles(np.array([t]))[0]
        return found

    def needles(self, t: Array) -> Array:
        """The same at carrier angles (n,), (n, 4, 2)."""
        along, across = self.place(t).T
        size = {"length": self.cell.needle_length, "width": self.cell.needle_width}
        found = load(NEEDLE)("needle", along=along, across=across, tilt=self.tilt(t), **size)
        corners = ("tip_right", "tip_left", "root_left", "root_right")
        return np.stack([np.column_stack([found[f"{c}_along"], found[f"{c}_across"]]) for c in corners], axis=1)

    def depth(self) -> tuple[float, float]:
        """Largest depth of the tip below the tray's surface [m], and where [rad]."""
        t = np.arange(SAMPLES) * TURN / SAMPLES - TURN / 2
        found = extremes.largest(lambda t: self.place(t)[:, 0], t, closed=True)
        return found.value, found.place

    def straight(self, allowed: float, entering: bool = True) -> float:
        """Length of the chord from the deepest place [m] from which the path into it, or out of it, stays `allowed`.

        The path is followed to the dwell, or to the nearest tip where there is none.
        """
        ends = self.train.driven if self.train.law.dwell is not None else (self.train.near - TURN, self.train.near)
        last = ends[0 if entering else 1]
        tips = self.train.tip(np.linspace(0.0, last, BRANCH))
        chord = tips - tips[0]
        length = np.hypot(*chord.T)
        length[0] = 1.0
        ahead = chord / length[:, None]
        beside = np.abs(chord[None, :, 0] * ahead[:, None, 1] - chord[None, :, 1] * ahead[:, None, 0])
        worst = np.max(np.tril(beside), axis=1)
        beyond = np.flatnonzero(worst > allowed)
        if len(beyond) == 0:
            return float(length[-1])
        i = int(beyond[0])
        share = (allowed - worst[i - 1]) / (worst[i] - worst[i - 1])
        before = 0.0 if i == 1 else float(length[i - 1])
        return before + float(share) * (float(length[i]) - before)

    def clearance(self) -> tuple[float, float]:
        """Least distance of needle and tray over a turn [m], negative where they cut, and where [rad]."""
        walls, free = self.cell.solid()
        t = np.arange(SAMPLES) * TURN / SAMPLES
        found = extremes.least(lambda t: _gaps(self.needles(t), walls, free), t, closed=True)
        return found.value, found.place % TURN


def _gaps(corners: Array, walls: Any, free: Any) -> Array:
    """Distances (n,) of needles (n, 4, 2) from the walls [m]; where one cuts them, less the depth of the cut."""
    import shapely

    needles = shapely.polygons(corners * 1000)
    found: Array = shapely.distance(needles, walls)
    for i in np.flatnonzero(shapely.intersects(needles, walls)):
        cut = shapely.points(shapely.get_coordinates(shapely.intersection(needles[i], walls)))
        found[i] = -shapely.distance(cut, free).max()
    return found / 1000
