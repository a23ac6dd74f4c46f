"""Bores and their keyways, by DIN 6885-1 or as told, as closed curves about an axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise

import numpy as np

from planter.errors import InputError
from planter.files.text import parse_toml
from planter.workshop.arcs import Arcs, circle
from planter.workshop.drawing import Line

_MM = 1e-3
_CHORD = 1e-6
"""How far a chord strays from its arc where a part is looked at [m]."""


@dataclass(frozen=True)
class Keyway:
    """Width, depth in the hub from the crown of the bore [m], and direction from the axis [rad]."""

    width: float
    depth: float
    phase: float = 0.0


@dataclass(frozen=True)
class Bore:
    """A bore about the origin by its diameter [m], with a keyway or without.

    Raises InputError for a keyway that is not narrower than the bore.
    """

    diameter: float
    keyway: Keyway | None = None

    def __post_init__(self) -> None:
        if self.keyway is not None and not self.keyway.width < self.diameter:
            told = f"{self.keyway.width / _MM:g} mm is not allowed: it must be less than the bore's"
            raise InputError(f"a keyway of a width of {told} {self.diameter / _MM:g} mm")

    @property
    def reach(self) -> float:
        """How far from the axis it cuts at most [m]."""
        if self.keyway is None:
            return self.diameter / 2
        return float(np.hypot(self.diameter / 2 + self.keyway.depth, self.keyway.width / 2))

    @property
    def edge(self) -> Arcs:
        """Its whole edge, keyway included, anticlockwise."""
        if self.keyway is None:
            return circle(self.diameter / 2)
        slot = self._slot(self.keyway)
        round_ = np.tan((np.pi + slot.half_angles[-1]) / 2)
        return Arcs(slot.vertices, np.array([0.0, 0.0, 0.0, round_]))

    def lines(self, turn: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)) -> Iterator[Line]:
        """The bore's circle, and the keyway's own outline, whose inner side lies on it."""
        yield Line("BORE", circle(self.diameter / 2, centre))
        if self.keyway is not None:
            yield Line("KEYWAY", self._slot(self.keyway).moved(turn, centre))

    def _slot(self, keyway: Keyway) -> Arcs:
        half, radius = keyway.width / 2, self.diameter / 2
        near, far = np.sqrt(radius**2 - half**2), radius + keyway.depth
        corners = np.array([[near, -half], [far, -half], [far, half], [near, half]])
        inner = -np.tan(np.arcsin(half / radius) / 2)
        return Arcs(corners, np.array([0.0, 0.0, 0.0, inner])).moved(keyway.phase)


def standard(diameter: float) -> tuple[float, float]:
    """Width and depth in the hub [m] of the keyway of a bore [m] by DIN 6885-1.

    Raises InputError for a bore that the standard has none for.

    >>> standard(0.020)
    (0.006, 0.0028)
    """
    name = "keyways.toml"
    table = parse_toml(resources.files(__package__).joinpath(name).read_text(encoding="utf-8"), name)
    limits = [table["least_bore_mm"], *(row["bore_mm"] for row in table["rows"])]
    for (low, high), row in zip(pairwise(limits), table["rows"], strict=True):
        if low < diameter / _MM <= high:
            return row["width_mm"] * _MM, row["depth_mm"] * _MM
    raise InputError(
        f"a bore of {diameter / _MM:g} mm has no keyway in {table['source']}: it must be over {limits[0]} mm, "
        f"{limits[-1]} mm at most, or the keyway's width and depth be given"
    )


def check_wall(bore: Bore, outline: Arcs, name: str, least: float) -> float:
    """Return the least wall [m] between a bore, its keyway included, and the outline of a part.

    Raises InputError where it is below `least` > 0 [m].
    """
    from shapely import Polygon

    part, edge = (Polygon(arcs.points(_CHORD)) for arcs in (outline, bore.edge))
    wall = float(part.exterior.distance(edge)) if part.contains(edge) else 0.0
    if wall < least:
        roots = float(np.hypot(*outline.vertices.T).min())
        slot = "" if bore.keyway is None else f", with its keyway {bore.reach / _MM:.4g} mm from the axis,"
        raise InputError(
            f"{name}: a bore of {bore.diameter / _MM:g} mm{slot} is not allowed: it leaves a wall of {wall / _MM:.4g} "
            f"mm, but there must be at least {least / _MM:.4g} mm within an outline that comes as near to the axis as "
            f"{roots / _MM:.4g} mm"
        )
    return wall
