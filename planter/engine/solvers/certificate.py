"""Karush-Kuhn-Tucker conditions of a minimax problem in a box, checked independently of a solver.

The objective is weight (max f - min f) + s, with rows f and s what it makes of a smooth function.
At a local minimum u in the box there are shares mu >= 0 of the rows that attain the maximum, nu >=
0 of those that attain the minimum, summing to the weight each, multipliers of the bounds z_lower,
z_upper >= 0, and theta in [0, 1] for each sample that sits on a breakpoint, with

    s_u + kinks' theta + upper_u' mu - lower_u' nu - z_lower + z_upper = 0,
    mu (max f - f) = 0,  nu (f - min f) = 0,  z_lower (u - bottom) = 0,  z_upper (top - u) = 0.

A sample on a breakpoint has two one-sided gradients; it is listed with both, and theta mixes those of
its share in the variance: zero lies in the sum of Clarke's subdifferentials (Clarke, Optimization
and Nonsmooth Analysis, 1983, 2.3). Where nothing sits on a breakpoint this is the usual KKT point of the
epigraph form, without rows that of a smooth programme. Constraints lower <= g(u) <= upper add g_u'
lambda, lambda > 0 only at an upper and < 0 only at a lower bound; an equation's may have either
sign.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy

from planter.engine.solvers.objective import find_tops
from planter.engine.solvers.problem import Problem
from planter.files.record import Record
from planter.kernels import Array, Integers

ACTIVE = 1e-6
"""Rows this close to an extreme, as a share of the range, may carry multipliers, and bounds in the
box's unit.

