"""Requirements as constraints of an optimisation: rows counted in steps, so that one is as bad for each of them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.latest import Latest
from planter.optimise.conditions import Local, Look, Slopes, Values

if TYPE_CHECKING:
    from planter.planting.model import Device

KEPT = 1e-7
"""A requirement is kept if it is violated by no more than this share of its step."""


class Constraints:
    """Rows g(x) (k,) of a device's requirements, to be kept in [lower, upper] (k,); designs x are (p,) in SI."""

    def __init__(self, device: Device) -> None:
        from planter.planting.requirements.limits import limits
        from planter.planting.requirements.measures import Measures

        self.measures = Measures(device)
        self.limits = limits(self.measures)
        self.step = self.limits.step
        self.lower, self.upper = self.limits.lower / self.step, self.limits.upper / self.step
        names = [kind.name for kind in self.measures.kinds]
        self.owner = np.array([names.index(row.kind.name) for row in self.measures.rows])
        self.slopes = Latest(lambda x: self.measures.slopes(x) / self.step[:, None])

    @classmethod
    def of(cls, device: Device) -> Constraints | None:
        """Those of the machine file; None where it has none."""
        return None if device.machine.requirements is None else cls(device)

    @property
    def count(self) -> int:
        return len(self.lower)

    def values(self, x: Array) -> Array:
        """The rows, in steps. Raises ComputationError where a design has none."""
        scaled: Array = self.measures.at(x).values / self.step
        return scaled

    def curvature(self, x: Array, weights: Array) -> Array:
        """Weighted sum (p, p) of the rows' Hessians."""
        return self.measures.curvature(x, weights / self.step)

    def excess(self, x: Array) -> Array:
        """By how many steps each requirement is violated, 0 where it is kept, one for each kind."""
        values = self.values(x)
        beyond = np.maximum(0.0, np.maximum(self.lower - values, values - self.upper))
        return np.array([beyond[self.owner == k].max() for k in range(len(self.measures.kinds))])

    def violation(self, x: Array) -> float:
        """The largest excess [steps]; infinite where a design has no rows."""
        try:
            return float(self.excess(x).max())
        except ComputationError:
            return float("inf")


class Required:
    """A local model of the force with the rows of requirements among what is held in bounds. Implements `Local`."""

    def __init__(self, local: Local, constraints: Constraints) -> None:
        self.local, self.constraints = local, constraints
        self.bounds = np.hstack([local.bounds, [constraints.lower, constraints.upper]])

    def look(self, x: Array) -> Look:
        return self.local.look(x)

    def grown(self, x: Array, high: float, low: float) -> Required:
        return Required(self.local.grown(x, high, low), self.constraints)

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
