"""Functions on panels, each by its Chebyshev series: to rounding where a function is smooth between breaks."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Integers

NODES = 20
"""Nodes of a panel, none of them at its ends, where a function may have another value on the other side."""
TAIL, LAST = 2e-14, 3
"""A panel is halved while one of its last coefficients is a larger share of the function's size."""
DEEPEST = 12
"""A panel is halved this often at most: what then is left is rounding of the function."""
MOST = 3000
"""Largest number of panels beyond four for each that a function begins with: rough functions end there, in seconds."""


class RoughFunctionError(ComputationError):
    """A function that too many panels do not represent to rounding."""

    def __init__(self, panels: int) -> None:
        super().__init__(f"a function is not represented to rounding by {panels} Chebyshev series")


Rows = Callable[[Array], Array]

_points = chebyshev.chebpts1(NODES)
_to_series = np.linalg.inv(chebyshev.chebvander(_points, NODES - 1))


@dataclass(frozen=True)
class Panels:
    """Functions by their series (m, f, k) on the m panels between neighbouring ends (m + 1,)."""

    ends: Array
    series: Array

    @classmethod
    def of(cls, functions: Rows, breaks: Array) -> Panels:
        """Return the series of functions that give (f, n) at places (n,), smooth between breaks (m + 1,).

        Raises RoughFunctionError where they are not.
        """
        left, kept = list(itertools.pairwise(breaks)), []
        most = 4 * len(left) + MOST
        size: Array | float = 0.0
        for depth in range(DEEPEST + 1):
            low, high = np.array(left).T
            places = low[:, None] + np.outer(high - low, (_points + 1) / 2)
            values = functions(places.ravel()).reshape(-1, *places.shape)
            size = np.maximum(size, np.abs(values).max(axis=(1, 2)))
            series = np.einsum("kj,fmj->mfk", _to_series, values)
            rough = (np.abs(series[:, :, -LAST:]).max(axis=2) > TAIL * size).any(axis=1) & (depth < DEEPEST)
            kept += [(low[i], high[i], series[i]) for i in np.flatnonzero(~rough)]
            halves = [(low[i], (low[i] + high[i]) / 2, high[i]) for i in np.flatnonzero(rough)]
            left = [pair for a, b, c in halves for pair in ((a, b), (b, c))]
            if not left:
                break
            if len(left) + len(kept) > most:
                raise RoughFunctionError(most)
        kept.sort(key=lambda panel: panel[0])
        ends = np.array([*(a for a, _, _ in kept), kept[-1][1]])
        return cls(ends, np.array([one for _, _, one in kept]))

    def panel(self, places: Array) -> Integers:
        """The panels that places (n,) lie in."""
        found: Integers = np.clip(np.searchsorted(self.ends, places, "right") - 1, 0, len(self.series) - 1)
        return found

    def __call__(self, places: Array, panel: Integers | None = None) -> Array:
        """Values (f, n) at places (n,), by the series of given panels if these are told."""
        index = self.panel(places) if panel is None else panel
        low, high = self.ends[index], self.ends[index + 1]
        terms = chebyshev.chebvander((2 * places - low - high) / (high - low), self.series.shape[2] - 1)
        return np.einsum("nfk,nk->fn", self.series[index], terms)

    @cached_property
    def integral(self) -> Panels:
        """The integrals from the first end, of each function."""
        half = np.diff(self.ends)[:, None, None] / 2
        own = chebyshev.chebint(self.series, lbnd=-1, axis=2) * half
        own[1:, :, 0] += np.cumsum(own.sum(axis=2), axis=0)[:-1]
        return Panels(self.ends, own)

    @cached_property
    def slope(self) -> Panels:
        """The derivatives."""
        half = np.diff(self.ends)[:, None, None] / 2
        return Panels(self.ends, chebyshev.chebder(self.series, axis=2) / half)
