"""Weighted sum of the range and the variance of a curve over a cycle, as in equation (31) of Wang
et al. (2017).

The curve is given by values F_i with shares w_i of the cycle, sum w_i = 1. With the gradients G_i
and the Hessians H_i of F_i in the design, its population variance V has the derivatives

    V = sum w_i (F_i - mean F)^2,   V' = sum s_i G_i,   V'' = sum s_i H_i + 2 sum w_i (G_i - mean
    G)(G_i - mean G)^T,

where s_i = 2 w_i (F_i - mean F) is the derivative of V in F_i.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from planter.kernels import Array
from planter.planting.objective import Weights


class Variance:
    """Population variance of values (n,) of a curve, and its derivatives in p parameters.

    `shares` (n,) of the cycle sum to 1; None stands for equal shares.
    """

    def __init__(self, values: Array, shares: Array | None = None) -> None:
        self.shares = np.full(len(values), 1 / len(values)) if shares is None else shares
        self.mean = float(values.mean() if shares is None else shares @ values)
        self.deviations = values - self.mean

    @cached_property
    def value(self) -> float:
        return float(self.shares @ self.deviations**2)

    @cached_property
    def slope(self) -> Array:
        """Derivative of the variance in each value, (n,)."""
        slope: Array = 2 * self.shares * self.deviations
        return slope

    def gradient(self, slopes: Array) -> Array:
        """Return the gradient (p,) of the variance from the gradients (n, p) of the values."""
        return self.slope @ slopes

    def squared(self, slopes: Array) -> Array:
        """Return the part (p, p) of the Hessian due to gradients (n, p) of the values; the rest is
        sum slope_i H_i.
        """
        deviations = slopes - self.shares @ slopes
        return 2 * (self.shares[:, None] * deviations).T @ deviations


def find_spread(weights: Weights, variance: float) -> tuple[float, float, float]:
    """Return the weighted scatter and its first and second derivative in the variance [N2]."""
    if weights.kind == "paper":
        return weights.weighted(variance), weights.weight_variance, 0.0
    positive = max(variance, math.ulp(0.0))  # keeps the slope of the square root finite at 0
    value = weights.weighted(positive)
    first = value / (2 * positive)
    return value, first, -first / (2 * variance) if variance > 0 else 0.0


class WeightedSum:
    """Weighted sum of range and scatter of samples (n,) of a cycle.

    Derivatives assume that the largest and the smallest sample remain so.
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
        """Derivative of the sum in each sample, (n,)."""
        slope = find_spread(self.weights, self.variance.value)[1] * self.variance.slope
        slope[self.samples.argmax()] += self.weights.weight_range
        slope[self.samples.argmin()] -= self.weights.weight_range
        return slope

    def gradient(self, slopes: Array) -> Array:
        """Return the gradient (p,) of the sum from the gradients (n, p) of the samples."""
        return self.slope @ slopes

    def hessian(self, slopes: Array, weighted_hessian: Callable[[Array], Array]) -> Array:
        """Return the Hessian (p, p) from the gradients (n, p) of the samples.

        `weighted_hessian` maps weights (n,) to the weighted sum (p, p) of the Hessians of the
        samples.
        """
        _, first, second = find_spread(self.weights, self.variance.value)
        gradient = self.variance.gradient(slopes)
        total = weighted_hessian(self.slope) + first * self.variance.squared(slopes)
        return total + second * np.outer(gradient, gradient)
