"""Piecewise smooth functions: extrema, integrals and jumps by Gauss-Legendre nodes, and Chebyshev series."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import chebyshev

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import TURN, Integers
from planter.numerics.extrema import ExtremePoint, index_first_extremum
from planter.numerics.roots import find_bracketed_roots

Rates = Callable[[Array], tuple[Array, Array]]
"""Of k functions at n angles [rad], (k, n) each: values and slopes, or slopes and second derivatives."""
RowFunctions = Callable[[Array], Array]
NODES, MIN_PIECES = 12, 16
"""Gauss-Legendre nodes of a piece, and minimum number of pieces of a cycle."""
ONE_SIDED_OFFSET = 1e-9
"""Distance from a break of one-sided values; breaks closer than ten times this are merged [rad]."""
CHEBYSHEV_NODES = 20
"""Nodes of a panel, none of them at its ends, where a function may have another value on the other side."""
TAIL_TOLERANCE, TAIL_LENGTH = 2e-14, 3
"""A panel is halved while one of its last coefficients exceeds this share of the function's magnitude."""
MAX_HALVINGS = 12
"""Maximum number of halvings of a panel: the remainder is rounding of the function."""
EXTRA_PANELS = 3000
"""Maximum number of panels beyond four for each initial one: rough functions end there, within seconds."""

_legendre = cache(np.polynomial.legendre.leggauss)
_points = chebyshev.chebpts1(CHEBYSHEV_NODES)
_to_series = np.linalg.inv(chebyshev.chebvander(_points, CHEBYSHEV_NODES - 1))


class RoughFunctionError(ComputationError):
    """Function which too many panels do not represent to rounding."""

    def __init__(self, panels: int) -> None:
        super().__init__(f"a function is not represented to rounding by {panels} Chebyshev series")


def gauss_panels(ends: Array, count: int) -> tuple[Array, Array]:
    """Return nodes and weights (m, count) on the m panels between ends (m + 1,), exact to degree 2 count - 1."""
    points, weights = _legendre(count)
    widths = np.diff(ends)[:, None]
    return ends[:-1, None] + widths * (points + 1) / 2, widths * weights / 2


