"""A smooth function as an objective."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.conditions import Conditions, Look, Slopes, Values
from planter.optimise.samples import Hold

NO_ROWS: Array = np.empty(0)


class Function(Protocol):
    """A function of designs x (p,), smooth wherever a search may go."""

    def value(self, x: Array) -> float: ...

    def gradient(self, x: Array) -> Array:
        """(p,)."""

    def hessian(self, x: Array) -> Array:
        """(p, p)."""


class Smooth:
    """The `Objective` that is one smooth function of `size` parameters; it is its own local model."""

    weight, kinks, windows = 0.0, None, False

    def __init__(self, function: Function, size: int, unit: float | None = None) -> None:
        self.function, self.unit = function, unit
        self.felt: Flags = np.ones(size, dtype=bool)
        self.bounds = np.empty((2, 0))
        self._nothing = np.empty((0, size))

    def outer(self, smooth: float) -> tuple[float, float, float]:
        return smooth, 1.0, 0.0

    def look(self, x: Array) -> Look:
        return Look(self.function.value(x))

    def local(self, x: Array, holds: Sequence[Hold] = ()) -> Smooth:
        return self

    def grown(self, x: Array, high: float, low: float) -> Smooth:
        return self

    def values(self, x: Array) -> Values:
        return Values(self.function.value(x), NO_ROWS, NO_ROWS, NO_ROWS)

    def slopes(self, x: Array) -> Slopes:
        return Slopes(self.function.gradient(x), self._nothing, self._nothing, self._nothing)

    def curvature(self, x: Array, weights: Values) -> Array:
        total: Array = weights.smooth * self.function.hessian(x)
        return total

    def conditions(self, x: Array) -> Conditions:
        nothing = self._nothing
        return Conditions(NO_ROWS, nothing, NO_ROWS, nothing, self.function.gradient(x), nothing)

    def flat(self, x: Array) -> Array:
        return self._nothing
