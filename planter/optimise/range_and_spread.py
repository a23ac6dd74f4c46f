"""Weighted range and spread of a response over a turn: equation (31) of Wang et al. (2017) is one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.box import Box
from planter.optimise.conditions import Conditions, Local, Look
from planter.optimise.constraints import Constraints
from planter.optimise.directions import sensitivity
from planter.optimise.problem import Problem
from planter.optimise.refined import Refined
from planter.optimise.response import Response
from planter.optimise.samples import Hold, Samples

Sampling = int | Literal["refined"]
DIRECTIONS = 360
"""Angles of a turn at which directions are judged where it is not sampled."""


@dataclass(frozen=True)
class Weights:
    """weight_range * range + weight_variance * spread.

    The spread is the population variance [N2] for kind "paper", equation (31) as printed, which adds N to N2; and the
    standard deviation [N] for kind "newton".
    """

    weight_range: float
    weight_variance: float
    kind: Literal["paper", "newton"]

    def spread(self, variance: float) -> tuple[float, float, float]:
        """The weighted spread as a function of the variance: value, first and second derivative."""
        if self.kind == "paper":
            return self.weight_variance * variance, self.weight_variance, 0.0
        deviation = math.sqrt(max(variance, math.ulp(0.0)))
        first = self.weight_variance / (2 * deviation)
        return self.weight_variance * deviation, first, -first / (2 * variance) if variance > 0 else 0.0

    def value(self, range_N: float, variance: float) -> float:
        return self.weight_range * range_N + self.spread(variance)[0]


class RangeAndSpread:
    """The `Objective` of a response, over N samples of a turn or, "refined", by true extremes and integrals."""

    unit = None

    def __init__(self, response: Response, weights: Weights, sampling: Sampling) -> None:
        self.response, self.weights, self.sampling = response, weights, sampling
        self.weight, self.windows = weights.weight_range, sampling == "refined"
        self.turn: Refined | Samples = Refined(response) if sampling == "refined" else Samples(response, int(sampling))

    @property
    def kinks(self) -> Samples | None:
        return self.turn if isinstance(self.turn, Samples) else None

    @cached_property
    def felt(self) -> Flags:
        """Parameters that the response feels at its own design, (p,)."""
        return ~sensitivity(self.response, self.response.design, angles_of(self.sampling)).zero

    def outer(self, smooth: float) -> tuple[float, float, float]:
        return self.weights.spread(smooth)

    def look(self, x: Array) -> Look:
        return self.turn.look(x)

    def local(self, x: Array, holds: Sequence[Hold] = ()) -> Local:
        return self.turn.local(x).held(tuple(holds)) if isinstance(self.turn, Samples) else self.turn.local(x)

    def conditions(self, x: Array) -> Conditions:
        return self.turn.conditions(x)


def angles_of(sampling: Sampling) -> int:
    """Angles of a turn at which the directions are judged that a response does not feel."""
    return DIRECTIONS if sampling == "refined" else int(sampling)


def problem(
    response: Response, weights: Weights, sampling: Sampling, constraints: Constraints | None = None
) -> Problem:
    """Least weighted range and spread of a response within its own bounds, searched in shares of these."""
    box = Box.shares(response.names, response.lower, response.upper, response.design)
    return Problem(RangeAndSpread(response, weights, sampling), box, constraints)
