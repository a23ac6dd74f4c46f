"""Where a design may lie, and the variables that a search sees.

What a design has to keep: rows in bounds, counted in steps, so that one is as bad for each of them.

The point of a box beside another that keeps equations: by Newton's method, each step the least one in the box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
from planter.optimise.objective import LocalModel, ModelGradients, ModelValues, ObjectiveSummary


@dataclass(frozen=True)
class DesignBox:
    """Bounds (p,) on designs x (p,) with names, the design to start from, and the search's variables u (p,).

    x = origin + unit * u, so that u lies between `bottom` and `top`; `design` may lie outside the bounds.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array
    design: Array
    origin: Array
    unit: Array

    @classmethod
    def shares(cls, names: tuple[str, ...], lower: Array, upper: Array, design: Array) -> DesignBox:
        """Searched in shares of the box: u in [0, 1]^p, whatever the units of the design."""
        return cls(names, lower, upper, design, lower, upper - lower)

    @classmethod
    def plain(cls, names: tuple[str, ...], lower: Array, upper: Array, design: Array) -> DesignBox:
        """Searched as it is: u = x."""
        return cls(names, lower, upper, design, np.zeros(len(lower)), np.ones(len(lower)))

    @cached_property
    def bottom(self) -> Array:
        found: Array = (self.lower - self.origin) / self.unit
        return found

    @cached_property
    def top(self) -> Array:
        found: Array = (self.upper - self.origin) / self.unit
        return found

    @cached_property
    def start(self) -> Array:
        """The point u (p,) of the design to start from, taken into the box."""
        return self.point(self.design)

    def point(self, x: Array) -> Array:
        """Return the point u (p,) of a design x (p,), taken into the box."""
        return self.inside((x - self.origin) / self.unit)

    def at(self, u: Array) -> Array:
        """The design x (p,) at a point u (p,); on an upper bound it is that bound to the last bit."""
        return np.clip(np.where(u >= self.top, self.upper, self.origin + u * self.unit), self.lower, self.upper)

    def inside(self, u: Array) -> Array:
        """A point u (p,) taken into the box."""
        return np.clip(u, self.bottom, self.top)

    def room(self, u: Array) -> tuple[Array, Array]:
        """How far a point u (p,) is above the lower bounds and below the upper ones, (p,) each; negative outside."""
        return u - self.bottom, self.top - u

    def snapped(self, u: Array, margin: float) -> Array:
        """A point u (p,) with coordinates closer than `margin` to their bounds set onto them."""
        low, high = u < self.bottom + margin, u > self.top - margin
        return np.where(low, self.bottom, np.where(high, self.top, u))


FEASIBILITY_TOLERANCE = 1e-7
"""A constraint is kept if it is violated by no more than this share of its step."""


class ConstraintKind(Protocol):
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
class NamedConstraint:
    """A `Kind` with rows of its own in the unit of a step."""

    name: str
    sides: tuple[str, ...] = ("min",)
    unit: str = "1"
    step: float = 1.0


class Constraints(Protocol):
    """Rows g(x) (k,) in steps, to be kept in [lower, upper] (k,), of `kinds`: `owner` (k,) is the index of each row's.

    Where a lower and an upper bound are equal the row is an equation. Designs x are (p,).
    """

    kinds: Sequence[ConstraintKind]
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
        return ConstraintSubset(self, rows) if len(rows) else None

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


class ConstraintSubset(Constraints):
    """Some of the rows (k,) of constraints."""

    def __init__(self, whole: Constraints, rows: Integers) -> None:
        self.whole, self.rows = whole, rows
        self.kinds, self.owner = whole.kinds, whole.owner[rows]
        self.lower, self.upper = whole.lower[rows], whole.upper[rows]

    def values(self, x: Array) -> Array:
        """Return the constraint values (c,) at a design x (p,)."""
        found: Array = self.whole.values(x)[self.rows]
        return found

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian (c, p) of the constraints at a design x (p,)."""
        found: Array = self.whole.slopes(x)[self.rows]
        return found

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p) of weights . constraints at a design x (p,)."""
        every = np.zeros(self.whole.count)
        every[self.rows] = weights
        return self.whole.curvature(x, every)


class JoinedConstraints(Constraints):
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
        return join_constraints(found)

    def values(self, x: Array) -> Array:
        """Return the constraint values (c,) at a design x (p,)."""
        return np.concatenate([part.values(x) for part in self.parts])

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian (c, p) of the constraints at a design x (p,)."""
        return np.vstack([part.slopes(x) for part in self.parts])

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p) of weights . constraints at a design x (p,)."""
        each = np.split(weights, np.cumsum([part.count for part in self.parts])[:-1])
        return np.sum([part.curvature(x, own) for part, own in zip(self.parts, each, strict=True)], axis=0)


