"""The outlines of two gears as polygons, laid over each other: a check of the mesh that knows no flank and no rack."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import POSITIONS, Mesh
from planter.gearing.teeth.pieces import KINDS
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.numerics.extremes import Extreme
from planter.numerics.latest import Latest

CHORDS = {"fillet": 16, "flank": 24, "tip": 2, "root": 2}
"""Chords of each kind of piece: what flanks leave out is a ten-thousandth of a module."""
FINE_CHORDS = {"fillet": 64, "flank": 48, "tip": 16, "root": 16}
"""Those for the depth of penetration: they stay within 2e-4 modules, where they are hollow within 1.5e-4."""
PER_PITCH, MOST_POSITIONS = 48, 4800
"""Positions for each pitch of a period at which the depth of penetration is looked for, and at most in all."""
_LARGEST, _DEEPEST, _BETWEEN = 60, 3, 8
"""How many positions with the largest common areas are examined, how many of the deepest of them are looked around, and
at how many positions on either side of each, up to its neighbours."""
_BEYOND = 0.75
"""Pitches about a tooth's centre that belong to its part of a gear, beside half the contact ratio."""

Shapes = NDArray[np.object_]


def points(gear: Gear, chords: Mapping[str, int] = CHORDS) -> Array:
    """Vertices (n, 2) [m] of the outline, in its order, with so many chords for each piece of a kind."""
    pieces = gear.pieces
    found: dict[int, Array] = {}
    for kind, count in chords.items():
        which = np.flatnonzero(pieces.kind == KINDS.index(kind))
        cut = gear.sampled(np.arange(count) / count, which).points
        found |= {int(number): cut[:, k] for k, number in enumerate(which)}
    return np.hstack([found[number] for number in range(len(pieces.kind))]).T


@dataclass(frozen=True)
class Overlay:
    """The polygons of both gears of a mesh, each in the frame of its axis."""

    mesh: Mesh
    outlines: tuple[Any, Any]

    @classmethod
    def of(cls, mesh: Mesh, chords: Mapping[str, int] = CHORDS) -> Overlay:
        """Return the polygons of a mesh with so many chords for each piece of a kind."""
        one, two = (shapely.Polygon(points(gear, chords)) for gear in mesh.gears)
        return cls(mesh, (one, two))

    @property
    def simple(self) -> bool:
        """Whether no outline crosses itself."""
        return all(outline.is_valid for outline in self.outlines)

    @cached_property
    def parts(self) -> tuple[Shapes, Shapes]:
        """What of each gear is near each of its teeth (z,)."""
        one, two = (self._parts(gear, outline) for gear, outline in zip(self.mesh.gears, self.outlines, strict=True))
        return one, two

    def _parts(self, gear: Gear, outline: Any) -> Shapes:
        centres = gear.curve.at(gear.flanks.centre[: gear.z])[:2].T
        near = self.mesh.contact_ratios.max() / 2 + _BEYOND
        found: Shapes = shapely.intersection(outline, shapely.buffer(shapely.points(centres), near * self.mesh.pitch))
        return found

    @cached_property
    def placed(self) -> Latest[tuple[Shapes, Shapes]]:
        """The parts of both gears (n,) that are near the pitch point at rolling lengths (n,), in their places."""
        return Latest(self._placed)

    def _placed(self, at: Array) -> tuple[Shapes, Shapes]:
        found = []
        for k, gear in enumerate(self.mesh.gears):
            own = self.mesh.pair.senses[k] * at - gear.flanks.phase
            teeth: Integers = np.mod(np.rint(own / self.mesh.pitch), gear.z).astype(int)
            found.append(moved(self.parts[k][teeth], self.mesh.places(at)[k]))
        shapely.prepare(found[0])
        return found[0], found[1]

    def overlaps(self, at: Array) -> Array:
        """Areas (n,) that both gears share at rolling lengths (n,) [m2]."""
        one, two = self.placed(at)
        found, touch = np.zeros(len(at)), np.flatnonzero(shapely.intersects(one, two))
        found[touch] = shapely.area(shapely.intersection(one[touch], two[touch]))
        return found

    def depths(self, at: Array) -> Array:
        """Return how deep (n,) either gear reaches into the other at rolling lengths (n,) [m].

        That is the largest distance of a point of one outline, inside the other, from the other outline.
        """
        one, two = self.placed(at)
        found, touch = np.zeros(len(at)), np.flatnonzero(shapely.intersects(one, two))
        corners, owner = shapely.get_coordinates(shapely.intersection(one[touch], two[touch]), return_index=True)
        points, number = shapely.points(corners), touch[owner]
        for shapes in (one, two):
            np.maximum.at(found, number, shapely.distance(points, shapely.boundary(shapes)[number]))
        return found

    @cached_property
    def deepest(self) -> Extreme:
        """The rolling length at which the gears reach deepest into each other, and the depth [m]."""
        length = self.mesh.period * self.mesh.pitch
        count = int(np.clip(PER_PITCH * self.mesh.period, POSITIONS, MOST_POSITIONS))
        every = np.arange(count) * length / count
        at = every[np.argsort(self.overlaps(every))[-_LARGEST:]]
        around = at[np.argsort(self.depths(at))[-_DEEPEST:], None]
        at = (around + np.linspace(-1, 1, 2 * _BETWEEN + 1) * length / count).ravel()
        depths = self.depths(at)
        worst = int(np.argmax(depths))
        return Extreme(float(at[worst]), float(depths[worst]))

    def gaps(self, at: Array) -> Array:
        """Least distances (n,) of the gears at rolling lengths (n,) [m]."""
        return np.asarray(shapely.distance(*self.placed(at)))


def moved(shapes: Shapes, where: Array) -> Shapes:
    """Shapes (n,) turned and moved to places (3, n), in the plane of complex numbers."""
    own, index = shapely.get_coordinates(shapes, return_index=True)
    angle, x, y = where
    turned = (own[:, 0] + 1j * own[:, 1]) * np.exp(1j * angle)[index] + (x + 1j * y)[index]
    moved: Shapes = shapely.set_coordinates(shapes.copy(), np.column_stack([turned.real, turned.imag]))
    return moved
