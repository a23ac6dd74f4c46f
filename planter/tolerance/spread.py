"""Distributions of inputs between two ends: uniform, triangular, or normal, truncated at three standard deviations."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi, sqrt
from typing import Literal

import numpy as np
from scipy.special import ndtr, ndtri

from planter.kernels import Array

Kind = Literal["normal", "uniform", "triangular"]
ENDS = 3.0
"""Standard deviations at which a normal distribution is truncated."""
_TAIL = float(ndtr(-ENDS))


@dataclass(frozen=True)
class Spread:
    """Symmetric distribution between `low` and `high` [display unit of the input]."""

    kind: Kind
    low: float
    high: float

    @property
    def centre(self) -> float:
        """Mean."""
        return (self.low + self.high) / 2

    @property
    def std(self) -> float:
        """Standard deviation.

        >>> round(Spread("uniform", 35, 45).std, 4), round(Spread("normal", -3, 3).std, 4)
        (2.8868, 0.9866)
        """
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return width / sqrt(12)
            case "triangular":
                return width / sqrt(24)
        lost = 2 * ENDS * exp(-(ENDS**2) / 2) / sqrt(2 * pi) / (1 - 2 * _TAIL)
        return width / (2 * ENDS) * sqrt(1 - lost)

    def quantiles(self, shares: Array) -> Array:
        """Return the quantiles (n,) at probabilities `shares` (n,) in [0, 1]."""
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return self.low + shares * width
            case "triangular":
                half = np.sqrt(np.minimum(shares, 1 - shares) / 2)
                return np.where(shares < 0.5, self.low + half * width, self.high - half * width)
        values: Array = self.centre + width / (2 * ENDS) * ndtri(_TAIL + shares * (1 - 2 * _TAIL))
        return values