class PiecewiseFunctions:
    """Periodic functions with kinks or jumps at the ordered angles `breaks` (m,) of a cycle.

    Every piece between two breaks has Gauss-Legendre nodes; values at a break are one-sided. `places` (n,) are the
    nodes, then the sides of breaks. An extremum between two neighbouring nodes can be missed; everything else is exact
    to rounding. Where a slope is not finite, no extremum is looked for between its nodes.
    """

    def __init__(self, functions: Rates, breaks: Array, turn: float = TURN) -> None:
        self.functions = functions
        separate = np.diff(breaks, append=breaks[:1] + turn) > 10 * ONE_SIDED_OFFSET
        self.breaks = np.asarray(breaks, dtype=float)[np.roll(separate, 1)]
        starts = self.breaks if len(self.breaks) else np.zeros(1)
        self._edges = np.append(starts, starts[0] + turn)
        counts = np.ceil(np.diff(self._edges) * MIN_PIECES / turn).astype(int)
        inner = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(starts, self._edges[1:], counts, strict=True)]
        nodes, weights = gauss_panels(np.append(np.concatenate(inner), self._edges[-1]), NODES)
        self.nodes, self.weights = nodes.ravel(), weights.ravel() / turn
        owner = np.repeat(np.arange(len(counts)), counts * NODES)
        sides = np.concatenate([starts, self._edges[1:]])
        offsets = np.repeat([ONE_SIDED_OFFSET, -ONE_SIDED_OFFSET], len(starts))
        self.values, self.slopes = functions(np.concatenate([self.nodes, sides + offsets]))
        ends = self.slopes[:, len(self.nodes) :]
        self.values[:, len(self.nodes) :] -= offsets * np.where(np.isfinite(ends), ends, 0.0)
        self.places, panel = np.append(self.nodes, sides), np.append(owner, np.tile(np.arange(len(counts)), 2))
        self._order = np.lexsort([self.places, panel])
        self._places, self._joined = self.places[self._order], np.diff(panel[self._order]) == 0

    @cached_property
    def mean(self) -> Array:
        """Mean of each function over the cycle, (k,)."""
        return np.asarray(self.values[:, : len(self.nodes)] @ self.weights)

    @cached_property
    def rms(self) -> Array:
        """Root mean square of each function over the cycle, (k,)."""
        return np.asarray(np.sqrt(self.values[:, : len(self.nodes)] ** 2 @ self.weights))

    def extremes(self, rows: Integers, rates: Rates) -> list[tuple[ExtremePoint, ExtremePoint]]:
        """Return minimum and maximum over the cycle of the functions `rows`; one-sided at jumps.

        `rates` returns slopes and second derivatives of these rows. Raises ComputationError as `find_bracketed_roots`.
        """
        owners, places, values = self._stationary(rows, rates)
        samples = self.values[:, self._order]
        extremes = []
        for k, row in enumerate(rows):
            angles = np.append(self._places, places[owners == k])
            combined = np.append(samples[row], values[owners == k])
            extremes.append((_select_extremum(angles, combined, -1), _select_extremum(angles, combined, 1)))
        return extremes

    def _stationary(self, rows: Integers, rates: Rates) -> tuple[Integers, Array, Array]:
        """Return owners, angles and values of the stationary points."""
        slopes = self.slopes[rows][:, self._order]
        finite = np.isfinite(slopes)
        joined = self._joined & finite[:, 1:] & finite[:, :-1]
        owners, cells = np.nonzero(((slopes[:, 1:] > 0) != (slopes[:, :-1] > 0)) & joined)
        if not len(owners):
            return owners, np.empty(0), np.empty(0)
        ends = slopes[owners, cells], slopes[owners, cells + 1]
        places = find_bracketed_roots(_OwnedRates(rates, owners), self._places[cells], self._places[cells + 1], ends)
        return owners, places, self.functions(places)[0][rows[owners], np.arange(len(owners))]

    @cached_property
    def sides(self) -> tuple[Array, Array]:
        """Limits (k, m) of the values at each break from below and from above."""
        if not len(self.breaks):
            return np.empty((len(self.values), 0)), np.empty((len(self.values), 0))
        after, before = np.split(self.values[:, len(self.nodes) :], 2, axis=1)
        return np.roll(before, 1, axis=1), after


class _OwnedRates:
    """Rates at points (m,), of the owner of each point alone; results of points that did not move are reused."""

    def __init__(self, rates: Rates, owners: Integers) -> None:
        self._rates, self._owners = rates, owners
        self._points = np.full(len(owners), np.nan)
        self._results = np.empty((2, len(owners)))

    def __call__(self, points: Array) -> tuple[Array, Array]:
        moved = np.flatnonzero(points != self._points)
        if len(moved):
            each = self._owners[moved], np.arange(len(moved))
            self._results[:, moved] = [rate[each] for rate in self._rates(points[moved])]
        self._points = points.copy()
        first, second = self._results
        return first, second


def _select_extremum(angles: Array, values: Array, sign: int) -> ExtremePoint:
    """Return the largest (+1) or smallest (-1) of values (n,) at angles (n,); of ties the first angle."""
    return ExtremePoint(float(angles[index_first_extremum(angles, values, sign)]), sign * float((sign * values).max()))


@dataclass(frozen=True)
class ChebyshevPanels:
    """Functions by their Chebyshev series (m, f, k) on the m panels between ends (m + 1,)."""

    ends: Array
    series: Array

    @classmethod
    def fit(cls, functions: RowFunctions, breaks: Array) -> ChebyshevPanels:
        """Return the series of functions with values (f, n) at arguments (n,), smooth between breaks (m + 1,).

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
            series = np.einsum("kj,fmj->mfk", _to_series, values)
            rough = (np.abs(series[:, :, -TAIL_LENGTH:]).max(axis=2) > TAIL_TOLERANCE * size).any(axis=1) & (
                depth < MAX_HALVINGS
            )
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
        """Return values (f, n) at arguments (n,), by the series of the panels with these indices if `panel` is set."""
        index = self.panel(places) if panel is None else panel
        low, high = self.ends[index], self.ends[index + 1]
        terms = chebyshev.chebvander((2 * places - low - high) / (high - low), self.series.shape[2] - 1)
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
