"""Objective (31) of Wang et al. (2017): weighted range and spread of the support force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from planter.planting.file import Machine


@dataclass(frozen=True)
class Objective:
    """weight_range * range + weight_variance * spread.

    The spread is the population variance [N2] for kind "paper", equation (31) as printed, which adds N to N2; and the
    standard deviation [N] for kind "newton".
    """

    weight_range: float
    weight_variance: float
    kind: Literal["paper", "newton"]

    @classmethod
    def of(cls, machine: Machine) -> Objective:
        settings = machine.objective
        return cls(settings.weight_range, settings.weight_variance, settings.kind)

    def spread(self, variance: float) -> tuple[float, float, float]:
        """The weighted spread as a function of the variance: value, first and second derivative."""
        if self.kind == "paper":
            return self.weight_variance * variance, self.weight_variance, 0.0
        deviation = math.sqrt(max(variance, math.ulp(0.0)))
        first = self.weight_variance / (2 * deviation)
        return self.weight_variance * deviation, first, -first / (2 * variance) if variance > 0 else 0.0

    def value(self, range_N: float, variance: float) -> float:
        return self.weight_range * range_N + self.spread(variance)[0]


@dataclass(frozen=True)
class Evaluation:
    """A design's force over a turn [N, N2] and what the objective makes of it."""

    objective: float
    range_N: float
    variance_N2: float
    max_N: float
    min_N: float
    mean_N: float