Constraints may that are this close to their bounds in steps, or to first order in the box's unit.
"""


@dataclass(frozen=True)
class Multipliers:
    """Multipliers at a point, in the objective's unit per that of the rows and per the box's unit
    (bounds).

    `rows` (r,): of the rows of `Conditions`; `at_lower`, `at_upper` (p,): of the bounds; `kinks`
    (k,); `required` (c,): of the constraints, per step, with the sign of the side.
    """

    rows: Array
    at_lower: Array
    at_upper: Array
    kinks: Array
    required: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class Residuals:
    """Violation of each condition, dimensionless in units of the scale of the problem."""

    stationarity: float
    shares: float
    feasibility: float
    sign: float
    complementarity: float

    @property
    def worst(self) -> float:
        return max(
            self.stationarity, self.shares, self.feasibility, self.sign, self.complementarity
        )


def check_conditions(problem: Problem, u: Array, multipliers: Multipliers) -> Residuals:
    """Return the residuals of the conditions at a point u (p,) with given multipliers."""
    conditions, m, objective = problem.conditions(u), multipliers, problem.objective
    slope = (
        conditions.smooth
        + conditions.kinks.T @ m.kinks
        + conditions.gradients.T @ m.rows
        - m.at_lower
        + m.at_upper
    )
    required = _ConstraintState(problem, u)
    slope = slope + required.gradients.T @ m.required
    units, groups = objective.units / problem.scale, conditions.groups
    sums = np.bincount(groups, m.rows, len(units)) if len(units) else np.empty(0)
    bounds = np.concatenate([m.at_lower, m.at_upper]) / problem.scale
    slack = (
        find_tops(conditions.rows, groups, len(units))[groups] - conditions.rows
    ) / problem.scale
    box_slack = np.concatenate(problem.box.slack(u))
    return Residuals(
        stationarity=_max_norm(slope) / problem.scale,
        shares=_max_norm((sums - objective.weights) * units),
        feasibility=max(_max_norm(np.minimum(box_slack, 0)), required.violation),
        sign=_max_norm(
            np.minimum(np.concatenate([m.rows * units[groups], bounds, m.kinks, 1 - m.kinks]), 0)
        ),
        complementarity=max(
            _max_norm(m.rows * slack),
            _max_norm(bounds * box_slack),
            _max_norm(required.complementarity(m.required) / problem.scale),
        ),
    )


def estimate_multipliers(problem: Problem, u: Array) -> Multipliers:
    """Return the multipliers that best satisfy the conditions at a point u (p,), by bounded least
    squares.

    Only rows and bounds that are active within `ACTIVE` get any; signs are exact, the rest is least
    squares.
    """
    conditions, scale, objective = problem.conditions(u), problem.scale, problem.objective
    tops = find_tops(conditions.rows, conditions.groups, len(objective.weights))
    gap = (tops[conditions.groups] - conditions.rows) / objective.units[conditions.groups]
    active = np.flatnonzero(gap <= ACTIVE)
    groups = conditions.groups[active]
    low, high = (np.flatnonzero(box_slack <= ACTIVE) for box_slack in problem.box.slack(u))
    eye, required = np.eye(len(u)), _ConstraintState(problem, u)
    up, down, even = required.active()
    rows = required.gradients
    blocks = [
        (objective.weights[groups, None] * conditions.gradients[active]).T,
        conditions.kinks.T,
        -scale * eye[:, low],
        scale * eye[:, high],
        scale * rows[up].T,
        -scale * rows[down].T,
        scale * rows[even].T,
    ]
    sizes = [block.shape[1] for block in blocks]
    sums = np.zeros((len(tops), sum(sizes)))
    sums[groups, np.arange(len(active))] = scale
    matrix = np.vstack([np.hstack(blocks), sums])
    target = np.append(-conditions.smooth, np.full(len(sums), scale))
    lower_limits = np.repeat([*[0.0] * 6, -np.inf], sizes)
    upper_limits = np.repeat([np.inf, 1.0, *[np.inf] * 5], sizes)
    solved = (
        scipy.optimize.lsq_linear(
            matrix, target, (lower_limits, upper_limits), method="bvls", tol=1e-15
        ).x
        if sum(sizes)
        else np.empty(0)
    )
    shares, theta, below, above, over, below_lower, free = np.split(solved, np.cumsum(sizes)[:-1])
    count = len(rows)
    return Multipliers(
        rows=_scatter(objective.weights[groups] * shares, active, len(conditions.rows)),
        at_lower=_scatter(scale * below, low, len(u)),
        at_upper=_scatter(scale * above, high, len(u)),
        kinks=theta,
        required=scale
        * (
            _scatter(over, up, count)
            - _scatter(below_lower, down, count)
            + _scatter(free, even, count)
        ),
    )


class _ConstraintState:
    """Constraints at a point u (p,): gradients in u (c, p) and distances from both bounds (c,), in
    steps.
    """

    def __init__(self, problem: Problem, u: Array) -> None:
        x = problem.design(u)
        constraints = None if problem.constraints is None else problem.constraints.at(x)
        if constraints is None:
            self.gradients, self.above, self.below = np.empty((0, len(u))), np.empty(0), np.empty(0)
            self.equations = np.empty(0, dtype=bool)
            return
        values = constraints.values(x)
        self.gradients = constraints.slopes(x) * problem.box.unit
        self.above, self.below = constraints.upper - values, values - constraints.lower
        self.equations = constraints.lower == constraints.upper

    def active(self) -> tuple[Integers, Integers, Integers]:
        """Return the indices of components at upper bounds, at lower bounds, and of equality
        constraints.
        """
        margin = ACTIVE * np.maximum(1.0, np.linalg.norm(self.gradients, axis=1))
        at_upper, at_lower = (
            np.flatnonzero((r <= margin) & ~self.equations) for r in (self.above, self.below)
        )
        return at_upper, at_lower, np.flatnonzero(self.equations)

    @property
    def violation(self) -> float:
        return _max_norm(np.minimum(np.append(self.above, self.below), 0))

    def complementarity(self, multipliers: Array) -> Array:
        """Return multipliers times the distance from the bound of their sign, (c,)."""
        box_slack = np.where(multipliers > 0, self.above, self.below)
        return np.multiply(
            multipliers, box_slack, out=np.zeros_like(multipliers), where=multipliers != 0
        )


@dataclass(frozen=True)
class ActiveBound(Record):
    """A bound with its multiplier: decrease of the objective per unit of the box if the bound is
    relaxed.
    """

    name: str
    side: str
    multiplier: float


def find_active_bounds(problem: Problem, multipliers: Multipliers) -> list[ActiveBound]:
    """Return the active bounds with a positive multiplier, in the order of the design."""
    limit = ACTIVE * problem.scale
    return [
        ActiveBound(name, side, float(values[j]))
        for j, name in enumerate(problem.box.names)
        for side, values in (("lower", multipliers.at_lower), ("upper", multipliers.at_upper))
        if values[j] > limit
    ]


@dataclass(frozen=True)
class ActiveConstraint(Record):
    """An active limit or requirement: decrease of the objective per `unit` if it is relaxed."""

    name: str
    side: str
    multiplier: float
    unit: str


def find_active_constraints(
    problem: Problem, u: Array, multipliers: Multipliers
) -> list[ActiveConstraint]:
    """Return the constraints that are active at a point, in the order of their kinds, with summed
    multipliers.
    """
    if problem.constraints is None:
        return []
    constraints = problem.constraints.at(problem.design(u))
    owner, active = constraints.owner, []
    for k, kind in enumerate(constraints.kinds):
        size = float(np.abs(multipliers.required[owner == k]).sum())
        if size > ACTIVE * problem.scale:
            side = (
                kind.sides[0]
                if len(kind.sides) == 1
                else _name_side(multipliers.required[owner == k])
            )
            active.append(ActiveConstraint(kind.name, side, size / kind.step, kind.unit))
    return active


def _name_side(multipliers: Array) -> str:
    return "max" if multipliers.sum() > 0 else "min"


def kkt_residual(problem: Problem, u: Array) -> float:
    """Return the dimensionless residual at a point u (p,) with its best multipliers, below 1e-6 at
    an optimum.
    """
    return check_conditions(problem, u, estimate_multipliers(problem, u)).worst


def _scatter(values: Array, places: Integers, size: int) -> Array:
    full = np.zeros(size)
    full[places] = values
    return full


def _max_norm(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
