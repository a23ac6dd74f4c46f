"""Range and spread of a curve over a turn, weighed and added up: equation (31) of Wang et al. (2017) is one such sum.

The curve is known by values F_i with shares w_i of the turn, sum w_i = 1. Its population variance and the derivatives
of that in a design are, with G_i and H_i those of F_i,

    V = sum w_i (F_i - mean F)^2,   V' = sum s_i G_i,   V'' = sum s_i H_i + 2 sum w_i (G_i - mean G)(G_i - mean G)^T,

where s_i = 2 w_i (F_i - mean F) is the slope of V in F_i.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from planter.kernels import Array


class Variance:
    """Population variance of values (n,) of a curve, and its derivatives in p parameters.

    `shares` (n,) of the turn sum to 1; None: all values have the same.
    """

    def __init__(self, values: Array, shares: Array | None = None) -> None:
        self.shares = np.full(len(values), 1 / len(values)) if shares is None else shares
        self.mean = float(values.mean() if shares is None else shares @ values)
        self.apart = values - self.mean

    @cached_property
    def value(self) -> float:
        return float(self.shares @ self.apart**2)

    @cached_property
    def slope(self) -> Array:
        """Derivative in each value, (n,)."""
        slope: Array = 2 * self.shares * self.apart
        return slope

    def gradient(self, slopes: Array) -> Array:
        """Derivative (p,) from the values' own (n, p)."""
        return self.slope @ slopes

    def squared(self, slopes: Array) -> Array:
        """What the values' first derivatives (n, p) add to the Hessian, (p, p); the rest is sum slope_i H_i."""
        apart = slopes - self.shares @ slopes
        return 2 * (self.shares[:, None] * apart).T @ apart


@dataclass(frozen=True)
class Weights:
    """weight_range * range + weight_variance * spread.

    The spread is the population variance [N2] for kind "paper", equation (31) as printed, which adds N to N2; and the
    standard deviation [N] for kind "newton".
    """

    weight_range: float
    weight_variance: float
    kind: Literal["paper", "newton"]

    def weighted(self, variance: Any, sqrt: Callable[[Any], Any] = math.sqrt) -> Any:
        """The weighted spread of a variance: a number or, with its own square root, whatever else there is."""
        return self.weight_variance * (variance if self.kind == "paper" else sqrt(variance))

    def spread(self, variance: float) -> tuple[float, float, float]:
        """The weighted spread as a function of the variance: value, first and second derivative."""
        if self.kind == "paper":
            return self.weighted(variance), self.weight_variance, 0.0
        felt = max(variance, math.ulp(0.0))
        value = self.weighted(felt)
        first = value / (2 * felt)
        return value, first, -first / (2 * variance) if variance > 0 else 0.0

    def value(self, range_N: float, variance: float) -> float:
        return self.weight_range * range_N + self.spread(variance)[0]


class WeightedSum:
    """The weighted sum for samples (n,) of a turn, extremes being the largest and the least of them.

    Derivatives take the extremes to stay at their samples.
    """

    def __init__(self, weights: Weights, samples: Array) -> None:
        self.weights, self.samples, self.variance = weights, samples, Variance(samples)

    @property
    def range(self) -> float:
        return float(np.ptp(self.samples))

    @property
    def value(self) -> float:
        return self.weights.value(self.range, self.variance.value)

    @cached_property
    def slope(self) -> Array:
        """Derivative in each sample, (n,)."""
        slope = self.weights.spread(self.variance.value)[1] * self.variance.slope
        slope[self.samples.argmax()] += self.weights.weight_range
        slope[self.samples.argmin()] -= self.weights.weight_range
        return slope

    def gradient(self, slopes: Array) -> Array:
        """Derivative (p,) from the samples' own (n, p)."""
        return self.slope @ slopes

    def hessian(self, slopes: Array, bent: Callable[[Array], Array]) -> Array:
        """Second derivative (p, p); `bent` gives sum weights_i H_i (p, p) of the samples' for weights (n,)."""
        _, first, second = self.weights.spread(self.variance.value)
        along = self.variance.gradient(slopes)
        return bent(self.slope) + first * self.variance.squared(slopes) + second * np.outer(along, along)
