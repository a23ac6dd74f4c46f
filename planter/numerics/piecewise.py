"""Piecewise smooth functions: extrema, integrals and jumps by Gauss-Legendre nodes, and Chebyshev
series.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers
from planter.numerics.arrays import TURN
from planter.numerics.extrema import ExtremePoint, index_first_extremum
from planter.numerics.roots import OwnFunctions, find_bracketed_roots

Rates = Callable[[Array], tuple[Array, Array]]
"""Of k functions at n angles [rad], (k, n) each: values and slopes, or slopes and second
derivatives.
"""
RowFunctions = Callable[[Array], Array]
NODES, MIN_PIECES = 12, 16
"""Gauss-Legendre nodes of a panel, and minimum number of panels of a cycle."""
MERGED_DISTANCE = 1e-11
"""Breaks closer than this are one: roots of two functions at one place differ by their rounding
[rad].
"""
ONE_SIDED_OFFSET, CONSISTENT = 1e-9, 1e-8
"""Distance from a break at which a limit is taken, linearly [rad], unless a series has it otherwise
by this share.
"""
SERIES_TOLERANCE = 1e-11
"""A panel is halved while its share of the cycle times a last coefficient exceeds this share of the
mean size.
"""
LIMIT_TOLERANCE = 1e-6
"""Largest last coefficient, as a share of the largest value, of a series that has a limit at its
end.
"""
MAX_DEPTH, MAX_PANELS = 40, 4000
"""Halvings of a panel, and panels of a cycle, after which the remainder is rounding."""
NOISE_DEPTH, NOISE_SHARE, FLATNESS = 16, 0.25, 0.02
"""A function is rounding if so many panels do not suffice, and on this share of a cycle the last
coefficients are as large as this share of its values: its extremes are those of the nodes.
"""
CHEBYSHEV_NODES = 20
"""Nodes of a panel, none of them at its ends, where a function may have another value on the other
side.
"""
TAIL_TOLERANCE, TAIL_LENGTH = 2e-14, 3
"""A panel is halved while one of its last coefficients exceeds this share of the function's
magnitude.
"""
MAX_HALVINGS = 12
"""Maximum number of halvings of a panel: the remainder is rounding of the function."""
EXTRA_PANELS = 3000
"""Maximum number of panels beyond four for each initial one: rough functions end there, within
seconds.
"""

_legendre = cache(np.polynomial.legendre.leggauss)
_points = chebyshev.chebpts1(CHEBYSHEV_NODES)
_from_points = np.linalg.inv(chebyshev.chebvander(_points, CHEBYSHEV_NODES - 1))


class RoughFunctionError(ComputationError):
    """Function which too many panels do not represent to rounding."""

    def __init__(self, panels: int) -> None:
        super().__init__(f"a function is not represented to rounding by {panels} Chebyshev series")


def gauss_panels(ends: Array, count: int) -> tuple[Array, Array]:
    """Return nodes and weights (m, count) on the m panels between ends (m + 1,), exact to degree 2
    count - 1.
    """
    points, weights = _legendre(count)
    widths = np.diff(ends)[:, None]
    return ends[:-1, None] + widths * (points + 1) / 2, widths * weights / 2


class PiecewiseFunctions:
    """Functions over a cycle from 0 to `turn` with kinks, roots or jumps at the ordered angles
    `breaks` (m,).

    A piece between two breaks is mapped on 0 <= v <= 1 with zero slope at both ends, so that a
    square root which begins there is smooth in v. It has panels of Gauss-Legendre nodes, halved
    where the Legendre series of a function does not fall off: integrals are right to 1e-10 of a
    function's mean size also where a kink has no break. An extremum between two neighbouring nodes
    can be missed. Slopes need not be finite where a function is.

    `poles` are angles at which functions, by their index, are not finite, or have a pole: these
    have no integrals.
    """

    def __init__(
        self,
        functions: Rates,
        breaks: Array,
        turn: float = TURN,
        start: float = 0.0,
        panels: int = MIN_PIECES,
    ) -> None:
        """Divide the cycle from `start` on into at least so many `panels`."""
        self.functions = functions
        folded = np.sort(np.asarray(breaks, dtype=float))
        self.breaks = folded[np.diff(folded, prepend=-np.inf) > MERGED_DISTANCE]
        low, high = start + MERGED_DISTANCE, start + turn - MERGED_DISTANCE
        inner = self.breaks[(self.breaks > low) & (self.breaks < high)]
        self._edges = np.concatenate([[start], inner, [start + turn]])
        pending = _begin_panels(self._edges, panels, turn)
        accepted: list[_Panels] = []
        self.poles: dict[int, float] = {}
        size = np.zeros(1)
        self._is_noise = np.zeros(1, dtype=bool)
        for depth in range(MAX_DEPTH + 1):
            trial = self._evaluate(pending)
            share = trial.weights / turn
            size = np.maximum(size, (np.abs(trial.values) * share).sum(axis=(1, 2)))
            coefficients = np.abs(trial.values @ to_series()[:, -TAIL_LENGTH:]).max(axis=2)
            tails = coefficients * share.sum(axis=1)
            is_rough = ~(tails <= SERIES_TOLERANCE * size[:, None])
            self._name_poles(trial, is_rough if depth == MAX_DEPTH else np.isnan(tails))
            is_rough[list(self.poles)] = False
            rough = is_rough.any(axis=0)
            accepted.append(trial.select(~rough))
            if not rough.any():
                break
            # Rounding everywhere doubles its panels at each of the first halvings, a pole at the
            # last ones.
            is_endless = depth < NOISE_DEPTH and 2 * rough.sum() > MAX_PANELS
            if is_endless or sum(len(part.owner) for part in accepted) > MAX_PANELS:
                is_flat = is_rough & (coefficients > FLATNESS * np.abs(trial.values).max(axis=2))
                self._is_noise = (is_flat * share.sum(axis=1)).sum(axis=1) > NOISE_SHARE
                accepted.append(trial.select(rough))
                break
            pending = trial.select(rough).halve()
        self._collect(accepted, turn)

    def _name_poles(self, panels: _Panels, is_rough: Flags) -> None:
        """Set the angle of a node at which each function has a pole, or is not finite, if it is not
        yet set.
        """
        for row, panel in zip(*np.nonzero(is_rough), strict=True):
            node = int(np.argmin(np.isfinite(panels.values[row, panel])))
            self.poles.setdefault(int(row), float(panels.angles[panel, node]))

    def _evaluate(self, pending: tuple[Integers, Array, Array]) -> _Panels:
        owner, low, high = pending
        angles, weights = _place_nodes(self._edges, owner, low, high)
        rows = [part.reshape(-1, *angles.shape) for part in self.functions(angles.ravel())]
        ends = owner[:, None], low[:, None], high[:, None]
        return _Panels(*ends, angles, weights, *rows)

    def _collect(self, accepted: Sequence[_Panels], turn: float) -> None:
        """Set nodes (n,), weights of sum 1, values and slopes (k, n) in their order, and limits at
        ends of pieces.
        """
        panels = _Panels(*(np.concatenate(parts, axis=-2) for parts in zip(*accepted, strict=True)))
        panels = panels.select(np.lexsort([panels.low[:, 0], panels.owner[:, 0]]))
        owner, values, slopes = panels.owner[:, 0], panels.values, panels.slopes
        begin, end = self._edges[:-1], self._edges[1:]
        offsets = np.minimum(ONE_SIDED_OFFSET, ONE_SIDED_OFFSET**0.5 * (end - begin))
        side_angles = np.concatenate([begin + offsets, end - offsets])
        side_values, side_slopes = self.functions(side_angles)
        pieces = np.arange(len(begin))
        first, last = np.searchsorted(owner, pieces), np.searchsorted(owner, pieces, "right") - 1
        ends = _extrapolate(values[:, first], -1), _extrapolate(values[:, last], 1)
        series = np.append(*ends, axis=1)
        linear = side_values + side_slopes * np.append(-offsets, offsets)
        limits = np.where(np.abs(series - linear) <= CONSISTENT * np.abs(series), linear, series)
        rounding = np.finfo(float).eps * np.abs(series).max(axis=1, keepdims=True)
        self._after, self._before = np.split(
            np.where(np.abs(limits) > rounding, limits, 0.0), 2, axis=1
        )
        side_values = np.where(np.isfinite(side_values), side_values, limits)
        nearest = np.append(slopes[:, first, 0], slopes[:, last, -1], axis=1)
        side_slopes = np.where(np.isfinite(side_slopes), side_slopes, nearest)
        angles = np.append(panels.angles.ravel(), side_angles)
        owners = np.concatenate([np.repeat(owner, NODES), pieces, pieces])
        weights = np.append(panels.weights.ravel(), np.zeros(len(side_angles))) / turn
        places = np.lexsort([angles, owners])
        self.nodes, self.owner, self.weights = angles[places], owners[places], weights[places]
        self.values = np.append(values.reshape(len(values), -1), side_values, axis=1)[:, places]
        self.slopes = np.append(slopes.reshape(len(values), -1), side_slopes, axis=1)[:, places]
        self.slopes[~np.isfinite(self.slopes)] = 0.0

    @cached_property
    def mean(self) -> Array:
        """Mean of each function over the cycle, (k,)."""
        return np.asarray(self.values @ self.weights)

    @cached_property
    def rms(self) -> Array:
        """Root mean square of each function over the cycle, (k,)."""
        return np.asarray(np.sqrt(self.values**2 @ self.weights))

    @cached_property
    def variance(self) -> Array:
        """Mean square deviation of each function from its mean, (k,)."""
        return np.asarray((self.values - self.mean[:, None]) ** 2 @ self.weights)

    def extremes(self, rows: Integers, rates: Rates) -> list[tuple[ExtremePoint, ExtremePoint]]:
        """Return minimum and maximum over the cycle of the functions `rows`; one-sided at jumps.

        `rates` returns slopes and second derivatives of these rows. Raises ComputationError as
        `find_bracketed_roots`.
        """
        owners, places, values = self._stationary(rows, rates)
        inner = self.weights > 0  # without the points beside an end, whose limit is there
        angles = np.concatenate([self._edges[:-1], self._edges[1:], self.nodes[inner]])
        samples = np.concatenate([self._after, self._before, self.values[:, inner]], axis=1)
        extremes = []
        for k, row in enumerate(rows):
            all_angles = np.append(angles, places[owners == k])
            combined = np.append(samples[row], values[owners == k])
            extremes.append(
                (
                    _select_extremum(all_angles, combined, -1),
                    _select_extremum(all_angles, combined, 1),
                )
            )
        return extremes

    def _stationary(self, rows: Integers, rates: Rates) -> tuple[Integers, Array, Array]:
        """Return owners, angles and values of the stationary points."""
        slopes, joined = self.slopes[rows], self.is_joined
        turns = ((slopes[:, 1:] > 0) != (slopes[:, :-1] > 0)) & joined
        # Between two nodes a function that is constant, or zero, but for rounding has no extremum
        # worth the search.
        steepest = np.maximum(np.abs(slopes[:, 1:]), np.abs(slopes[:, :-1]))
        rounding = 4 * np.finfo(float).eps * np.abs(self.values[rows]).max(axis=1, keepdims=True)
        turns &= (steepest * np.diff(self.nodes) > rounding) & ~np.broadcast_to(
            self._is_noise, len(self.values)
        )[rows, None]
        owners, cells = np.nonzero(turns)
        if not len(owners):
            return owners, np.empty(0), np.empty(0)
        ends = slopes[owners, cells], slopes[owners, cells + 1]
        places = find_bracketed_roots(
            OwnFunctions(rates, owners), self.nodes[cells], self.nodes[cells + 1], ends
        )
        return owners, places, self.functions(places)[0][rows[owners], np.arange(len(owners))]

    @cached_property
    def is_joined(self) -> Flags:
        """Flags (n - 1,) of neighbouring nodes that belong to one piece."""
        return np.asarray(np.diff(self.owner) == 0)

    @property
    def ends(self) -> tuple[Array, Array]:
        """Values (k,) at the beginning and at the end of the cycle."""
        return self._after[:, 0], self._before[:, -1]

    @cached_property
    def sides(self) -> tuple[Array, Array]:
        """Limits (k, m) of the values at each break from below and from above."""
        after = np.searchsorted(self._edges[:-1], self.breaks - MERGED_DISTANCE)
        after = np.where(after == len(self._edges) - 1, 0, after)
        return self._before[:, after - 1], self._after[:, after]


def place_panels(edges: Array, pieces: int, turn: float, fewest: int = 1) -> tuple[Array, Array]:
    """Return angles and weights (p, n) of the nodes of panels between ends (m,) of pieces.

    A turn has `pieces` of them at least, and a piece `fewest`. The sum of the weights is the length
    of all pieces.
    """
    owner, low, high = _begin_panels(edges, pieces, turn, fewest)
    return _place_nodes(edges, owner, low, high)


def _begin_panels(
    edges: Array, pieces: int, turn: float, fewest: int = 1
) -> tuple[Integers, Array, Array]:
    """Return the pieces that panels (p,) belong to, and their ends in v."""
    counts = np.maximum(np.ceil(np.diff(edges) * pieces / turn).astype(int), fewest)
    owner = np.repeat(np.arange(len(counts)), counts)
    first = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first / counts[owner], (first + 1) / counts[owner]


def _place_nodes(edges: Array, owner: Integers, low: Array, high: Array) -> tuple[Array, Array]:
    """Return angles and weights (p, n) of the nodes of panels between places low and high (p,) in
    v.
    """
    points, weights = _legendre(NODES)
    v = (low[:, None] * (1 - points) + high[:, None] * (1 + points)) / 2
    begin, end = edges[owner][:, None], edges[owner + 1][:, None]
    distance = np.minimum(v, 1 - v)  # angles at an end are right to the digits of their distance
    offset = (end - begin) * distance**2 * (3 - 2 * distance)
    angles = np.where(v < 0.5, begin + offset, end - offset)
    return angles, 6 * (end - begin) * v * (1 - v) * weights * (high - low)[:, None] / 2


class _Panels(NamedTuple):
    """Panels (m, ...) of pieces: owners and ends in v (m, 1), angles and weights (m, n) of their
    nodes, values and slopes (k, m, n).
    """

    owner: Integers
    low: Array
    high: Array
    angles: Array
    weights: Array
    values: Array
    slopes: Array

    def select(self, index: Flags | Integers) -> _Panels:
        """Return some of the panels."""
        parts: list[Any] = [part[..., index, :] for part in self]
        return _Panels(*parts)

    def halve(self) -> tuple[Integers, Array, Array]:
        """Return owners and ends of both halves of all panels."""
        low, high = self.low[:, 0], self.high[:, 0]
        middle = (low + high) / 2
        return np.tile(self.owner[:, 0], 2), np.append(low, middle), np.append(middle, high)


@cache
def to_series() -> Array:
    """Return the matrix (n, n) from values at the nodes of a panel to their Legendre series."""
    points, weights = _legendre(NODES)
    orders = np.arange(NODES)
    return (
        np.polynomial.legendre.legvander(points, NODES - 1)
        * weights[:, None]
        * (2 * orders + 1)
        / 2
    )


def _extrapolate(values: Array, end: int) -> Array:
    """Return the limits (k, m) of series of values (k, m, n) at an end of their panels, +1 or -1.

    Where a series does not fall off, as beside a pole, the limit is the value at the last node.
    """
    series = values @ to_series()
    limit = series @ (float(end) ** np.arange(NODES))
    last = values[..., 0 if end < 0 else -1]
    spread = np.abs(values).max(axis=-1)
    return np.where(
        np.abs(series[..., -TAIL_LENGTH:]).max(axis=-1) > LIMIT_TOLERANCE * spread, last, limit
    )


def _select_extremum(angles: Array, values: Array, sign: int) -> ExtremePoint:
    """Return the largest (+1) or smallest (-1) of values (n,) at angles (n,); of ties the first
    angle.
    """
    return ExtremePoint(
        float(angles[index_first_extremum(angles, values, sign)]),
        sign * float((sign * values).max()),
    )


@dataclass(frozen=True)
class ChebyshevPanels:
    """Functions by their Chebyshev series (m, f, k) on the m panels between ends (m + 1,)."""

    ends: Array
    series: Array

    @classmethod
    def fit(cls, functions: RowFunctions, breaks: Array) -> ChebyshevPanels:
        """Return the series of functions with values (f, n) at arguments (n,), smooth between
        breaks (m + 1,).

        Raises RoughFunctionError if they are not.
        """
        pending, panels = list(itertools.pairwise(breaks)), []
        limit = 4 * len(pending) + EXTRA_PANELS
        size: Array | float = 0.0
        for depth in range(MAX_HALVINGS + 1):
            low, high = np.array(pending).T
            places = low[:, None] + np.outer(high - low, (_points + 1) / 2)
            values = functions(places.ravel()).reshape(-1, *places.shape)
            size = np.maximum(size, np.abs(values).max(axis=(1, 2)))
            series = np.einsum("kj,fmj->mfk", _from_points, values)
            rough = (np.abs(series[:, :, -TAIL_LENGTH:]).max(axis=2) > TAIL_TOLERANCE * size).any(
                axis=1
            ) & (depth < MAX_HALVINGS)
            panels += [(low[i], high[i], series[i]) for i in np.flatnonzero(~rough)]
            halves = [(low[i], (low[i] + high[i]) / 2, high[i]) for i in np.flatnonzero(rough)]
            pending = [pair for a, b, c in halves for pair in ((a, b), (b, c))]
            if not pending:
                break
            if len(pending) + len(panels) > limit:
                raise RoughFunctionError(limit)
        panels.sort(key=lambda panel: panel[0])
        ends = np.array([*(a for a, _, _ in panels), panels[-1][1]])
        return cls(ends, np.array([rows for _, _, rows in panels]))

    def panel(self, places: Array) -> Integers:
        """Return the index of the panel that contains each argument (n,)."""
        return np.clip(np.searchsorted(self.ends, places, "right") - 1, 0, len(self.series) - 1)

    def __call__(self, places: Array, panel: Integers | None = None) -> Array:
        """Return values (f, n) at arguments (n,), by the series of the panels with these indices if
        `panel` is set.
        """
        index = self.panel(places) if panel is None else panel
        low, high = self.ends[index], self.ends[index + 1]
        terms = chebyshev.chebvander(
            (2 * places - low - high) / (high - low), self.series.shape[2] - 1
        )
        return np.einsum("nfk,nk->fn", self.series[index], terms)

    @cached_property
    def integral(self) -> ChebyshevPanels:
        """Integrals of the functions from the first end."""
        half = np.diff(self.ends)[:, None, None] / 2
        integrals = chebyshev.chebint(self.series, lbnd=-1, axis=2) * half
        integrals[1:, :, 0] += np.cumsum(integrals.sum(axis=2), axis=0)[:-1]
        return ChebyshevPanels(self.ends, integrals)

    @cached_property
    def slope(self) -> ChebyshevPanels:
        """Derivatives of the functions."""
        half = np.diff(self.ends)[:, None, None] / 2
        return ChebyshevPanels(self.ends, chebyshev.chebder(self.series, axis=2) / half)
