"""Statistics of a function over an interval, with first and second derivatives.

The function is known by values f_k (n,) with weights w_k (n,), not necessarily of sum 1. Both may
depend on p parameters. With the moments S_j = sum w_k f_k^j, j = 0, 1, 2, every smooth statistic is
a function of S_0, S_1, S_2, or the root of one, so that its derivatives follow from those of three
sums.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from planter.kernels import Array

StatisticKind = Literal["mean", "variance", "std", "rms", "integral"]
SMOOTH: tuple[StatisticKind, ...] = ("mean", "variance", "std", "rms", "integral")
"""Statistics which are smooth in the values."""
ROOTS = ("std", "rms")
REDUCTIONS: dict[str, Callable[[Array], Any]] = {
    "max": lambda samples: samples.max(axis=0),
    "min": lambda samples: samples.min(axis=0),
    "range": lambda samples: np.ptp(samples, axis=0),
    "mean": lambda samples: samples.mean(axis=0),
    "variance": lambda samples: samples.var(axis=0),
    "std": lambda samples: samples.std(axis=0),
    "rms": lambda samples: np.sqrt((samples**2).mean(axis=0)),
}
EXTREMUM_WEIGHTS = {"max": (1.0, 0.0), "min": (0.0, 1.0), "range": (1.0, -1.0)}
"""Weights of the largest and of the smallest sample in a statistic."""


def reduce_samples(kind: str, samples: Array) -> Array:
    """Return a statistic (...) of samples (n, ...) along the first axis, with equal weights."""
    return np.asarray(REDUCTIONS[kind](samples))


def differentiate_statistic(kind: str, samples: Array) -> Array:
    """Return the derivative (n, ...) of a statistic in each of its samples (n, ...), extrema at
    fixed samples.
    """
    count = len(samples)
    if kind in EXTREMUM_WEIGHTS:
        slope = np.zeros_like(samples)
        for sign, place in zip(
            EXTREMUM_WEIGHTS[kind], (samples.argmax(axis=0), samples.argmin(axis=0)), strict=True
        ):
            index = (place, *np.indices(place.shape))
            slope[index] += sign
        return slope
    if kind == "mean":
        return np.full_like(samples, 1 / count)
    deviations = samples if kind == "rms" else samples - samples.mean(axis=0)
    if kind == "variance":
        return 2 / count * deviations
    size = count * reduce_samples(kind, samples)
    return np.divide(deviations, size, out=np.zeros_like(samples), where=size > 0)


@dataclass(frozen=True)
class MomentFunction:
    """Value of a function of S_0, S_1, S_2 with its derivatives: `first` (3,), `second` (3, 3)."""

    value: float
    first: Array
    second: Array

    @classmethod
    def from_moments(
        cls, kind: StatisticKind, total: float, first: float, square: float
    ) -> MomentFunction:
        """Return a statistic (its square, if it is a root) at S_0, S_1, S_2.

        Variances require S_1 = 0, values about their mean, so that no digits cancel.
        """
        gradient, hessian = np.zeros(3), np.zeros((3, 3))
        if kind == "integral":
            return cls(first, np.array([0.0, 1.0, 0.0]), hessian)
        row, moment = (1, first) if kind == "mean" else (2, square)
        gradient[[0, row]] = -moment / total**2, 1 / total
        hessian[0, 0] = 2 * moment / total**3
        hessian[0, row] = hessian[row, 0] = -1 / total**2
        if kind in ("variance", "std"):
            hessian[1, 1] = -2 / total**2
        return cls(moment / total, gradient, hessian)


class Statistic:
    """Smooth statistic of values (n,) with weights (n,), by default 1/n each.

    `slope` (n,) is its derivative in each value, `weight_slope` (n,) that in each weight.
    """

    def __init__(self, kind: StatisticKind, values: Array, weights: Array | None = None) -> None:
        self.weights = np.full(len(values), 1 / len(values)) if weights is None else weights
        total = float(self.weights.sum())
        mean = float(self.weights @ values) / total
        origin = mean if kind in ("mean", "variance", "std") else 0.0
        self._values, self._origin = values - origin, origin
        first = 0.0 if origin else float(self.weights @ self._values)
        square = float(self.weights @ self._values**2)
        self._moments = MomentFunction.from_moments(kind, total, first, square)
        inner = self._moments.value
        self._outer = _differentiate_root(inner) if kind in ROOTS else (inner, 1.0, 0.0)
        self.value = self._outer[0] + (origin if kind == "mean" else 0.0)
        zeroth, linear, square_rate = self._moments.first
        rise = self._outer[1]
        self.slope: Array = rise * self.weights * (linear + 2 * square_rate * self._values)
        self.weight_slope: Array = rise * (
            zeroth + linear * self._values + square_rate * self._values**2
        )

    def gradient(self, slopes: Array, weight_slopes: Array | None = None) -> Array:
        """Return the derivative (p,) in the parameters from those of the values (n, p) and of the
        weights (n, p).
        """
        gradient = self.slope @ slopes
        return gradient if weight_slopes is None else gradient + self.weight_slope @ weight_slopes

    def curvature(self, slopes: Array, weight_slopes: Array | None = None) -> Array:
        """Return the part (p, p) of the Hessian from first derivatives of values and weights (n,
        p).

        The remaining part is sum slope_k f_k'' + weight_slope_k w_k''.
        """
        first, second = self._moments.first, self._moments.second
        weights, values = self.weights, self._values
        moments = np.array(
            [np.zeros(slopes.shape[1]), weights @ slopes, 2 * (weights * values) @ slopes]
        )
        inner = 2 * first[2] * slopes.T @ (weights[:, None] * slopes)
        if weight_slopes is not None:
            moments += np.array([values**power @ weight_slopes for power in range(3)])
            mixed = ((first[1] + 2 * first[2] * values)[:, None] * slopes).T @ weight_slopes
            inner = inner + mixed + mixed.T
        inner = inner + moments.T @ second @ moments
        _, rise, bend = self._outer
        gradient = first @ moments
        return rise * inner + bend * np.outer(gradient, gradient)


def _differentiate_root(square: float) -> tuple[float, float, float]:
    """Return a root with its first two derivatives in the square; at zero, where they diverge, they
    are set to zero.
    """
    if square <= 0:
        return 0.0, 0.0, 0.0
    root = float(np.sqrt(square))
    return root, 1 / (2 * root), -1 / (4 * root**3)
