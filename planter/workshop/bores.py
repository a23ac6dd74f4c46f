"""Bores and their keyways, by DIN 6885-1 or by dimensions, as closed curves about an axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise

import numpy as np

from planter.errors import InputError
from planter.files.text import parse_toml
from planter.workshop.arcs import Arcs, build_circle
from planter.workshop.drawing import DrawingLine

_MM = 1e-3
_CHORD = 1e-6
"""Deviation of chords from arcs in the measurement of walls [m]."""


@dataclass(frozen=True)
class Keyway:
    """Width, depth in the hub from the crown of the bore [m], and direction from the axis [rad]."""

    width: float
    depth: float
    phase: float = 0.0


@dataclass(frozen=True)
class Bore:
    """A bore about the origin by its diameter [m], with a keyway or without.

    Raises InputError if the keyway is not narrower than the bore.
    """

    diameter: float
    keyway: Keyway | None = None

    def __post_init__(self) -> None:
        if self.keyway is not None and not self.keyway.width < self.diameter:
            raise InputError(
                f"keyway width = {self.keyway.width / _MM:g} mm: it must be below the bore's {self.diameter / _MM:g} mm"
            )

    @property
    def reach(self) -> float:
        """Largest distance of the edge from the axis [m]."""
        if self.keyway is None:
            return self.diameter / 2
        return float(np.hypot(self.diameter / 2 + self.keyway.depth, self.keyway.width / 2))

    @property
    def edge(self) -> Arcs:
        """The edge with the keyway, anticlockwise."""
        if self.keyway is None:
            return build_circle(self.diameter / 2)
        slot = self._slot(self.keyway)
        bulge = np.tan((np.pi + slot.half_angles[-1]) / 2)
        return Arcs(slot.vertices, np.array([0.0, 0.0, 0.0, bulge]))

    def lines(self, turn: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)) -> Iterator[DrawingLine]:
        """Yield the circle of the bore, and the outline of the keyway, whose inner side lies on it."""
        yield DrawingLine("BORE", build_circle(self.diameter / 2, centre))
        if self.keyway is not None:
            yield DrawingLine("KEYWAY", self._slot(self.keyway).moved(turn, centre))

    def _slot(self, keyway: Keyway) -> Arcs:
        half, radius = keyway.width / 2, self.diameter / 2
        inner_x, outer_x = np.sqrt(radius**2 - half**2), radius + keyway.depth
        corners = np.array([[inner_x, -half], [outer_x, -half], [outer_x, half], [inner_x, half]])
        inner_bulge = -np.tan(np.arcsin(half / radius) / 2)
        return Arcs(corners, np.array([0.0, 0.0, 0.0, inner_bulge])).moved(keyway.phase)


def find_standard_keyway(diameter: float) -> tuple[float, float]:
    """Return width and depth in the hub [m] of the keyway of a bore [m] by DIN 6885-1.

    Raises InputError for a bore outside the range of the standard.

    >>> find_standard_keyway(0.020)
    (0.006, 0.0028)
    """
    name = "keyways.toml"
    table = parse_toml(resources.files(__package__).joinpath(name).read_text(encoding="utf-8"), name)
    limits = [table["least_bore_mm"], *(row["bore_mm"] for row in table["rows"])]
    for (low, high), row in zip(pairwise(limits), table["rows"], strict=True):
        if low < diameter / _MM <= high:
            return row["width_mm"] * _MM, row["depth_mm"] * _MM
    raise InputError(
        f"a bore of {diameter / _MM:g} mm has no keyway in {table['source']}: choose a bore over {limits[0]} mm "
        f"and up to {limits[-1]} mm, or give the width and depth of the keyway"
    )


def check_wall(bore: Bore, outline: Arcs, name: str, limit: float) -> float:
    """Return the smallest wall [m] between a bore with its keyway and the outline of a part.

    Raises InputError if it is below `limit` > 0 [m].
    """
    from shapely import Polygon

    part, edge = (Polygon(arcs.points(_CHORD)) for arcs in (outline, bore.edge))
    wall = float(part.exterior.distance(edge)) if part.contains(edge) else 0.0
    if wall < limit:
        roots = float(np.hypot(*outline.vertices.T).min())
        slot = "" if bore.keyway is None else f", with its keyway {bore.reach / _MM:.4g} mm from the axis,"
        raise InputError(
            f"{name}: a bore of {bore.diameter / _MM:g} mm{slot} leaves a wall of {wall / _MM:.4g} mm; at least "
            f"{limit / _MM:.4g} mm are needed inside an outline whose smallest radius is {roots / _MM:.4g} mm"
        )
    return wall
