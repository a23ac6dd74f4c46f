"""Limits on measures as constraints: one component each over all designs, and the rows that are
smooth near one.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from planter.engine.goal import Goal, find_display_unit
from planter.engine.measures import Limit
from planter.engine.solvers.constraints import (
    ConstraintReading,
    Constraints,
    NamedConstraint,
)
from planter.engine.solvers.joined import JoinedObjective
from planter.engine.solvers.objective import LocalModel, evaluate_summary, find_gradient
from planter.kernels import Array, Integers
from planter.numerics.arrays import LastCallCache

PAIRED_SHARE = 0.25
"""Peaks and valleys this near to the extremes, in spreads, are paired for a limit on a range."""


class MeasureLimits(Constraints):
    """The limits of a goal, each with its true value as the only component, in steps.

    A greatest value has a corner where two angles share it; `at` gives the rows on both sides of
    it.
    """

    def __init__(self, goal: Goal) -> None:
        self.goal = goal
        self.steps = np.array([goal.step(limit) for limit in goal.limits])
        numbers = np.array([limit.number for limit in goal.limits]) / self.steps
        is_upper = np.array([limit.sign > 0 for limit in goal.limits])
        self.lower, self.upper = (
            np.where(is_upper, -np.inf, numbers),
            np.where(is_upper, numbers, np.inf),
        )
        self.owner: Integers = np.arange(len(goal.limits))
        self._rows = LastCallCache(lambda x: LimitRows(self, x))
        pairs = zip(goal.limits, self.steps.tolist(), strict=True)
        self.kinds = [self._name(limit, step) for limit, step in pairs]

    def _name(self, limit: Limit, step: float) -> NamedConstraint:
        unit = find_display_unit(self.goal.machine, limit.measure).text
        return NamedConstraint(str(limit), ("max" if limit.sign > 0 else "min",), unit, step)

    @property
    def windows(self) -> bool:
        return True

    def at(self, x: Array) -> LimitRows:
        """Return the rows near a design x (p,)."""
        return self._rows(x)

    def values(self, x: Array) -> Array:
        """Return what the limits are on (k,) at a design x (p,).

        Raises ComputationError without a cycle.
        """
        values = [
            evaluate_summary(limited, limited.summarise(x)).objective
            for limited in self.goal.limited
        ]
        return np.array(values) / self.steps

    def read(self, x: Array) -> Sequence[ConstraintReading | None]:
        """Return the limits' values at a design x (p,), None where a condition never holds."""
        values = [self.goal.evaluate_limit(x, limit) for limit in self.goal.limits]
        keys = [f"{limit.measure} {'<=' if limit.sign > 0 else '>='}" for limit in self.goal.limits]
        return [
            None if value is None else ConstraintReading(value, limit.number, key, limit.sign)
            for limit, value, key in zip(self.goal.limits, values, keys, strict=True)
        ]

    def slopes(self, x: Array) -> Array:
        """Return their gradients (k, p)."""
        slopes: Array = (
            np.array([find_gradient(limited, x) for limited in self.goal.limited])
            / self.steps[:, None]
        )
        return slopes

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (k,)."""
        rows = [LimitRow(limited, x, None) for limited in self.goal.limited]
        parts = [
            row.curvature(x, weight[None])
            for row, weight in zip(rows, weights / self.steps, strict=True)
        ]
        total: Array = np.sum(parts, axis=0)
        return total


class LimitRow:
    """Rows of one limit near a design: linear functions of the smooth value and the rows of its
    local model.

    A limit on a greatest value holds for each row of its group, one on a range for each pair of a
    peak and a valley; a greatest value that must be reached is that of the row that has it now, as
    it is for any limit without a `sign`.
    """

    def __init__(self, limited: JoinedObjective, x: Array, sign: int | None) -> None:
        self.local: LocalModel = limited.local(x)
        rows, groups = self.local.values(x)[1:], self.local.groups
        chosen = [np.flatnonzero(groups == group) for group in range(len(limited.weights))]
        is_each = sign is not None and bool((sign * limited.weights > 0).all())
        picked = [
            _pick(rows, places, unit, is_each, len(chosen) > 1)
            for places, unit in zip(chosen, limited.units, strict=True)
        ]
        combinations = list(itertools.product(*picked))
        self.matrix = np.zeros((len(combinations), 1 + len(rows)))
        self.matrix[:, 0] = 1.0
        for row, places in zip(self.matrix, combinations, strict=True):
            row[1 + np.array(places, dtype=np.int64)] = limited.weights

    def values(self, x: Array) -> Array:
        """Return the rows (k,) at a design x (p,)."""
        rows: Array = self.matrix @ self.local.values(x)
        return rows

    def slopes(self, x: Array) -> Array:
        """Return their gradients (k, p)."""
        gradients: Array = self.matrix @ self.local.slopes(x)
        return gradients

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (k,)."""
        return self.local.curvature(x, weights @ self.matrix)


def _pick(rows: Array, places: Integers, unit: float, is_each: bool, is_paired: bool) -> Integers:
    """Return the rows of a group that count: all of them, those near the largest if they are
    paired, or the largest.
    """
    top = rows[places].max()
    if not is_each:
        return places[[rows[places].argmax()]]
    return places[rows[places] >= top - PAIRED_SHARE * unit] if is_paired else places


class LimitRows(Constraints):
    """The rows of all limits near a design x (p,)."""

    def __init__(self, limits: MeasureLimits, x: Array) -> None:
        goal = limits.goal
        self.rows = [
            LimitRow(limited, x, limit.sign)
            for limited, limit in zip(goal.limited, goal.limits, strict=True)
        ]
        self.counts = [len(row.matrix) for row in self.rows]
        self.owner = np.repeat(limits.owner, self.counts)
        self.kinds, self.steps = limits.kinds, limits.steps[self.owner]
        self.lower, self.upper = limits.lower[self.owner], limits.upper[self.owner]

    def values(self, x: Array) -> Array:
        """Return the rows (k,) at a design x (p,)."""
        values: Array = np.concatenate([row.values(x) for row in self.rows]) / self.steps
        return values

    def slopes(self, x: Array) -> Array:
        """Return their gradients (k, p)."""
        slopes: Array = np.vstack([row.slopes(x) for row in self.rows]) / self.steps[:, None]
        return slopes

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (k,)."""
        parts = np.split(weights / self.steps, np.cumsum(self.counts)[:-1])
        total: Array = np.sum(
            [row.curvature(x, part) for row, part in zip(self.rows, parts, strict=True)], axis=0
        )
        return total
