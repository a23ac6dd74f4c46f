"""Bounds and constraints of designs, and the projection onto equality constraints.

Constraint components are scaled by the step of their kind, so that violations are comparable. The
projection uses Newton's method with short steps in the box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from planter.engine.solvers.objective import LocalModel, ObjectiveSummary
from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers


@dataclass(frozen=True)
class DesignBox:
    """Bounds (p,) on designs x (p,) with names, the initial design, and the variables u (p,) of the
    search.

    x = origin + unit * u, so that u lies between `bottom` and `top`; `design` may lie outside the
    bounds.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array
    design: Array
    origin: Array
    unit: Array

    @classmethod
    def shares(cls, names: tuple[str, ...], lower: Array, upper: Array, design: Array) -> DesignBox:
        """Return a box with variables u in [0, 1]^p, shares of the bounds."""
        return cls(names, lower, upper, design, lower, upper - lower)

    @classmethod
    def plain(cls, names: tuple[str, ...], lower: Array, upper: Array, design: Array) -> DesignBox:
        """Return a box with variables u = x."""
        return cls(names, lower, upper, design, np.zeros(len(lower)), np.ones(len(lower)))

    @cached_property
    def bottom(self) -> Array:
        bounds: Array = (self.lower - self.origin) / self.unit
        return bounds

    @cached_property
    def top(self) -> Array:
        bounds: Array = (self.upper - self.origin) / self.unit
        return bounds

    @cached_property
    def start(self) -> Array:
        """Point u (p,) of the initial design, clipped to the box."""
        return self.point(self.design)

    def point(self, x: Array) -> Array:
        """Return the point u (p,) of a design x (p,), clipped to the box."""
        return self.inside((x - self.origin) / self.unit)

    def at(self, u: Array) -> Array:
        """Return the design x (p,) at a point u (p,), which at an upper bound is exactly that
        bound.
        """
        return np.clip(
            np.where(u >= self.top, self.upper, self.origin + u * self.unit), self.lower, self.upper
        )

    def inside(self, u: Array) -> Array:
        """Return a point u (p,) clipped to the box."""
        return np.clip(u, self.bottom, self.top)

    def slack(self, u: Array) -> tuple[Array, Array]:
        """Return the distances of a point u (p,) from the lower and upper bounds, (p,) each,
        negative outside.
        """
        return u - self.bottom, self.top - u

    def snapped(self, u: Array, margin: float) -> Array:
        """Return a point u (p,) with coordinates closer than `margin` to a bound set onto it."""
        low, high = u < self.bottom + margin, u > self.top - margin
        return np.where(low, self.bottom, np.where(high, self.top, u))


FEASIBILITY_TOLERANCE = 1e-7
"""Largest violation of a satisfied constraint, in steps."""


class ConstraintKind(Protocol):
    """Name of a constraint in results, sides on which it may be active, and size of a step in its
    unit.
    """

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
    """A `ConstraintKind` as plain data."""

    name: str
    sides: tuple[str, ...] = ("min",)
    unit: str = "1"
    step: float = 1.0


class ConstraintReading(NamedTuple):
    """Value of a constraint at a design, and the limit on the side where that is violated or
    nearest, in the constraint's unit.

    `key` is what is written before the limit; `sign` is +1 for an upper limit and -1 for a lower
    one.
    """

    value: float
    limit: float
    key: str
    sign: int


