"""Overlay of the outlines of two gears as polygons: a check of the mesh that is independent of
flanks and racks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from planter.gears.geometry.gear import KINDS, Gear
from planter.gears.geometry.mesh import POSITIONS, Mesh
from planter.kernels import Array, Integers
from planter.numerics.arrays import LastCallCache
from planter.numerics.extrema import ExtremePoint

CHORDS = {"fillet": 16, "flank": 24, "tip": 2, "root": 2}
"""Chords of each kind of piece: those of flanks deviate by 1e-4 modules."""
FINE_CHORDS = {"fillet": 64, "flank": 48, "tip": 16, "root": 16}
"""Chords for the depth of penetration: they deviate by 2e-4 modules, concave ones by 1.5e-4."""
POSITIONS_PER_PITCH, MAX_POSITIONS = 48, 4800
"""Positions per pitch of a period in the search for the depth of penetration, and their largest
number.
"""
_LARGEST, _DEEPEST, _BETWEEN = 60, 3, 8
"""Number of positions with the largest overlap, of the deepest among them that are refined, and of
refined positions on either side of each.
"""
_PART_MARGIN = 0.75
"""Pitches about a tooth's centre that belong to its part of a gear, in addition to half the contact
ratio.
"""

Shapes = NDArray[np.object_]


def build_polygon(gear: Gear, chords: Mapping[str, int] = CHORDS) -> Array:
    """Return vertices (n, 2) [m] of the outline in order, with a number of chords for each kind of
    piece.
    """
    pieces = gear.pieces
    vertices: dict[int, Array] = {}
    for kind, count in chords.items():
        index = np.flatnonzero(pieces.kind == KINDS.index(kind))
        cut = gear.sampled(np.arange(count) / count, index).points
        vertices |= {int(number): cut[:, k] for k, number in enumerate(index)}
    return np.hstack([vertices[number] for number in range(len(pieces.kind))]).T


@dataclass(frozen=True)
class Overlay:
    """The polygons of both gears of a mesh, each in the frame of its axis."""

    mesh: Mesh
    outlines: tuple[Any, Any]

    @classmethod
    def from_mesh(cls, mesh: Mesh, chords: Mapping[str, int] = CHORDS) -> Overlay:
        """Return the polygons of a mesh with a number of chords for each kind of piece."""
        polygon, mate_polygon = (
            shapely.Polygon(build_polygon(gear, chords)) for gear in mesh.gears
        )
        return cls(mesh, (polygon, mate_polygon))

    @cached_property
    def parts(self) -> tuple[Shapes, Shapes]:
        """Parts (z,) of each gear near each of its teeth."""
        gear_parts, mate_parts = (
            self._parts(gear, outline)
            for gear, outline in zip(self.mesh.gears, self.outlines, strict=True)
        )
        return gear_parts, mate_parts

    def _parts(self, gear: Gear, outline: Any) -> Shapes:
        centres = gear.curve.at(gear.flanks.centre[: gear.z])[:2].T
        radius = self.mesh.contact_ratios.max() / 2 + _PART_MARGIN
        return shapely.intersection(
            outline, shapely.buffer(shapely.points(centres), radius * self.mesh.pitch)
        )

    @cached_property
    def placed(self) -> LastCallCache[tuple[Shapes, Shapes]]:
        """Parts (n,) of both gears near the pitch point at rolling lengths (n,), in their
        positions.
        """
        return LastCallCache(self._placed)

    def _placed(self, at: Array) -> tuple[Shapes, Shapes]:
        shapes = []
        for k, gear in enumerate(self.mesh.gears):
            arc = self.mesh.pair.senses[k] * at - gear.flanks.phase
            teeth: Integers = np.mod(np.rint(arc / self.mesh.pitch), gear.z).astype(int)
            shapes.append(move_shapes(self.parts[k][teeth], self.mesh.places(at)[k]))
        # an index over the parts pays off, since each is compared several times
        shapely.prepare(shapes[0])
        return shapes[0], shapes[1]

    def overlaps(self, at: Array) -> Array:
        """Return overlaps (n,) [m2] of both gears at rolling lengths (n,) [m]."""
        return intersect_areas(*self.placed(at))

    def depths(self, at: Array) -> Array:
        """Return the depth (n,) [m] of mutual penetration at rolling lengths (n,) [m].

        That is the largest distance of a point of one outline, inside the other, from the other
        outline.
        """
        gear_shapes, mate_shapes = self.placed(at)
        depths, touch = (
            np.zeros(len(at)),
            np.flatnonzero(shapely.intersects(gear_shapes, mate_shapes)),
        )
        corners, owner = shapely.get_coordinates(
            shapely.intersection(gear_shapes[touch], mate_shapes[touch]), return_index=True
        )
        points, number = shapely.points(corners), touch[owner]
        for shapes in (gear_shapes, mate_shapes):
            edges = shapely.boundary(shapes)[number]
            np.maximum.at(depths, number, shapely.distance(points, edges))
        return depths

    @cached_property
    def deepest(self) -> ExtremePoint:
        """Rolling length [m] of the deepest penetration, and the depth [m]."""
        length = self.mesh.period * self.mesh.pitch
        count = int(np.clip(POSITIONS_PER_PITCH * self.mesh.period, POSITIONS, MAX_POSITIONS))
        positions = np.arange(count) * length / count
        # overlaps are cheap, and tell where depths are worth measuring
        at = positions[np.argsort(self.overlaps(positions))[-_LARGEST:]]
        centres = at[np.argsort(self.depths(at))[-_DEEPEST:], None]
        at = (centres + np.linspace(-1, 1, 2 * _BETWEEN + 1) * length / count).ravel()
        depths = self.depths(at)
        worst = int(np.argmax(depths))
        return ExtremePoint(float(at[worst]), float(depths[worst]))

    def gaps(self, at: Array) -> Array:
        """Return the smallest distances (n,) [m] of the gears at rolling lengths (n,) [m]."""
        return shapely.distance(*self.placed(at))


def move_shapes(shapes: Shapes, position: Array) -> Shapes:
    """Return shapes (n,) rotated and moved to positions (3, n): angle [rad], x and y [m]."""
    points, index = shapely.get_coordinates(shapes, return_index=True)
    angle, x, y = position
    turned = points @ np.array([1, 1j]) * np.exp(1j * angle)[index] + (x + 1j * y)[index]
    return shapely.set_coordinates(shapes.copy(), np.column_stack([turned.real, turned.imag]))


def intersect_areas(shapes: Shapes, mate_shapes: Shapes) -> Array:
    """Return the overlaps (n,) [m2] of shapes."""
    areas, touch = np.zeros(len(shapes)), np.flatnonzero(shapely.intersects(shapes, mate_shapes))
    areas[touch] = shapely.area(shapely.intersection(shapes[touch], mate_shapes[touch]))
    return areas
