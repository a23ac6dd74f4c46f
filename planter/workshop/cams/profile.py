"""Contour of a cam by its angle, in exact pieces, with the limits of its roller: undercutting and lift-off."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq
from shapely import LineString

from planter.errors import GeometryError, InputError
from planter.kernels import Array
from planter.numerics import extrema
from planter.numerics.extrema import ExtremePoint

Columns = Mapping[str, Array]
SAMPLES = 180
"""Points of a piece from which its extremes are searched."""
MAX_ROLLER_RADIUS = 1.0
_END_OFFSET = 1e-9
"""Share of a piece by which its ends are moved inwards, to the piece's side of a breakpoint."""
_CHORD_TOLERANCE = 1e-5
"""Deviation of the chords in the search for self-intersections [m]."""


def check_roller(radius: float) -> None:
    """Raise InputError if a roller radius [m] is out of range."""
    if not 0 < radius <= MAX_ROLLER_RADIUS:
        raise InputError(f"--roller-mm = {radius * 1e3:g}: give a radius above 0 and up to {MAX_ROLLER_RADIUS * 1e3:g}")


@dataclass(frozen=True)
class ContourPiece:
    """A smooth piece of a contour from one angle of the cam [rad] to another, which may be smaller."""

    kind: str
    start: float
    end: float
    course: Callable[[Array], Columns]

    def _angles(self, s: Array) -> Array:
        return self.start + (self.end - self.start) * np.clip(s, _END_OFFSET, 1 - _END_OFFSET)

    def at(self, s: Array) -> Array:
        columns = self.course(self._angles(s))
        return np.column_stack([columns["contact_x"], columns["contact_y"]])

    def tangent(self, s: Array) -> Array:
        heading, sense = self.course(self._angles(s))["heading"], np.sign(self.end - self.start)
        return sense * np.column_stack([np.cos(heading), np.sin(heading)])

    def curvature(self, s: Array) -> Array:
        columns = self.course(self._angles(s))
        curvature: Array = np.sign(self.end - self.start) * columns["kappa"] / columns["room"]
        return curvature


@dataclass(frozen=True)
class Profile:
    """A cam for a roller: positions of the roller's centre and of the contact in the plane of the cam, by the angle.

    `course` returns at angles (n,) [rad] the columns of the generated functions contact_x, contact_y, heading, kappa,
    room, pressure (n,), and the pitch curve under the names in `pitch` [SI]. `breaks` are the breakpoints
    of a turn [rad], first and last included. `closed`: a disc, whose contour runs against the angle.
    """

    name: str
    roller: float
    course: Callable[[Array], Columns]
    breaks: tuple[float, ...]
    closed: bool
    pitch: tuple[str, str]

    @cached_property
    def pieces(self) -> tuple[ContourPiece, ...]:
        """Exact pieces of the contour in the direction of its outline."""
        angles = tuple(reversed(self.breaks)) if self.closed else self.breaks
        return tuple(ContourPiece("contour", start, end, self.course) for start, end in pairwise(angles))

    @cached_property
    def pitch_pieces(self) -> tuple[ContourPiece, ...]:
        """Exact pieces of the pitch curve in the direction of the outline."""

        def evaluate_pitch(angles: Array) -> Columns:
            columns, (x, y) = self.course(angles), self.pitch
            return {
                "contact_x": columns[x],
                "contact_y": columns[y],
                "heading": columns["heading"],
                "kappa": columns["kappa"],
                "room": np.ones(len(angles)),
            }

        return tuple(ContourPiece("pitch", piece.start, piece.end, evaluate_pitch) for piece in self.pieces)

    def find_smallest(self, column: str) -> ExtremePoint:
        """Return the smallest value of a column over a turn, on both sides of every breakpoint."""
        candidates = (
            extrema.find_minimum(lambda at: self.course(at)[column], places) for places in self._sample_pieces()
        )
        return min(candidates, key=lambda extremum: extremum.value)

    def find_largest(self, column: str) -> ExtremePoint:
        """Return the largest value of a column over a turn, on both sides of every breakpoint."""
        candidates = (
            extrema.find_maximum(lambda at: self.course(at)[column], places) for places in self._sample_pieces()
        )
        return max(candidates, key=lambda extremum: extremum.value)

    def _sample_pieces(self) -> list[Array]:
        inside = np.linspace(_END_OFFSET, 1 - _END_OFFSET, SAMPLES)
        return [start + (end - start) * inside for start, end in pairwise(self.breaks)]

    def check_clearance(self) -> ExtremePoint:
        """Return the smallest margin against undercutting, 1 - radius / radius of curvature, and its angle.

        Raises GeometryError, naming the angle and the radius, if the roller undercuts the contour.
        """
        clearance = self.find_smallest("room")
        if clearance.value <= 0:
            radius, angle = self.roller / (1 - clearance.value), np.degrees(clearance.place)
            raise GeometryError(
                f"{self.name}: a roller of a radius of {self.roller * 1e3:g} mm undercuts the contour at a cam "
                f"angle of {angle:.4g} deg, where the pitch curve has a radius of {radius * 1e3:.4g} mm: "
                "choose a smaller roller"
            )
        if not LineString(np.vstack([piece.at(np.linspace(0, 1, SAMPLES)) for piece in self.pieces])).is_simple:
            raise GeometryError(f"{self.name}: the contour for a roller of {self.roller * 1e3:g} mm crosses itself")
        return clearance


MIN_SPEED_SHARE = 1e-3
"""Share of a machine's speed that stands for rest, at which directions of sliding are still defined."""
MAX_SPEED_RATIO = 64
"""Multiple of a machine's speed up to which a lift-off is searched."""
_ANGLES = 2 * np.pi * np.arange(720) / 720
Push = Callable[[Array, float], Array]
"""Contact force (n,) [N], positive where the cam pushes, at angles (n,) [rad] and a speed [rad/s]."""


@dataclass(frozen=True)
class RollerLiftOff:
    """A speed [rad/s], and the angle [rad] at which the roller lifts off first."""

    speed: float
    angle: float


def find_lift_off(push: Push, speed: float) -> RollerLiftOff | None:
    """Return the lowest speed at which the contact force vanishes in a turn, or None up to `MAX_SPEED_RATIO` times
    `speed`.

    The speed is zero if nothing presses the roller on at rest.
    """
    low, high = MIN_SPEED_SHARE * speed, speed
    rest = _find_smallest_force(push, low)
    if rest.value <= 0:
        return RollerLiftOff(0.0, rest.place % (2 * np.pi))
    while _find_smallest_force(push, high).value > 0:
        low, high = high, 2 * high
        if abs(high) > MAX_SPEED_RATIO * abs(speed):
            return None
    critical = float(brentq(lambda trial: _find_smallest_force(push, trial).value, low, high, rtol=1e-12))
    return RollerLiftOff(critical, _find_smallest_force(push, critical).place % (2 * np.pi))


def _find_smallest_force(push: Push, speed: float) -> extrema.ExtremePoint:
    return extrema.find_minimum(lambda angles: push(angles, speed), _ANGLES, closed=True)
