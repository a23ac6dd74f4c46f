"""Drawings on which symbols stand: a scene at a moment, and points, lengths and angles of it that carry names.

Lengths in mm, angles in deg, y upwards, as a scene has them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from planter.kernels import Array
from planter.view.scene import Body, Scene

CORNERS = 121
"""Points of an arc that is drawn."""
_EXTENT = 1e-9
"""Below it a length has no direction [mm]."""


@dataclass(frozen=True)
class Spot:
    """A point (2,); its names are those of its coordinates."""

    names: Sequence[str]
    at: Array

    @property
    def anchor(self) -> Array:
        """Where the line to its names ends (2,)."""
        return self.at

    def outline(self) -> Array:
        """Its points (1, 2)."""
        return np.array([self.at])


@dataclass(frozen=True)
class Length:
    """The distance of two points (2,); the line to its names ends at a `share` of it."""

    names: Sequence[str]
    start: Array
    end: Array
    share: float = 0.5

    @property
    def size(self) -> float:
        """How long it is."""
        return float(np.hypot(*(np.asarray(self.end) - self.start)))

    @property
    def anchor(self) -> Array:
        """Where the line to its names ends (2,)."""
        return (1 - self.share) * np.asarray(self.start) + self.share * np.asarray(self.end)

    def outline(self) -> Array:
        """Its points (2, 2)."""
        return np.array([self.start, self.end])


@dataclass(frozen=True)
class Angle:
    """A turn about a vertex (2,) from a direction, anticlockwise where it is positive, drawn at a radius."""

    names: Sequence[str]
    vertex: Array
    start: float
    turn: float
    radius: float

    @classmethod
    def between(cls, names: Sequence[str], vertex: Array, start: Array, end: Array, radius: float) -> Angle:
        """The turn of less than half a circle from the direction of a point (2,) to that of another."""
        first, second = (heading(vertex, point) for point in (start, end))
        return cls(names, vertex, first, (second - first + 180) % 360 - 180, radius)

    @property
    def anchor(self) -> Array:
        """Where the line to its names ends (2,)."""
        return self._points(np.array([self.start + self.turn / 2]))[0]

    def outline(self) -> Array:
        """Points (k, 2) of its arc."""
        return self._points(self.start + np.linspace(0, self.turn, CORNERS))

    def legs(self) -> tuple[Array, Array]:
        """Both of its sides from the vertex to a little beyond the arc, (2, 2) each."""
        ends = self.vertex + 1.15 * (self._points(np.array([self.start, self.start + self.turn])) - self.vertex)
        return np.array([self.vertex, ends[0]]), np.array([self.vertex, ends[1]])

    def _points(self, directions: Array) -> Array:
        angles = np.radians(directions)
        return np.asarray(self.vertex) + self.radius * np.column_stack([np.cos(angles), np.sin(angles)])


Mark = Spot | Length | Angle


def heading(start: Array, end: Array) -> float:
    """Direction from a point (2,) to another [deg]."""
    along, up = np.asarray(end) - start
    assert np.hypot(along, up) > _EXTENT
    return float(np.degrees(np.arctan2(up, along)))


def still(title: str, bodies: Sequence[Body]) -> Scene:
    """Bodies that do not move, as a scene."""
    return Scene(title, "", "", np.zeros(1), 1.0, bodies, again=False)


@dataclass(frozen=True)
class Sheet:
    """A drawing: the scene at a moment, with marks."""

    name: str
    title: str
    scene: Scene
    marks: Sequence[Mark]
    moment: int = 0

    @property
    def names(self) -> set[str]:
        """All names that stand on it."""
        return {name for mark in self.marks for name in mark.names}


@dataclass(frozen=True)
class Labelled:
    """A machine's sheets, and the numbers of its file by path, which say what is a key."""

    name: str
    numbers: Mapping[str, Any]
    sheets: Sequence[Sheet]


class Draughtsman(Protocol):
    """What a room brings, as `LABELS` in its module `labelled`, so that its machines are drawn with their symbols."""

    undrawn: Mapping[str, Sequence[str]]
    """Why names have no place on any sheet: patterns of names, of sources, or of the file's tables as `table.`."""

    def takes(self, source: str) -> bool:
        """Whether a file, or a built-in name, is a machine of this room."""

    def draw(self, source: str, changes: Mapping[str, float]) -> Labelled:
        """The machine in it. Raises InputError as its room does."""
