"""Several functions over a turn that are smooth between breaks: true extremes, integrals, and jumps at the breaks.

Each piece between two breaks has Gauss-Legendre nodes; beside a break values are one-sided. A hill between two
neighbouring nodes is missed, as in `extremes`; everything else is right to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from planter.kernels import Array
from planter.numerics import quadrature, roots
from planter.numerics.arrays import Integers
from planter.numerics.extremes import Extreme, first_extreme

Rates = Callable[[Array], tuple[Array, Array]]
"""Of k functions at n angles [rad], (k, n) each: values and slopes, or slopes and second derivatives."""
TURN = 2 * np.pi
NODES, PIECES = 12, 16
"""Nodes in a piece, and the least number of pieces of a turn."""
ASIDE = 1e-9
"""How far beside a break one-sided values are taken; breaks closer than ten times this are one [rad]."""


class Pieces:
    """Functions that repeat after a turn, and the angles `breaks` (m,) of a turn, in order, where they have kinks."""

    def __init__(self, functions: Rates, breaks: Array, turn: float = TURN) -> None:
        self.functions = functions
        apart = np.diff(breaks, append=breaks[:1] + turn) > 10 * ASIDE
        self.breaks = np.asarray(breaks, dtype=float)[np.roll(apart, 1)]
        starts = self.breaks if len(self.breaks) else np.zeros(1)
        self._edges = np.append(starts, starts[0] + turn)
        counts = np.ceil(np.diff(self._edges) * PIECES / turn).astype(int)
        inner = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(starts, self._edges[1:], counts, strict=True)]
        nodes, weights = quadrature.panels(np.append(np.concatenate(inner), self._edges[-1]), NODES)
        self.nodes, self.weights = nodes.ravel(), weights.ravel() / turn
        own = np.repeat(np.arange(len(counts)), counts * NODES)
        sides = np.concatenate([starts, self._edges[1:]])
        aside = np.repeat([ASIDE, -ASIDE], len(starts))
        self.values, self.slopes = functions(np.concatenate([self.nodes, sides + aside]))
        self.values[:, len(self.nodes) :] -= aside * self.slopes[:, len(self.nodes) :]
        places, panel = np.append(self.nodes, sides), np.append(own, np.tile(np.arange(len(counts)), 2))
        self._order = np.lexsort([places, panel])
        self._places, self._joined = places[self._order], np.diff(panel[self._order]) == 0

    @cached_property
    def mean(self) -> Array:
        """Of each function over the turn, (k,)."""
        found: Array = self.values[:, : len(self.nodes)] @ self.weights
        return found

    @cached_property
    def rms(self) -> Array:
        """Root of the mean square of each function over the turn, (k,)."""
        found: Array = np.sqrt(self.values[:, : len(self.nodes)] ** 2 @ self.weights)
        return found

    def extremes(self, rows: Integers, rates: Rates) -> list[tuple[Extreme, Extreme]]:
        """Least and largest value over the turn of some of the functions; one-sided where they jump.

        `rates` gives slopes and second derivatives of these rows alone. Raises ComputationError as `roots.newton` does.
        """
        owners, places, values = self._stationary(rows, rates)
        known = self.values[:, self._order]
        return [
            (_best(places[owners == k], values[owners == k], self._places, known[row], -1),
             _best(places[owners == k], values[owners == k], self._places, known[row], 1))
            for k, row in enumerate(rows)
        ]  # fmt: skip

    def _stationary(self, rows: Integers, rates: Rates) -> tuple[Integers, Array, Array]:
        """Where slopes change sign between neighbours of a piece: whose, where, and the values there."""
        slopes = self.slopes[rows][:, self._order]
        owners, cells = np.nonzero(((slopes[:, 1:] > 0) != (slopes[:, :-1] > 0)) & self._joined)
        if not len(owners):
            return owners, np.empty(0), np.empty(0)
        ends = slopes[owners, cells], slopes[owners, cells + 1]
        places = roots.newton(_Owned(rates, owners), self._places[cells], self._places[cells + 1], ends)
        return owners, places, self.functions(places)[0][rows[owners], np.arange(len(owners))]

    @cached_property
    def sides(self) -> tuple[Array, Array]:
        """Values (k, m) at each break as they come from before it and from after it."""
        if not len(self.breaks):
            return np.empty((len(self.values), 0)), np.empty((len(self.values), 0))
        after, before = np.split(self.values[:, len(self.nodes) :], 2, axis=1)
        return np.roll(before, 1, axis=1), after


class _Owned:
    """Rates at points (m,), at each of its owner alone; what a point that stays has is kept."""

    def __init__(self, rates: Rates, owners: Integers) -> None:
        self._rates, self._owners = rates, owners
        self._at = np.full(len(owners), np.nan)
        self._found = np.empty((2, len(owners)))

    def __call__(self, at: Array) -> tuple[Array, Array]:
        moved = np.flatnonzero(at != self._at)
        if len(moved):
            each = self._owners[moved], np.arange(len(moved))
            self._found[:, moved] = [rate[each] for rate in self._rates(at[moved])]
        self._at = at.copy()
        first, second = self._found
        return first, second


def _best(inside: Array, found: Array, places: Array, values: Array, sign: int) -> Extreme:
    """The largest (+1) or least (-1) of values at stationary places and at known ones; of ties the first place."""
    at, every = np.append(places, inside), np.append(values, found)
    return Extreme(float(at[first_extreme(at, every, sign)]), sign * float((sign * every).max()))
