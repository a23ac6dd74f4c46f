"""Drawings with symbols: a scene at one moment, with named points, lengths and angles.

Lengths in mm, angles in deg, y upwards, as in a scene.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from planter.kernels import Array
from planter.view.scene import Body, Scene

CORNERS = 121
"""Number of points of an arc."""
_EXTENT = 1e-9
"""Length below which a direction is undefined [mm]."""


@dataclass(frozen=True)
class Spot:
    """A point (2,) [mm], named by its coordinates."""

    names: Sequence[str]
    at: Array

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the names."""
        return self.at

    def outline(self) -> Array:
        """Return the point (1, 2) [mm]."""
        return np.array([self.at])


@dataclass(frozen=True)
class Length:
    """The distance of two points (2,) [mm]; the line to its names ends at a `share` of it."""

    names: Sequence[str]
    start: Array
    end: Array
    share: float = 0.5

    @property
    def size(self) -> float:
        """Length [mm]."""
        return float(np.hypot(*(np.asarray(self.end) - self.start)))

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the names."""
        return (1 - self.share) * np.asarray(self.start) + self.share * np.asarray(self.end)

    def outline(self) -> Array:
        """Return the end points (2, 2) [mm]."""
        return np.array([self.start, self.end])


@dataclass(frozen=True)
class Angle:
    """An angle [deg] about a vertex (2,) [mm] from a direction, positive anticlockwise, drawn at a radius."""

    names: Sequence[str]
    vertex: Array
    start: float
    turn: float
    radius: float

    @classmethod
    def between(cls, names: Sequence[str], vertex: Array, start: Array, end: Array, radius: float) -> Angle:
        """Return the angle of at most 180 deg from the direction of point `start` (2,) to that of `end`."""
        first, second = (heading(vertex, point) for point in (start, end))
        return cls(names, vertex, first, (second - first + 180) % 360 - 180, radius)

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the names."""
        return self._points(np.array([self.start + self.turn / 2]))[0]

    def outline(self) -> Array:
        """Return the points (k, 2) [mm] of the arc."""
        return self._points(self.start + np.linspace(0, self.turn, CORNERS))

    def legs(self) -> tuple[Array, Array]:
        """Return both legs from the vertex to slightly beyond the arc, (2, 2) [mm] each."""
        ends = self.vertex + 1.15 * (self._points(np.array([self.start, self.start + self.turn])) - self.vertex)
        return np.array([self.vertex, ends[0]]), np.array([self.vertex, ends[1]])

    def _points(self, directions: Array) -> Array:
        angles = np.radians(directions)
        return np.asarray(self.vertex) + self.radius * np.column_stack([np.cos(angles), np.sin(angles)])


Mark = Spot | Length | Angle


def heading(start: Array, end: Array) -> float:
    """Return the direction from point `start` (2,) to `end` (2,) [deg]."""
    dx, dy = np.asarray(end) - start
    assert np.hypot(dx, dy) > _EXTENT
    return float(np.degrees(np.arctan2(dy, dx)))


def still(title: str, bodies: Sequence[Body]) -> Scene:
    """Return a scene of bodies that do not move."""
    return Scene(title, "", "", np.zeros(1), 1.0, bodies, again=False)


@dataclass(frozen=True)
class Sheet:
    """A drawing of a scene at one moment, with marks."""

    name: str
    title: str
    scene: Scene
    marks: Sequence[Mark]
    moment: int = 0

    @property
    def names(self) -> set[str]:
        """Names of all marks."""
        return {name for mark in self.marks for name in mark.names}


@dataclass(frozen=True)
class Labelled:
    """The sheets of a machine, and the numbers of its file by path, which define its keys."""

    name: str
    numbers: Mapping[str, Any]
    sheets: Sequence[Sheet]


class Draughtsman(Protocol):
    """The object `LABELS` in the module `labelled` of a package, which draws its machines with symbols."""

    undrawn: Mapping[str, Sequence[str]]
    """Reasons why names are on no sheet, with patterns of names, of sources, or of the file's tables as `table.`."""

    def takes(self, source: str) -> bool:
        """Return whether a file or built-in name is a machine of this package."""

    def draw(self, source: str, changes: Mapping[str, float]) -> Labelled:
        """Return the sheets of a machine with changed numbers. Raises InputError if it is invalid."""
