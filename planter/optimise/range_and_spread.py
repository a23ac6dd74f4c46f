"""Weighted range and spread of a response over a turn: equation (31) of Wang et al. (2017) is one."""

from __future__ import annotations

from collections.abc import Sequence
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
from planter.optimise.spread import Weights

Sampling = int | Literal["refined"]
DIRECTIONS = 360
"""Angles of a turn at which directions are judged where it is not sampled."""


class RangeAndSpread:
    """The `Objective` of a response, over N samples of a turn or, "refined", by true extremes and integrals."""

    unit = None

    def __init__(self, response: Response, weights: Weights, sampling: Sampling) -> None:
        self.response, self.weights, self.sampling = response, weights, sampling
        self.weight, self.windows = weights.weight_range, sampling == "refined"
        self.restart()

    def restart(self) -> None:
        """Forget the designs so far."""
        response, sampling = self.response, self.sampling
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

    def flat(self, x: Array) -> Array:
        response = self.response
        return sensitivity(response, x, angles_of(self.sampling)).space * (response.upper - response.lower)


def angles_of(sampling: Sampling) -> int:
    """Angles of a turn at which the directions are judged that a response does not feel."""
    return DIRECTIONS if sampling == "refined" else int(sampling)


def problem(
    response: Response, weights: Weights, sampling: Sampling, constraints: Constraints | None = None
) -> Problem:
    """Least weighted range and spread of a response within its own bounds, searched in shares of these."""
    box = Box.shares(response.names, response.lower, response.upper, response.design)
    return Problem(RangeAndSpread(response, weights, sampling), box, constraints)
