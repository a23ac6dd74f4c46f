"""Which parameters curves depend on at all.

Weighted range and spread of a response over a turn: equation (31) of Wang et al. (2017) is one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.constraints import Constraints, DesignBox
from planter.optimise.continuous_cycle import ContinuousCycle
from planter.optimise.objective import BreakpointHold, Conditions, LocalModel, ObjectiveSummary
from planter.optimise.problem import Problem
from planter.optimise.response import CycleResponse
from planter.optimise.sampled_cycle import SampledCycle
from planter.optimise.variance import Weights

RANK_TOLERANCE = 1e-10
"""Singular values below this share of the largest count as zero."""
WEIGHT_TOLERANCE = 1e-6
"""Weights below this are left out of a named direction."""


@dataclass(frozen=True)
class InsensitiveDirections:
    """Numerical rank of the curve's Jacobian, and its null space.

    `effective_parameters` is the rank; `directions` spans the null space, each {name: weight} in parts of the box
    width with the largest weight 1; `zero` (p,) marks parameters that have no effect alone; `space` (k, p) spans the
    null space by directions in shares of the box, at right angles to each other.
    """

    effective_parameters: int
    directions: list[dict[str, float]]
    zero: Flags
    space: Array

    @property
    def named(self) -> list[list[dict[str, float]]]:
        """The directions as lists of {name: weight}."""
        return [[{name: weight} for name, weight in direction.items()] for direction in self.directions]


def find_insensitivity(
    response: CycleResponse, x: Array, samples: int, held: Array | None = None
) -> InsensitiveDirections:
    """Rank and null space of the Jacobian of a curve in the design parameters.

    The curve is taken at `samples` angles of a turn at design x (p,) [SI]; columns are multiplied by the box width;
    the threshold is 1e-10 of the largest singular value. Where equations with gradients `held` (k, p) hold the design,
    the null space is what they leave of it.
    """
    phi = 2 * np.pi * np.arange(samples) / samples
    slopes = response.slopes(response.prologue(x), np.mod(phi, response.period))[1]
    width = response.upper - response.lower
    return find_insensitive(response.names, slopes[:, 1:] * width, None if held is None else held * width)


def find_insensitive(names: tuple[str, ...], columns: Array, rows: Array | None = None) -> InsensitiveDirections:
    """Return the rank of scaled slopes (n, p) of curves in parameters, and their null space by the names of these.

    Where equations with scaled gradients `rows` (k, p) hold the parameters, the null space is what they leave of it.
    """
    _, values, right = np.linalg.svd(columns, full_matrices=len(columns) < len(names))
    limit = RANK_TOLERANCE * values[0]
    rank = int((values > limit).sum())
    space = right[rank:]
    zero: Flags = np.linalg.norm(columns, axis=0) <= limit
    if rows is not None:
        from scipy.linalg import null_space

        rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        space = space.T @ null_space(rows @ space.T, RANK_TOLERANCE)
        space, zero = space.T, zero & (np.abs(rows).max(axis=0) <= RANK_TOLERANCE)
    return InsensitiveDirections(rank, _name_directions(names, space, zero), zero, space)


def _name_directions(names: tuple[str, ...], space: Array, zero: Flags) -> list[dict[str, float]]:
    """A basis of the null space that is easy to read: single parameters first, then reduced combinations."""
    single: list[dict[str, float]] = [{names[j]: 1.0} for j in np.flatnonzero(zero)]
    mixed = _reduce_echelon(np.where(zero, 0.0, space), len(space) - len(single))
    return single + [{names[j]: float(row[j]) for j in np.flatnonzero(np.abs(row) > WEIGHT_TOLERANCE)} for row in mixed]


def _reduce_echelon(space: Array, count: int) -> list[Array]:
    """The first `count` rows of the echelon form with complete pivoting, each scaled to a largest weight of 1."""
    rows = space.copy()
    for i in range(count):
        pivot, column = (int(k) for k in np.unravel_index(np.abs(rows[i:]).argmax(), rows[i:].shape))
        rows[[i, i + pivot]] = rows[[i + pivot, i]]
        rows[i] /= rows[i, column]
        others = np.arange(len(rows)) != i
        rows[others] -= np.outer(rows[others, column], rows[i])
    return [row / row[np.abs(row).argmax()] for row in rows[:count]]


Sampling = int | Literal["refined"]
DIRECTION_ANGLES = 360
"""Angles of a turn at which directions are judged where it is not sampled."""


class RangeVarianceObjective:
    """The `Objective` of a response, over N samples of a turn or, "refined", by true extremes and integrals."""

    unit = None

    def __init__(self, response: CycleResponse, weights: Weights, sampling: Sampling) -> None:
        self.response, self.weights, self.sampling = response, weights, sampling
        self.weight, self.windows = weights.weight_range, sampling == "refined"
        self.restart()

    def restart(self) -> None:
        """Forget the designs so far."""
        response, sampling = self.response, self.sampling
        self.turn: ContinuousCycle | SampledCycle = (
            ContinuousCycle(response) if sampling == "refined" else SampledCycle(response, int(sampling))
        )

    @property
    def kinks(self) -> SampledCycle | None:
        return self.turn if isinstance(self.turn, SampledCycle) else None

    @cached_property
    def felt(self) -> Flags:
        """Parameters that the response feels at its own design, (p,)."""
        return ~find_insensitivity(self.response, self.response.design, count_angles(self.sampling)).zero

    def outer(self, smooth: float) -> tuple[float, float, float]:
        """Return the contribution of the smooth value to the objective, with first and second derivative."""
        return self.weights.spread(smooth)

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self.turn.look(x)

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """Return the local model of the objective near a design x (p,)."""
        return self.turn.local(x).held(tuple(holds)) if isinstance(self.turn, SampledCycle) else self.turn.local(x)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        return self.turn.conditions(x)

    def flat(self, x: Array) -> Array:
        """Return the directions (k, p) to which the objective is insensitive at a design, to first order."""
        response = self.response
        return find_insensitivity(response, x, count_angles(self.sampling)).space * (response.upper - response.lower)


def count_angles(sampling: Sampling) -> int:
    """Angles of a turn at which the directions are judged that a response does not feel."""
    return DIRECTION_ANGLES if sampling == "refined" else int(sampling)


def build_range_problem(
    response: CycleResponse, weights: Weights, sampling: Sampling, constraints: Constraints | None = None
) -> Problem:
    """Least weighted range and spread of a response within its own bounds, searched in shares of these."""
    box = DesignBox.shares(response.names, response.lower, response.upper, response.design)
    return Problem(RangeVarianceObjective(response, weights, sampling), box, constraints)