class Constraints(Protocol):
    """Constraints lower <= g(x) <= upper with k components in steps, for designs x (p,).

    `owner` (k,) is the index in `kinds` of each component. Components with equal bounds are
    equality constraints.
    """

    kinds: Sequence[ConstraintKind]
    owner: Integers
    lower: Array
    upper: Array

    def values(self, x: Array) -> Array:
        """Return the components (k,) at a design x (p,).

        Raises ComputationError if they do not exist.
        """

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian (k, p) of the components at a design x (p,)."""

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of the Hessians of the components with weights (k,)."""

    @property
    def count(self) -> int:
        return len(self.lower)

    @property
    def windows(self) -> bool:
        """Whether the components near a design, `at`, are others than those of all designs."""
        return False

    def at(self, x: Array) -> Constraints:
        """Return components that are smooth near a design x (p,) and mean the same there."""
        return self

    @property
    def even(self) -> Flags:
        """Flags (k,) of the equality constraints."""
        return self.lower == self.upper

    @property
    def giving(self) -> Flags:
        """Flags (kinds,) of the kinds that may be relaxed if the constraints are infeasible."""
        return np.ones(len(self.kinds), dtype=bool)

    @property
    def equations(self) -> Constraints | None:
        """Equality constraints, or None without constraints."""
        rows = np.flatnonzero(self.even)
        return ConstraintSubset(self, rows) if len(rows) else None

    def read(self, x: Array) -> Sequence[ConstraintReading | None]:
        """Return the reading of each kind at a design x (p,), None where a kind has no value."""
        return [None] * len(self.kinds)

    def excess(self, x: Array) -> Array:
        """Return the violation of each kind in steps, 0 if satisfied, (kinds,)."""
        values = self.values(x)
        beyond = np.maximum(0.0, np.maximum(self.lower - values, values - self.upper))
        worst = np.zeros(len(self.kinds))
        np.maximum.at(worst, self.owner, beyond)
        return worst

    def violation(self, x: Array) -> float:
        """Return the largest violation in steps, infinite if the components do not exist at a
        design.
        """
        try:
            return float(self.excess(x).max())
        except ComputationError:
            return float("inf")


class ConstraintSubset(Constraints):
    """Subset of the components of constraints, by their indices `rows` (k,)."""

    def __init__(self, constraints: Constraints, rows: Integers) -> None:
        self.constraints, self.rows = constraints, rows
        self.kinds, self.owner = constraints.kinds, constraints.owner[rows]
        self.lower, self.upper = constraints.lower[rows], constraints.upper[rows]

    def values(self, x: Array) -> Array:
        """Return the constraint values (c,) at a design x (p,)."""
        values: Array = self.constraints.values(x)[self.rows]
        return values

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian (c, p) of the constraints at a design x (p,)."""
        slopes: Array = self.constraints.slopes(x)[self.rows]
        return slopes

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p) of weights . constraints at a design x (p,)."""
        full_weights = np.zeros(self.constraints.count)
        full_weights[self.rows] = weights
        return self.constraints.curvature(x, full_weights)


class JoinedConstraints(Constraints):
    """Concatenation of several constraints, whose kinds have different names."""

    def __init__(self, parts: Sequence[Constraints]) -> None:
        self.parts = parts
        self.kinds = [kind for part in parts for kind in part.kinds]
        before = np.cumsum([0, *(len(part.kinds) for part in parts)])
        self.owner = np.concatenate(
            [part.owner + first for part, first in zip(parts, before[:-1], strict=True)]
        )
        self.lower, self.upper = (
            np.concatenate(b) for b in zip(*((p.lower, p.upper) for p in parts), strict=True)
        )

    @property
    def windows(self) -> bool:
        return any(part.windows for part in self.parts)

    def at(self, x: Array) -> JoinedConstraints:
        """Return the components of all parts near a design x (p,)."""
        return JoinedConstraints([part.at(x) for part in self.parts])

    @property
    def giving(self) -> Flags:
        return np.concatenate([part.giving for part in self.parts])

    @property
    def equations(self) -> Constraints | None:
        parts = [equations for part in self.parts if (equations := part.equations) is not None]
        return join_constraints(parts)

    def read(self, x: Array) -> Sequence[ConstraintReading | None]:
        """Return the readings of the kinds of all parts at a design x (p,)."""
        return [reading for part in self.parts for reading in part.read(x)]

    def values(self, x: Array) -> Array:
        """Return the constraint values (c,) at a design x (p,)."""
        return np.concatenate([part.values(x) for part in self.parts])

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian (c, p) of the constraints at a design x (p,)."""
        return np.vstack([part.slopes(x) for part in self.parts])

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p) of weights . constraints at a design x (p,)."""
        split_weights = np.split(weights, np.cumsum([part.count for part in self.parts])[:-1])
        return np.sum(
            [
                part.curvature(x, part_weights)
                for part, part_weights in zip(self.parts, split_weights, strict=True)
            ],
            axis=0,
        )


