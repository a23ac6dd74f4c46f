"""What a design has to keep: rows in bounds, counted in steps, so that one is as bad for each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
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

    @property
    def even(self) -> Flags:
        """Which of the rows are equations, (k,)."""
        return self.lower == self.upper

    @property
    def giving(self) -> Flags:
        """Which kinds may give way where not all can be kept, (kinds,)."""
        return np.ones(len(self.kinds), dtype=bool)

    @property
    def equations(self) -> Constraints | None:
        """The equations alone; None where there are none."""
        rows = np.flatnonzero(self.even)
        return Part(self, rows) if len(rows) else None

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


class Part(Constraints):
    """Some of the rows (k,) of constraints."""

    def __init__(self, whole: Constraints, rows: Integers) -> None:
        self.whole, self.rows = whole, rows
        self.kinds, self.owner = whole.kinds, whole.owner[rows]
        self.lower, self.upper = whole.lower[rows], whole.upper[rows]

    def values(self, x: Array) -> Array:
        found: Array = self.whole.values(x)[self.rows]
        return found

    def slopes(self, x: Array) -> Array:
        found: Array = self.whole.slopes(x)[self.rows]
        return found

    def curvature(self, x: Array, weights: Array) -> Array:
        every = np.zeros(self.whole.count)
        every[self.rows] = weights
        return self.whole.curvature(x, every)


class Joined(Constraints):
    """The rows of several constraints, one after another; their kinds have different names."""

    def __init__(self, parts: Sequence[Constraints]) -> None:
        self.parts = parts
        self.kinds = [kind for part in parts for kind in part.kinds]
        before = np.cumsum([0, *(len(part.kinds) for part in parts)])
        self.owner = np.concatenate([part.owner + first for part, first in zip(parts, before[:-1], strict=True)])
        self.lower, self.upper = (np.concatenate(b) for b in zip(*((p.lower, p.upper) for p in parts), strict=True))

    @property
    def giving(self) -> Flags:
        return np.concatenate([part.giving for part in self.parts])

    @property
    def equations(self) -> Constraints | None:
        found = [equations for part in self.parts if (equations := part.equations) is not None]
        return joined(found)

    def values(self, x: Array) -> Array:
        return np.concatenate([part.values(x) for part in self.parts])

    def slopes(self, x: Array) -> Array:
        return np.vstack([part.slopes(x) for part in self.parts])

    def curvature(self, x: Array, weights: Array) -> Array:
        each = np.split(weights, np.cumsum([part.count for part in self.parts])[:-1])
        return np.sum([part.curvature(x, own) for part, own in zip(self.parts, each, strict=True)], axis=0)


def joined(parts: Sequence[Constraints]) -> Constraints | None:
    """Several constraints as one; None for none."""
    if len(parts) < 2:
        return parts[0] if parts else None
    return Joined(parts)


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
