"""Cubic B-splines through value points: the closed one of the paper over chord length, and open
ones between corners.

The control points of the closed curve solve the cyclic system that (2), (3) of Yu et al. (2023)
stand for.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from heapq import heapify, heappop, heappush
from math import comb
from typing import Any

import numpy as np
import scipy

from planter.kernels import Array, Integers

DEGREE = 3
_TO_BERNSTEIN = np.array(
    [[comb(i, k) / comb(5, k) if k <= i else 0.0 for k in range(6)] for i in range(6)]
)
"""From powers on [0, 1] to Bernstein's basis, whose coefficients bound the polynomial."""
NEAR = 1e-6
"""Part of the curve's length around an extreme in which differences to it are taken from their
series.
"""


@dataclass(frozen=True)
class DistanceExtreme:
    """An extreme of the distance from O: parameter, place (2,), and whether it is a maximum."""

    u: float
    place: Array
    highest: bool

    @property
    def distance(self) -> float:
        return float(np.hypot(*self.place))


def chord_lengths(points: Array, closed: bool) -> Array:
    """Distances from each point (n, 2) to the next, (n,), or (n - 1,) for an open curve."""
    ring = np.vstack([points, points[:1]]) if closed else points
    return np.hypot(*np.diff(ring, axis=0).T)


def best_spline(points: Array, closed: bool) -> PathSpline:
    """The spline over chord length or over the points' own numbers: that which better foretells
    every other point.

    If the tip stops, its path has a cusp, which no smooth curve over chord length is near; over
    numbers of points that follow each other evenly it is smooth.
    """
    lengths = np.concatenate([[0.0], np.cumsum(chord_lengths(points, closed))])
    numbers = np.arange(len(lengths), dtype=float)
    parameter = min((numbers, lengths), key=lambda taken: _miss(taken[: len(points)], points))
    return PathSpline(points, closed, parameter)


def _miss(parameter: Array, points: Array) -> float:
    """Root mean square distance of every other point from the curve through those between."""
    curve = scipy.interpolate.make_interp_spline(parameter[::2], points[::2], k=DEGREE)
    odd = slice(1, len(points) - 1, 2)
    return float(np.sqrt(np.mean((curve(parameter[odd]) - points[odd]) ** 2)))