def join_constraints(parts: Sequence[Constraints]) -> Constraints | None:
    """Several constraints as one; None for none."""
    if len(parts) < 2:
        return parts[0] if parts else None
    return JoinedConstraints(parts)


class ConstrainedModel:
    """A local model of an objective with the rows of constraints among what is held in bounds. Implements `Local`."""

    def __init__(self, local: LocalModel, constraints: Constraints) -> None:
        self.local, self.constraints = local, constraints
        self.bounds = np.hstack([local.bounds, [constraints.lower, constraints.upper]])

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self.local.look(x)

    def grown(self, x: Array, high: float, low: float) -> ConstrainedModel:
        """Return the model with the rows that are missing if those at x are to stay within [low, high]."""
        return ConstrainedModel(self.local.grown(x, high, low), self.constraints)

    def values(self, x: Array) -> ModelValues:
        """Return the values of the smooth function, rows and holds at a design x (p,)."""
        found = self.local.values(x)
        try:
            rows = self.constraints.values(x)
        except ComputationError:  # the solver takes what is not finite for a step that went too far
            rows = np.full(self.constraints.count, np.nan)
        return replace(found, holds=np.append(found.holds, rows))

    def slopes(self, x: Array) -> ModelGradients:
        """Return the gradients of the smooth function, rows and holds at a design x (p,)."""
        found = self.local.slopes(x)
        return replace(found, holds=np.vstack([found.holds, self.constraints.slopes(x)]))

    def curvature(self, x: Array, weights: ModelValues) -> Array:
        """Return the Hessian (p, p) of weights . constraints at a design x (p,)."""
        own, required = np.split(weights.holds, [len(weights.holds) - self.constraints.count])
        return self.local.curvature(x, replace(weights, holds=own)) + self.constraints.curvature(x, required)


MAX_PROJECTION_STEPS = 20
STEP_SHARES = (1.0, 0.5, 0.25, 0.125, 0.0625)
"""Parts of a step that are tried: each has to take half its own part of the worst miss away."""
RESIDUAL_ROUNDING = 16 * float(np.finfo(float).eps)
"""A miss below this share of the largest right side is rounding."""
LINEAR_RESIDUAL = 1e-6
"""What a step may leave of the worst miss to first order, and still meets the equations."""


def project_onto_equations(box: DesignBox, equations: Constraints, u: Array) -> Array:
    """The point (p,) that keeps the equations to rounding, from a point u (p,).

    Where none near by in the box keeps them, the one at which the steps end; u itself where they have no values.
    """
    here = box.inside(u)
    rounding = RESIDUAL_ROUNDING * np.abs(equations.upper).max()
    try:
        miss = equations.upper - equations.values(box.at(here))
        for _ in range(MAX_PROJECTION_STEPS):
            if np.abs(miss).max() <= rounding:
                break
            slopes = equations.slopes(box.at(here)) * box.unit
            step = compute_short_step(slopes, miss, box.bottom - here, box.top - here)
            following = _find_following(box, equations, here, step, miss)
            if following is None:
                break
            here, miss = following
    except ComputationError:
        return box.inside(u)
    return here


def _find_following(
    box: DesignBox, equations: Constraints, here: Array, step: Array, miss: Array
) -> tuple[Array, Array] | None:
    """The point that a step (p,), or a part of it, leads to, and the miss there; None where no part helps."""
    for share in STEP_SHARES:
        trial = box.inside(here + share * step)
        left = equations.upper - equations.values(box.at(trial))
        if np.abs(left).max() <= (1 - share / 2) * np.abs(miss).max():
            return trial, left
    return None


def compute_short_step(slopes: Array, miss: Array, low: Array, high: Array) -> Array:
    """A short step d (p,) in its bounds with slopes (k, p) . d = miss (k,), as far as one can be found.

    Coordinates on a bound stay there if the others can do it alone.
    """
    inside = _clip_step(slopes, miss, low, high, (low < 0) & (high > 0))
    if np.abs(slopes @ inside - miss).max() <= LINEAR_RESIDUAL * np.abs(miss).max():
        return inside
    return _clip_step(slopes, miss, low, high, np.ones(len(low), dtype=bool))


def _clip_step(slopes: Array, miss: Array, low: Array, high: Array, free: Flags) -> Array:
    """The least step of the free coordinates (p,): what would pass its bounds stops there, and the others take over."""
    step = np.zeros(len(low))
    while free.any():
        rest = miss - slopes[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(slopes[:, free], rest, rcond=None)[0]
        beyond = free & ((step < low) | (step > high))
        step = np.clip(step, low, high)
        if not beyond.any():
            break
        free = free & ~beyond
    return step
