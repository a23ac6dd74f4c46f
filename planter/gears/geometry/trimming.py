"""Outlines trimmed by circles, and the pieces of outlines that no rack cuts: arcs, walls, parts,
the pitch line.

Every intersection is solved, and the remaining pieces are joined by arcs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.gears.geometry.gear import Kind, OutlinePiece
from planter.gears.geometry.pitch_curves import KAPPA, TX, TY, PitchCurve, X, Y
from planter.kernels import Array
from planter.numerics.arrays import TURN

_SAMPLES = 65
"""Points of each piece at which its side is checked."""
_XTOL = 1e-16


@dataclass(frozen=True)
class TrimmingCircle:
    """A circle that removes its inside, or its outside; `kind` is that of the resulting arcs."""

    centre: Array
    radius: float
    kind: Kind
    inside: bool = True

    def beyond(self, points: Array) -> Array:
        """Return the distance (n,) [m] of points (n, 2) from the removed region, negative inside
        it.
        """
        distance = np.hypot(*(points - self.centre).T) - self.radius
        return distance if self.inside else -distance

    def angle(self, point: Array) -> float:
        """Return the direction [rad] of a point (2,) [m] from the centre."""
        return float(np.arctan2(*(point - self.centre)[::-1]))

    def arc(self, start: Array, end: Array, tooth: int) -> CircularArc:
        """Return the arc between two of its points with the removed region on the right."""
        # along an inside circle the removed region lies on the right going clockwise
        sense = -1.0 if self.inside else 1.0
        low = self.angle(start)
        return CircularArc(
            self.kind,
            tooth,
            self.centre,
            self.radius,
            low,
            sense * (sense * (self.angle(end) - low) % TURN),
        )


@dataclass(frozen=True)
class Region:
    """The region that all of its circles remove: the inside of one, or of one minus another."""

    circles: tuple[TrimmingCircle, ...]

    def beyond(self, points: Array) -> Array:
        """Return the largest distance (n,) [m] of the circles, positive for points (n, 2) that
        remain.
        """
        return np.max([circle.beyond(points) for circle in self.circles], axis=0)

    def at(self, point: Array) -> TrimmingCircle:
        """Return the circle on which a point lies."""
        return max(self.circles, key=lambda circle: float(circle.beyond(point[None])[0]))

    def edge(self, start: Array, end: Array, tooth: int) -> Iterator[CircularArc]:
        """Yield the arcs of its edge between two points with the removed region on the right."""
        first, second = self.at(start), self.at(end)
        if first is second:
            yield first.arc(start, end, tooth)
            return
        corner = min(
            _intersect_circles(first, second),
            key=lambda point: abs(first.arc(start, point, tooth).sweep),
        )
        yield first.arc(start, corner, tooth)
        yield second.arc(corner, end, tooth)


def trim_line(pieces: Sequence[OutlinePiece], region: Region) -> list[OutlinePiece]:
    """Return the pieces of a line, whose ends remain, without a region, joined along its edge."""
    trimmed: list[OutlinePiece] = []
    gap: tuple[Array, int] | None = None
    for piece in pieces:
        for low, high, remains in _split_piece(piece, region):
            if not remains:
                gap = gap or (piece.at(np.array([low]))[0], piece.tooth)
                continue
            if gap is not None:
                trimmed += region.edge(gap[0], piece.at(np.array([low]))[0], gap[1])
                gap = None
            trimmed.append(piece if (low, high) == (0.0, 1.0) else PartialPiece(piece, low, high))
    return trimmed


def start_outside(pieces: Sequence[OutlinePiece], region: Region) -> list[OutlinePiece]:
    """Return the pieces of a closed line, beginning with the first whose start lies outside a
    region.

    Raises GeometryError if none does.
    """
    outside = region.beyond(np.vstack([piece.at(np.zeros(1)) for piece in pieces])) > 0
    if not outside.any():
        raise GeometryError("the locking arcs remove a gear completely: reduce the dwell")
    # a trimmed line must not begin in the gap that the region leaves
    first = int(np.argmax(outside))
    return [*pieces[first:], *pieces[:first]]


def _split_piece(piece: OutlinePiece, region: Region) -> Iterator[tuple[float, float, bool]]:
    """Yield parameter intervals of a piece on one side of a region's edge, and whether they
    remain.
    """
    grid = np.linspace(0, 1, _SAMPLES)
    beyond = region.beyond(piece.at(grid))
    cuts = [
        float(
            scipy.optimize.brentq(
                lambda s: float(region.beyond(piece.at(np.array([s])))[0]),
                grid[k],
                grid[k + 1],
                xtol=_XTOL,
            )
        )
        for k in np.flatnonzero((beyond[1:] > 0) != (beyond[:-1] > 0))
    ]
    for low, high in pairwise([0.0, *cuts, 1.0]):
        yield low, high, bool(region.beyond(piece.at(np.array([(low + high) / 2])))[0] > 0)


def _intersect_circles(first: TrimmingCircle, second: TrimmingCircle) -> tuple[Array, Array]:
    """Return both intersections of two circles (2,) [m]."""
    vector = second.centre - first.centre
    distance = float(np.hypot(*vector))
    offset = (distance**2 + first.radius**2 - second.radius**2) / (2 * distance)
    across = np.sqrt(first.radius**2 - offset**2)
    unit = vector / distance
    normal = np.array([-unit[1], unit[0]])
    return (
        first.centre + offset * unit + across * normal,
        first.centre + offset * unit - across * normal,
    )


@dataclass(frozen=True)
class CircularArc:
    """An arc about a centre [m], from an angle on by a sweep [rad], which is negative clockwise."""

    kind: Kind
    tooth: int
    centre: Array
    radius: float
    start: float
    sweep: float
    side: int = 0

    def _spoke(self, s: Array) -> Array:
        angle = self.start + self.sweep * s
        return np.column_stack([np.cos(angle), np.sin(angle)])

    def at(self, s: Array) -> Array:
        """Return points (n, 2) [m] at parameters (n,)."""
        return np.asarray(self.centre + self.radius * self._spoke(s))

    def tangent(self, s: Array) -> Array:
        """Return unit tangents (n, 2) at parameters (n,)."""
        return np.sign(self.sweep) * self._spoke(s)[:, ::-1] * [-1.0, 1.0]

    def curvature(self, s: Array) -> Array:
        """Return signed curvature (n,) [1/m] at parameters (n,), positive where the curve bends to
        the left.
        """
        return np.full(len(s), np.sign(self.sweep) / self.radius)


@dataclass(frozen=True)
class StraightWall:
    """A straight line from a point to another [m]."""

    tooth: int
    start: Array
    end: Array
    kind: Kind = "wall"
    side: int = 0

    def at(self, s: Array) -> Array:
        """Return points (n, 2) [m] at parameters (n,)."""
        return np.asarray(self.start + np.outer(s, self.end - self.start))

    def tangent(self, s: Array) -> Array:
        """Return unit tangents (n, 2) at parameters (n,)."""
        direction = (self.end - self.start) / np.hypot(*(self.end - self.start))
        return np.tile(direction, (len(s), 1))

    def curvature(self, s: Array) -> Array:
        """Return signed curvature (n,) [1/m] at parameters (n,), positive where the curve bends to
        the left.
        """
        return np.zeros(len(s))


@dataclass(frozen=True)
class PartialPiece:
    """The part of a piece between two of its parameters."""

    piece: OutlinePiece
    low: float
    high: float

    @property
    def kind(self) -> Kind:
        return self.piece.kind

    @property
    def tooth(self) -> int:
        return self.piece.tooth

    @property
    def side(self) -> int:
        return self.piece.side

    def _to_piece(self, s: Array) -> Array:
        return self.low + (self.high - self.low) * s

    def at(self, s: Array) -> Array:
        """Return points (n, 2) [m] at parameters (n,)."""
        return self.piece.at(self._to_piece(s))

    def tangent(self, s: Array) -> Array:
        """Return unit tangents (n, 2) at parameters (n,)."""
        return self.piece.tangent(self._to_piece(s))

    def curvature(self, s: Array) -> Array:
        """Return signed curvature (n,) [1/m] at parameters (n,), positive where the curve bends to
        the left.
        """
        return self.piece.curvature(self._to_piece(s))


@dataclass(frozen=True)
class PitchLine:
    """The pitch curve between two of its arc lengths [m], as a piece."""

    curve: PitchCurve
    low: float
    high: float
    kind: str = "pitch curve"

    def _rows(self, s: Array) -> Array:
        return self.curve.at(self.low + (self.high - self.low) * s)

    def at(self, s: Array) -> Array:
        """Return points (n, 2) [m] at parameters (n,)."""
        return self._rows(s)[[X, Y]].T

    def tangent(self, s: Array) -> Array:
        """Return unit tangents (n, 2) at parameters (n,)."""
        return self._rows(s)[[TX, TY]].T

    def curvature(self, s: Array) -> Array:
        """Return signed curvature (n,) [1/m] at parameters (n,), positive where the curve bends to
        the left.
        """
        return np.asarray(self._rows(s)[KAPPA])
