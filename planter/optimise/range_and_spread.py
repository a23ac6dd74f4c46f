"""Weighted range and spread of a response over a turn: equation (31) of Wang et al. (2017) is one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.box import Box
from planter.optimise.conditions import Conditions, Look, Rows, Slopes, Values
from planter.optimise.constraints import Constraints
from planter.optimise.directions import sensitivity
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Problem
from planter.optimise.refined import Refined
from planter.optimise.response import Response
from planter.optimise.samples import Hold, Samples

Sampling = int | Literal["refined"]


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

    def of(self, look: Look) -> Evaluation:
        """What a turn is worth."""
        return Evaluation(self.value(look.range, look.variance), look)


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

    @property
    def samples(self) -> int:
        """Angles of a turn at which directions are judged."""
        return 360 if self.sampling == "refined" else int(self.sampling)

    @cached_property
    def felt(self) -> Flags:
        """Parameters that the response feels at its own design, (p,)."""
        return ~sensitivity(self.response, self.response.design, self.samples).zero

    def evaluate(self, x: Array) -> Evaluation:
        return self.weights.of(self.turn.look(x))

    def local(self, x: Array, holds: Sequence[Hold] = ()) -> Weighted:
        if isinstance(self.turn, Samples):
            return Weighted(self.turn.local(x).held(tuple(holds)), self.weights)
        return Weighted(self.turn.local(x), self.weights)

    def conditions(self, x: Array) -> Conditions:
        found = self.turn.conditions(x)
        rate = self.weights.spread(self.turn.look(x).variance)[1]
        return replace(found, smooth=rate * found.smooth, kinks=rate * found.kinks)


class Weighted:
    """Rows of a turn with the weighted spread in the place of the variance. Implements `Local`."""

    def __init__(self, rows: Rows, weights: Weights) -> None:
        self.rows, self.weights, self.bounds = rows, weights, rows.bounds

    def evaluate(self, x: Array) -> Evaluation:
        return self.weights.of(self.rows.look(x))

    def grown(self, x: Array, high: float, low: float) -> Weighted:
        return Weighted(self.rows.grown(x, high, low), self.weights)

    def values(self, x: Array) -> Values:
        found = self.rows.values(x)
        return replace(found, smooth=self.weights.spread(found.smooth)[0])

    def slopes(self, x: Array) -> Slopes:
        found = self.rows.slopes(x)
        return replace(found, smooth=self.weights.spread(self.rows.values(x).smooth)[1] * found.smooth)

    def curvature(self, x: Array, weights: Values) -> Array:
        _, first, second = self.weights.spread(self.rows.values(x).smooth)
        bent = self.rows.curvature(x, replace(weights, smooth=weights.smooth * first))
        along = self.rows.slopes(x).smooth
        total: Array = bent + weights.smooth * second * np.outer(along, along)
        return total


def problem(
    response: Response, weights: Weights, sampling: Sampling, constraints: Constraints | None = None
) -> Problem:
    """Least weighted range and spread of a response within its own bounds, searched in shares of these."""
    box = Box.shares(response.names, response.lower, response.upper, response.design)
    return Problem(RangeAndSpread(response, weights, sampling), box, constraints)
