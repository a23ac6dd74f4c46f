"""How an input spreads between two ends: uniform, triangular, or normal with its ends at three standard deviations."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi, sqrt
from typing import Literal

import numpy as np
from scipy.special import ndtr, ndtri

from planter.kernels import Array

Kind = Literal["normal", "uniform", "triangular"]
ENDS = 3.0
"""Where a normal distribution is cut, in standard deviations."""
_TAIL = float(ndtr(-ENDS))


@dataclass(frozen=True)
class Spread:
    """A distribution, symmetric between `low` and `high` [in the input's shown unit]."""

    kind: Kind
    low: float
    high: float

    @property
    def centre(self) -> float:
        """Its mean."""
        return (self.low + self.high) / 2

    @property
    def std(self) -> float:
        """Its standard deviation.

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

    def at(self, shares: Array) -> Array:
        """Values below which shares (n,) in [0, 1] of all lie."""
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return self.low + shares * width
            case "triangular":
                half = np.sqrt(np.minimum(shares, 1 - shares) / 2)
                return np.where(shares < 0.5, self.low + half * width, self.high - half * width)
        found: Array = self.centre + width / (2 * ENDS) * ndtri(_TAIL + shares * (1 - 2 * _TAIL))
        return found
