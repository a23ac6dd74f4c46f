"""Smooth pieces of outlines, and outlines trimmed by circles.

Every intersection is solved, and the remaining pieces are joined by arcs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.kernels import Array
from planter.numerics.arrays import TURN, LastCallCache

_SAMPLES = 65
"""Points of each piece at which its side is checked."""
_XTOL = 1e-16


@dataclass(frozen=True)
class Piece:
    """A smooth piece of a curve by a parameter s that runs from 0 to 1 in the curve's direction,
    which is anticlockwise on an outline.

    `evaluate` returns rows (5, n) at parameters (n,): points [m], unit tangents, and curvature
    [1/m], positive where the curve bends to the left. `tooth` is the number of the tooth; a root
    has that of the tooth before it. `side` is +1 on the flank that ends a tooth in the outline's
    direction and on its fillet, -1 on the one that begins it, else 0.
    """

    kind: str
    evaluate: Callable[[Array], Array]
    tooth: int = 0
    side: int = 0

    @cached_property
    def rows(self) -> LastCallCache[Array]:
        """`evaluate` with the last rows cached: points and tangents are often requested in turn."""
        return LastCallCache(self.evaluate)

    def at(self, s: Array) -> Array:
        """Return points (n, 2) [m] at parameters (n,)."""
        return self.rows(s)[:2].T

    def tangent(self, s: Array) -> Array:
        """Return unit tangents (n, 2) at parameters (n,)."""
        return self.rows(s)[2:4].T

    def curvature(self, s: Array) -> Array:
        """Return signed curvature (n,) [1/m] at parameters (n,)."""
        return self.rows(s)[4]

    @property
    def start(self) -> Array:
        """The point (2,) at which the piece begins [m]."""
        return self.at(np.zeros(1))[0]

    @property
    def end(self) -> Array:
        """The point (2,) at which the piece ends [m]."""
        return self.at(np.ones(1))[0]

    def part(self, low: float, high: float) -> Piece:
        """Return the part between two parameters."""
        return replace(self, evaluate=lambda s: self.rows(low + (high - low) * s))


def build_arc(
    kind: str, tooth: int, centre: Array, radius: float, start: float, sweep: float
) -> Piece:
    """Return an arc about a centre (2,) [m] from an angle on by a sweep [rad], negative if
    clockwise.
    """
    x, y = centre
    sense = np.sign(sweep)

    def evaluate(s: Array) -> Array:
        angle = start + sweep * s
        c, d = np.cos(angle), np.sin(angle)
        bend = np.full_like(c, sense / radius)
        return np.array([x + radius * c, y + radius * d, -sense * d, sense * c, bend])

    return Piece(kind, evaluate, tooth)


def build_wall(tooth: int, start: Array, end: Array) -> Piece:
    """Return a straight line from a point (2,) to another [m]."""
    direction = (end - start) / np.hypot(*(end - start))

    def evaluate(s: Array) -> Array:
        points = start[:, None] + np.outer(end - start, s)
        return np.vstack([points, np.outer(direction, np.ones_like(s)), np.zeros_like(s)])

    return Piece("wall", evaluate, tooth)


@dataclass(frozen=True)
class TrimmingCircle:
    """A circle that removes its inside, or its outside; `kind` is that of the resulting arcs."""

    centre: Array
    radius: float
    kind: str
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

    def sweep(self, start: Array, end: Array) -> float:
        """Return the angle [rad] from a point to another with the removed region on the right."""
        # along an inside circle the removed region lies on the right going clockwise
        sense = -1.0 if self.inside else 1.0
        return sense * (sense * (self.angle(end) - self.angle(start)) % TURN)

    def arc(self, start: Array, end: Array, tooth: int) -> Piece:
        """Return the arc between two of its points with the removed region on the right."""
        sweep = self.sweep(start, end)
        return build_arc(self.kind, tooth, self.centre, self.radius, self.angle(start), sweep)


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

    def edge(self, start: Array, end: Array, tooth: int) -> Iterator[Piece]:
        """Yield the arcs of its edge between two points with the removed region on the right."""
        first, second = self.at(start), self.at(end)
        if first is second:
            yield first.arc(start, end, tooth)
            return
        corners = _intersect_circles(first, second)
        corner = min(corners, key=lambda point: abs(first.sweep(start, point)))
        yield first.arc(start, corner, tooth)
        yield second.arc(corner, end, tooth)


def trim_line(pieces: Sequence[Piece], region: Region) -> list[Piece]:
    """Return the pieces of a line, whose ends remain, without a region, joined along its edge."""
    trimmed: list[Piece] = []
    gap: tuple[Array, int] | None = None
    for piece in pieces:
        for low, high, remains in _split_piece(piece, region):
            part = piece if (low, high) == (0.0, 1.0) else piece.part(low, high)
            if not remains:
                gap = gap or (part.start, piece.tooth)
                continue
            if gap is not None:
                trimmed += region.edge(gap[0], part.start, gap[1])
                gap = None
            trimmed.append(part)
    return trimmed


def start_outside(pieces: Sequence[Piece], region: Region) -> list[Piece]:
    """Return the pieces of a closed line, beginning with the first whose start lies outside a
    region.

    Raises GeometryError if none does.
    """
    outside = region.beyond(np.array([piece.start for piece in pieces])) > 0
    if not outside.any():
        raise GeometryError("the locking arcs remove a gear completely: reduce the dwell")
    # a trimmed line must not begin in the gap that the region leaves
    first = int(np.argmax(outside))
    return [*pieces[first:], *pieces[:first]]


def _split_piece(piece: Piece, region: Region) -> Iterator[tuple[float, float, bool]]:
    """Yield parameter intervals of a piece on one side of a region's edge, and whether they
    remain.
    """

    def beyond(s: float) -> float:
        return float(region.beyond(piece.at(np.array([s])))[0])

    grid = np.linspace(0, 1, _SAMPLES)
    remains = region.beyond(piece.at(grid)) > 0
    changes = np.flatnonzero(remains[1:] != remains[:-1])
    cuts = [scipy.optimize.brentq(beyond, grid[k], grid[k + 1], xtol=_XTOL) for k in changes]
    for low, high in pairwise([0.0, *map(float, cuts), 1.0]):
        yield low, high, beyond((low + high) / 2) > 0


def _intersect_circles(first: TrimmingCircle, second: TrimmingCircle) -> tuple[Array, Array]:
    """Return both intersections of two circles (2,) [m]."""
    vector = second.centre - first.centre
    distance = float(np.hypot(*vector))
    offset = (distance**2 + first.radius**2 - second.radius**2) / (2 * distance)
    across = np.sqrt(first.radius**2 - offset**2)
    unit = vector / distance
    normal = np.array([-unit[1], unit[0]])
    foot = first.centre + offset * unit
    return foot + across * normal, foot - across * normal
