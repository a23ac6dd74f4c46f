"""What a design has to keep: rows in bounds, counted in steps, so that one is as bad for each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.conditions import Local, Look, Slopes, Values

KEPT = 1e-7
"""A constraint is kept if it is violated by no more than this share of its step."""


class Kind(Protocol):
    """A constraint as results name it: the sides that it may bind on, and the size of a step in its unit."""

    @property
    def name(self) -> str: ...
    @property
    def sides(self) -> tuple[str, ...]: ...
    @property
    def unit(self) -> str: ...
    @property
    def step(self) -> float: ...


@dataclass(frozen=True)
class Named:
    """A `Kind` with rows of its own in the unit of a step."""

    name: str
    sides: tuple[str, ...] = ("min",)
    unit: str = "1"
    step: float = 1.0


class Constraints(Protocol):
    """Rows g(x) (k,) in steps, to be kept in [lower, upper] (k,), of `kinds`: `owner` (k,) is the index of each row's.

    Where a lower and an upper bound are equal the row is an equation. Designs x are (p,).
    """

    kinds: Sequence[Kind]
    owner: Integers
    lower: Array
    upper: Array

    def values(self, x: Array) -> Array:
        """The rows (k,). Raises ComputationError where a design has none."""

    def slopes(self, x: Array) -> Array:
        """Gradients of the rows, (k, p)."""

    def curvature(self, x: Array, weights: Array) -> Array:
        """Weighted sum (p, p) of the rows' Hessians."""

    @property
    def count(self) -> int:
        return len(self.lower)

    def excess(self, x: Array) -> Array:
        """By how many steps each kind is violated, 0 where it is kept, (kinds,)."""
        values = self.values(x)
        beyond = np.maximum(0.0, np.maximum(self.lower - values, values - self.upper))
        worst = np.zeros(len(self.kinds))
        np.maximum.at(worst, self.owner, beyond)
        return worst

    def violation(self, x: Array) -> float:
        """The largest excess [steps]; infinite where a design has no rows."""
        try:
            return float(self.excess(x).max())
        except ComputationError:
            return float("inf")


class Constrained:
    """A local model of an objective with the rows of constraints among what is held in bounds. Implements `Local`."""

    def __init__(self, local: Local, constraints: Constraints) -> None:
        self.local, self.constraints = local, constraints
        self.bounds = np.hstack([local.bounds, [constraints.lower, constraints.upper]])

    def look(self, x: Array) -> Look:
        return self.local.look(x)

    def grown(self, x: Array, high: float, low: float) -> Constrained:
        return Constrained(self.local.grown(x, high, low), self.constraints)

    def values(self, x: Array) -> Values:
        found = self.local.values(x)
        try:
            rows = self.constraints.values(x)
        except ComputationError:  # the solver takes what is not finite for a step that went too far
            rows = np.full(self.constraints.count, np.nan)
        return replace(found, holds=np.append(found.holds, rows))

    def slopes(self, x: Array) -> Slopes:
        found = self.local.slopes(x)
        return replace(found, holds=np.vstack([found.holds, self.constraints.slopes(x)]))

    def curvature(self, x: Array, weights: Values) -> Array:
        own, required = np.split(weights.holds, [len(weights.holds) - self.constraints.count])
        return self.local.curvature(x, replace(weights, holds=own)) + self.constraints.curvature(x, required)
