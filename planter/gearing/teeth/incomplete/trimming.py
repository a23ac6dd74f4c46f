"""Outlines less what lies inside circles, or between them: every crossing solved, the pieces joined by arcs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.incomplete.segments import Arc, Part
from planter.gearing.teeth.outline import Kind, Piece
from planter.kernels import Array
from planter.numerics.angles import TURN

_TRIED = 65
"""Places on each piece where it is asked on which side it is."""
_XTOL = 1e-16


@dataclass(frozen=True)
class Circle:
    """A circle that takes away what lies inside it, or what lies outside; `kind` is that of the arcs it leaves."""

    centre: Array
    radius: float
    kind: Kind
    inside: bool = True

    def beyond(self, points: Array) -> Array:
        """How far points (n, 2) are from being taken away [m], negative where they are."""
        distance = np.hypot(*(points - self.centre).T) - self.radius
        return distance if self.inside else -distance

    def angle(self, point: Array) -> float:
        return float(np.arctan2(*(point - self.centre)[::-1]))

    def arc(self, start: Array, end: Array, tooth: int) -> Arc:
        """From one point of it to another, so that what is taken away lies to the right."""
        sense = -1.0 if self.inside else 1.0
        low = self.angle(start)
        return Arc(self.kind, tooth, self.centre, self.radius, low, sense * (sense * (self.angle(end) - low) % TURN))


@dataclass(frozen=True)
class Region:
    """What all of its circles take away: the inside of one, or of one less that of another."""

    circles: tuple[Circle, ...]

    def beyond(self, points: Array) -> Array:
        """Positive (n,) where points are left, the largest of the circles'."""
        return np.max([circle.beyond(points) for circle in self.circles], axis=0)

    def at(self, point: Array) -> Circle:
        """The circle whose line a point is on."""
        return max(self.circles, key=lambda circle: float(circle.beyond(point[None])[0]))

    def edge(self, start: Array, end: Array, tooth: int) -> Iterator[Arc]:
        """Along its edge from a point to another, with what it takes away to the right."""
        one, other = self.at(start), self.at(end)
        if one is other:
            yield one.arc(start, end, tooth)
            return
        corner = min(_crossings(one, other), key=lambda point: abs(one.arc(start, point, tooth).sweep))
        yield one.arc(start, corner, tooth)
        yield other.arc(corner, end, tooth)


def without(pieces: Sequence[Piece], region: Region) -> list[Piece]:
    """The pieces of a line, whose start and end are left, less what a region takes away, joined along its edge."""
    found: list[Piece] = []
    left: tuple[Array, int] | None = None
    for piece in pieces:
        for low, high, kept in _parts(piece, region):
            if not kept:
                left = left or (piece.at(np.array([low]))[0], piece.tooth)
                continue
            if left is not None:
                found += region.edge(left[0], piece.at(np.array([low]))[0], left[1])
                left = None
            found.append(piece if (low, high) == (0.0, 1.0) else Part(piece, low, high))
    return found


def opened(pieces: Sequence[Piece], region: Region) -> list[Piece]:
    """The pieces of a closed line, begun with the first whose start a region leaves.

    Raises GeometryError where it leaves none.
    """
    left = region.beyond(np.vstack([piece.at(np.zeros(1)) for piece in pieces])) > 0
    if not left.any():
        raise GeometryError("the locking arcs leave nothing of a gear: the dwell must be less")
    first = int(np.argmax(left))
    return [*pieces[first:], *pieces[:first]]


def _parts(piece: Piece, region: Region) -> Iterator[tuple[float, float, bool]]:
    """Parameters between which a piece is on one side of a region's edge, and whether it is left there."""
    from scipy.optimize import brentq

    grid = np.linspace(0, 1, _TRIED)
    beyond = region.beyond(piece.at(grid))
    cuts = [
        float(brentq(lambda s: float(region.beyond(piece.at(np.array([s])))[0]), grid[k], grid[k + 1], xtol=_XTOL))
        for k in np.flatnonzero((beyond[1:] > 0) != (beyond[:-1] > 0))
    ]
    for low, high in pairwise([0.0, *cuts, 1.0]):
        yield low, high, bool(region.beyond(piece.at(np.array([(low + high) / 2])))[0] > 0)


def _crossings(one: Circle, other: Circle) -> tuple[Array, Array]:
    """Both points that two circles share."""
    apart = other.centre - one.centre
    distance = float(np.hypot(*apart))
    along = (distance**2 + one.radius**2 - other.radius**2) / (2 * distance)
    across = np.sqrt(one.radius**2 - along**2)
    unit = apart / distance
    normal = np.array([-unit[1], unit[0]])
    return one.centre + along * unit + across * normal, one.centre + along * unit - across * normal