def join_constraints(parts: Sequence[Constraints]) -> Constraints | None:
    """Return the concatenation of constraints, or None without constraints."""
    if len(parts) < 2:
        return parts[0] if parts else None
    return JoinedConstraints(parts)


class ConstrainedModel:
    """Local model of an objective with constraints among its `holds`. Implements `LocalModel`."""

    def __init__(self, local: LocalModel, constraints: Constraints) -> None:
        self.local, self.constraints, self.groups = local, constraints, local.groups
        self.bounds = np.hstack([local.bounds, [constraints.lower, constraints.upper]])

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self.local.summarise(x)

    def extended(self, x: Array, tops: Array) -> ConstrainedModel:
        """Return the model with the rows that exceed the tops of their groups at x."""
        return ConstrainedModel(self.local.extended(x, tops), self.constraints)

    def values(self, x: Array) -> Array:
        """Return the functions of the model, then the constraints, at a design x (p,)."""
        try:
            rows = self.constraints.values(x)
        except ComputationError:  # solvers shorten steps to values that are not finite
            rows = np.full(self.constraints.count, np.nan)
        return np.append(self.local.values(x), rows)

    def slopes(self, x: Array) -> Array:
        """Return their gradients (n, p) at a design x (p,)."""
        return np.vstack([self.local.slopes(x), self.constraints.slopes(x)])

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (n,)."""
        inner, required = np.split(weights, [len(weights) - self.constraints.count])
        return self.local.curvature(x, inner) + self.constraints.curvature(x, required)


MAX_PROJECTION_STEPS = 20
STEP_SHARES = (1.0, 0.5, 0.25, 0.125, 0.0625)
"""Shares of a step, each of which must remove half its share of the largest residual."""
RESIDUAL_ROUNDING = 16 * float(np.finfo(float).eps)
"""Residual attributed to rounding, as a share of the largest right side."""
LINEAR_RESIDUAL = 1e-6
"""Largest share of the residual which a step may leave to first order."""


def project_onto_equations(box: DesignBox, equations: Constraints, u: Array) -> Array:
    """Return the projection (p,) of a point u (p,) onto equality constraints, satisfied to
    rounding.

    Without a solution in the box, return the last point of the iteration; without values, return u
    clipped to the box.
    """
    current = box.inside(u)
    rounding = RESIDUAL_ROUNDING * np.abs(equations.upper).max()
    try:
        miss = equations.upper - equations.values(box.at(current))
        for _ in range(MAX_PROJECTION_STEPS):
            if np.abs(miss).max() <= rounding:
                break
            slopes = equations.slopes(box.at(current)) * box.unit
            step = compute_short_step(slopes, miss, box.bottom - current, box.top - current)
            following = _find_following(box, equations, current, step, miss)
            if following is None:
                break
            current, miss = following
    except ComputationError:
        return box.inside(u)
    return current


def _find_following(
    box: DesignBox, equations: Constraints, current: Array, step: Array, miss: Array
) -> tuple[Array, Array] | None:
    """Return the point after a share of a step (p,) and its residual (k,), or None if no share
    reduces it enough.
    """
    for share in STEP_SHARES:
        trial = box.inside(current + share * step)
        left = equations.upper - equations.values(box.at(trial))
        if np.abs(left).max() <= (1 - share / 2) * np.abs(miss).max():
            return trial, left
    return None


def compute_short_step(slopes: Array, miss: Array, low: Array, high: Array) -> Array:
    """Return a short step d (p,) within bounds that solves slopes (k, p) . d = miss (k,), if
    possible.

    Coordinates at a bound do not move if the others suffice.
    """
    inside = _clip_step(slopes, miss, low, high, (low < 0) & (high > 0))
    if np.abs(slopes @ inside - miss).max() <= LINEAR_RESIDUAL * np.abs(miss).max():
        return inside
    return _clip_step(slopes, miss, low, high, np.ones(len(low), dtype=bool))


def _clip_step(slopes: Array, miss: Array, low: Array, high: Array, free: Flags) -> Array:
    """Return the minimum-norm step (p,) of the free coordinates, which are fixed in turn at bounds
    they would pass.
    """
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
