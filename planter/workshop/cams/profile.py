"""The contour of a cam along the angle of its turn, in exact pieces, and what limits the roller."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from shapely import LineString

from planter.errors import GeometryError, InputError
from planter.kernels import Array
from planter.numerics import extremes
from planter.numerics.extremes import Extreme

Columns = Mapping[str, Array]
SAMPLES = 180
"""Places on a piece where its extremes are looked for."""
LARGEST_ROLLER = 1.0
_INSIDE = 1e-9
"""How far within a piece its ends are looked at, as a share of it: on the side of a joint that is the piece's."""
_CROSSING = 1e-5
"""Crossings of a contour are looked for on chords that stray by this much [m]."""


def check_roller(radius: float) -> None:
    """Raise InputError for a radius [m] that no roller has."""
    if not 0 < radius <= LARGEST_ROLLER:
        allowed = f"it must be over 0, {LARGEST_ROLLER * 1e3:g} at most"
        raise InputError(f"--roller-mm = {radius * 1e3:g} is not allowed: {allowed}")


@dataclass(frozen=True)
class Stretch:
    """A smooth piece of a contour from one angle of the cam to another, which may be the smaller."""

    kind: str
    start: float
    end: float
    course: Callable[[Array], Columns]

    def _angles(self, s: Array) -> Array:
        return self.start + (self.end - self.start) * np.clip(s, _INSIDE, 1 - _INSIDE)

    def at(self, s: Array) -> Array:
        found = self.course(self._angles(s))
        return np.column_stack([found["contact_x"], found["contact_y"]])

    def tangent(self, s: Array) -> Array:
        heading, sense = self.course(self._angles(s))["heading"], np.sign(self.end - self.start)
        return sense * np.column_stack([np.cos(heading), np.sin(heading)])

    def curvature(self, s: Array) -> Array:
        found = self.course(self._angles(s))
        curvature: Array = np.sign(self.end - self.start) * found["kappa"] / found["room"]
        return curvature


@dataclass(frozen=True)
class Profile:
    """A cam for a roller: places of the roller's centre and of the contact in the plane of the cam, by the angle.

    `course` gives at angles (n,) [rad] what the generated functions call contact_x, contact_y, heading, kappa, room,
    pressure (n,), and the pitch curve under the names in `pitch` [SI]. `breaks` are the angles of a turn, first and
    last among them, between which it is smooth. `closed`: a disc, whose contour runs round it against the angle.
    """

    name: str
    roller: float
    course: Callable[[Array], Columns]
    breaks: tuple[float, ...]
    closed: bool
    pitch: tuple[str, str]

    @cached_property
    def pieces(self) -> tuple[Stretch, ...]:
        """Exact pieces of the contour in the direction of its outline."""
        angles = tuple(reversed(self.breaks)) if self.closed else self.breaks
        return tuple(Stretch("contour", start, end, self.course) for start, end in pairwise(angles))

    @cached_property
    def pitch_pieces(self) -> tuple[Stretch, ...]:
        """The same of the pitch curve."""

        def along(angles: Array) -> Columns:
            found, (x, y) = self.course(angles), self.pitch
            return {"contact_x": found[x], "contact_y": found[y], "heading": found["heading"], "kappa": found["kappa"],
                    "room": np.ones(len(angles))}  # fmt: skip

        return tuple(Stretch("pitch", piece.start, piece.end, along) for piece in self.pieces)

    def least(self, column: str) -> Extreme:
        """Least value of a column over a turn, both sides of every joint."""
        return min((extremes.least(lambda at: self.course(at)[column], places) for places in self._places()),
                   key=lambda found: found.value)  # fmt: skip

    def largest(self, column: str) -> Extreme:
        """Largest value of a column, as `least` has the least."""
        return max((extremes.largest(lambda at: self.course(at)[column], places) for places in self._places()),
                   key=lambda found: found.value)  # fmt: skip

    def _places(self) -> list[Array]:
        inside = np.linspace(_INSIDE, 1 - _INSIDE, SAMPLES)
        return [start + (end - start) * inside for start, end in pairwise(self.breaks)]

    def check(self) -> Extreme:
        """How far the roller is from cutting off its own contour, and where: 1 - radius / radius of curvature.

        Raises GeometryError, naming the angle and the radius, where it does.
        """
        found = self.least("room")
        if found.value <= 0:
            radius, angle = self.roller / (1 - found.value), np.degrees(found.place)
            raise GeometryError(
                f"{self.name}: a roller of a radius of {self.roller * 1e3:g} mm cuts off its own contour at a cam "
                f"angle of {angle:.4g} deg, where the pitch curve has a radius of {radius * 1e3:.4g} mm: "
                "the roller's must be less"
            )
        if not LineString(np.vstack([piece.at(np.linspace(0, 1, SAMPLES)) for piece in self.pieces])).is_simple:
            raise GeometryError(f"{self.name}: the contour for a roller of {self.roller * 1e3:g} mm crosses itself")
        return found