@dataclass(frozen=True)
class PathSpline:
    """The curve through value points (n, 2) in m; `closed` joins the last to the first with two
    derivatives.

    `parameter` (n,), or (n + 1,) for a closed curve, is increasing; without one it is the
    cumulative chord length.
    """

    points: Array
    closed: bool = True
    parameter: Array | None = None

    @cached_property
    def knots(self) -> Array:
        """The parameter at the value points, from 0; a closed curve has one more, where it meets
        its beginning.
        """
        if self.parameter is not None:
            return self.parameter - self.parameter[0]
        return np.concatenate([[0.0], np.cumsum(chord_lengths(self.points, self.closed))])

    @cached_property
    def curve(self) -> scipy.interpolate.BSpline:
        if self.closed:
            ring = np.vstack([self.points, self.points[:1]])
            return scipy.interpolate.make_interp_spline(
                self.knots, ring, k=DEGREE, bc_type="periodic"
            )
        return scipy.interpolate.make_interp_spline(self.knots, self.points, k=DEGREE)

    @property
    def length(self) -> float:
        """Length of the parameter's range."""
        return float(self.knots[-1])

    def __call__(self, u: Any, derivative: int = 0) -> Array:
        """Places (m, 2), or derivatives of them in the parameter."""
        return np.asarray(self.curve(np.asarray(u, dtype=float), derivative))

    @cached_property
    def _pieces(self) -> list[scipy.interpolate.PPoly]:
        return [
            scipy.interpolate.PPoly.from_spline((self.curve.t, self.curve.c[:, axis], DEGREE))
            for axis in (0, 1)
        ]

    def extremes(self, tolerance: float) -> list[DistanceExtreme]:
        """Extremes of the distance from O by parameter: roots of S .

        S', without those that differ by less.
        """
        roots = [
            DistanceExtreme(float(u), self(u), self._bend(u) < 0)
            for u in self._roots()
            if self._bend(u) != 0
        ]
        alternating = _alternating(roots, self.closed)
        left = find_prominent_extrema(
            np.array([extreme.distance for extreme in alternating]), tolerance, self.closed
        )
        return [alternating[i] for i in left]

    def _roots(self) -> Array:
        """Return the parameters where S .

        S' vanishes: all roots of its pieces, which are of the fifth degree.
        """
        inside = np.flatnonzero(
            (self._pieces[0].x[:-1] < self.length) & (self._pieces[0].x[1:] > 0)
        )
        product, width = self._products()
        bernstein = (product * width[:, None] ** np.arange(6)) @ _TO_BERNSTEIN.T
        may = (bernstein.min(axis=1) <= 0) & (bernstein.max(axis=1) >= 0)
        roots = [
            u
            for i in inside[may[inside]]
            for u in self._roots_of(i, np.polynomial.Polynomial(product[i]))
        ]
        return np.unique(np.array(roots))

    def _products(self) -> tuple[Array, Array]:
        """Coefficients (pieces, 6) of S .

        S' in powers of the distance from where a piece begins, and its width.
        """
        total = np.zeros((self._pieces[0].c.shape[1], 6))
        for piece in self._pieces:
            c = piece.c[::-1].T
            for i in range(4):
                for j in range(1, 4):
                    total[:, i + j - 1] += j * c[:, i] * c[:, j]
        return total, np.diff(self._pieces[0].x)

    def _roots_of(self, index: int, product: np.polynomial.Polynomial) -> list[float]:
        begin, end = self._pieces[0].x[index : index + 2]
        slack = 1e-9 * (end - begin)
        real = [
            x.real
            for x in product.roots()
            if abs(x.imag) <= slack and -slack <= x.real <= end - begin + slack
        ]
        slope = product.deriv()
        polished = [x - product(x) / slope(x) for x in real if slope(x) != 0]
        return [min(max(begin + x, 0.0), self.length) for x in polished]

    def _taylor(self, u: float, inside: float) -> Array:
        """Coefficients (4, 2) of the piece that holds `inside`, in powers of the distance from
        `u`.
        """
        pieces = self._pieces
        i = int(
            np.clip(
                np.searchsorted(pieces[0].x, inside, side="right") - 1, 0, pieces[0].c.shape[1] - 1
            )
        )
        shift = u - pieces[0].x[i]
        local = [
            np.polynomial.Polynomial(p.c[::-1, i])(np.polynomial.Polynomial([shift, 1.0]))
            for p in pieces
        ]
        return np.array([np.pad(poly.coef, (0, 4 - len(poly.coef))) for poly in local]).T

    def _bend(self, u: float) -> float:
        """Second derivative of half the squared distance."""
        return float(np.sum(self(u, 1) ** 2) + self(u) @ self(u, 2))

    def square_less(self, u: Array, extreme: DistanceExtreme) -> Array:
        """|S(u)|^2 less its value at an extreme, (m,); near the extreme by its series, which loses
        no digits.

        An extreme beyond the curve's end is that of a dwell, which the curve meets at an angle.
        """
        offsets = self._offsets(u, extreme)
        gap = self(u) - extreme.place
        plain = np.sum(gap * (self(u) + extreme.place), axis=1)
        on_curve = extreme.u <= self.length
        for i in np.flatnonzero(on_curve & (np.abs(offsets) < NEAR * self.length)):
            x = float(offsets[i])
            _, slope, bend, third = self._taylor(extreme.u, extreme.u + x / 2)
            step = x * (slope + x * (bend + x * third))
            plain[i] = 2 * extreme.place @ (x * x * (bend + x * third)) + step @ step
        return plain

    def _offsets(self, u: Array, extreme: DistanceExtreme) -> Array:
        offsets = np.asarray(u, dtype=float) - extreme.u
        return (
            (offsets + self.length / 2) % self.length - self.length / 2 if self.closed else offsets
        )


def _alternating(extremes: list[DistanceExtreme], closed: bool) -> list[DistanceExtreme]:
    """Return the extremes without the lesser of two neighbours of one kind, which roots at
    breakpoints may leave.
    """
    retained: list[DistanceExtreme] = []
    for extreme in extremes:
        if retained and retained[-1].highest == extreme.highest:
            extreme = _further(retained.pop(), extreme)
        retained.append(extreme)
    if closed and len(retained) > 1 and retained[0].highest == retained[-1].highest:
        last = retained.pop()
        retained[0] = _further(retained[0], last)
    return retained


def _further(a: DistanceExtreme, b: DistanceExtreme) -> DistanceExtreme:
    return a if (a.distance > b.distance) == a.highest else b


def find_prominent_extrema(values: Array, tolerance: float, closed: bool) -> Integers:
    """Places of the maxima and minima, which take turns in `values` (m,), that no ripple makes.

    As long as two neighbours differ by less than the tolerance, the least such pair goes, and the
    next ones become neighbours; in a `closed` course the last is the first's.
    """
    count = len(values)
    ring = count if closed else count + 1
    after, before = [(i + 1) % ring for i in range(ring)], [(i - 1) % ring for i in range(ring)]
    stands = np.ones(ring, dtype=bool)
    stands[count:] = False
    ends = [(i, after[i]) for i in range(count) if after[i] < count]
    waiting = [(abs(values[i] - values[j]), i, j) for i, j in ends]
    heapify(waiting)
    while waiting and waiting[0][0] < tolerance and count > 1:
        _, i, j = heappop(waiting)
        if not (stands[i] and stands[j]):
            continue
        stands[[i, j]], count = False, count - 2
        low, high = before[i], after[j]
        after[low], before[high] = high, low
        if stands[low] and stands[high]:
            heappush(waiting, (abs(values[low] - values[high]), low, high))
    return np.flatnonzero(stands)
