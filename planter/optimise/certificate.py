"""Is a point optimal? Karush, Kuhn and Tucker's conditions of a minimax problem in a box, checked without a solver.

The objective is weight (max f - min f) + s, with rows f and s what it makes of a smooth function. At a local minimum u
in the box there are shares mu >= 0 of the rows that attain the maximum, nu >= 0 of those that attain the minimum,
summing to the weight each, multipliers of the bounds z_lower, z_upper >= 0, and theta in [0, 1] for each sample that
sits on a joint, with

    s_u + kinks' theta + upper_u' mu - lower_u' nu - z_lower + z_upper = 0,
    mu (max f - f) = 0,  nu (f - min f) = 0,  z_lower (u - bottom) = 0,  z_upper (top - u) = 0.

A sample on a joint has two one-sided gradients; it stands in the rows with both, and theta mixes those of its share
in the variance: zero lies in the sum of Clarke's subdifferentials (Clarke, Optimization and Nonsmooth Analysis, 1983,
2.3). Where nothing sits on a joint this is the usual KKT point of the epigraph form, without rows that of a smooth
programme. Constraints lower <= g(u) <= upper add g_u' lambda, lambda > 0 only at an upper and < 0 only at a lower
bound; an equation's may have either sign.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import lsq_linear

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.problem import Problem

ACTIVE = 1e-6
"""Rows this close to an extreme, as a share of the range, may carry multipliers, and bounds in the box's unit.

Constraints may that are this close to their bounds in steps, or to first order in the box's unit.
"""


@dataclass(frozen=True)
class Multipliers:
    """Multipliers at a point, in the objective's unit per that of the rows and per the box's unit (bounds).

    `upper` (a,), `lower` (b,): of the rows of `Conditions`; `at_lower`, `at_upper` (p,): of the bounds; `kinks` (k,);
    `required` (c,): of the constraints, per step, with the sign of the side.
    """

    upper: Array
    lower: Array
    at_lower: Array
    at_upper: Array
    kinks: Array
    required: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class Residuals:
    """By how much each condition is violated; dimensionless, the problem's scale being 1."""

    stationarity: float
    shares: float
    feasibility: float
    sign: float
    complementarity: float

    @property
    def worst(self) -> float:
        return max(self.stationarity, self.shares, self.feasibility, self.sign, self.complementarity)


def check_conditions(problem: Problem, u: Array, multipliers: Multipliers) -> Residuals:
    """How far a point u (p,) with these multipliers is from satisfying the conditions. Knows no solver."""
    found, m = problem.conditions(u), multipliers
    rate, weight, rows = _smooth_rate(problem, u), problem.objective.weight, len(found.upper) > 0
    slope = (
        rate * (found.smooth + found.kinks.T @ m.kinks)
        + found.upper_gradients.T @ m.upper
        - found.lower_gradients.T @ m.lower
        - m.at_lower
        + m.at_upper
    )
    required = _ConstraintState(problem, u)
    slope = slope + required.gradients.T @ m.required
    unit = problem.reference.look.range / problem.scale if rows else 1.0
    signed = np.concatenate([m.upper, m.lower]) * unit
    shares = np.array([m.upper.sum() - weight, m.lower.sum() - weight]) if rows else np.empty(0)
    bounds = np.concatenate([m.at_lower, m.at_upper]) / problem.scale
    top, bottom = found.upper.max(initial=-np.inf), found.lower.min(initial=np.inf)
    slack = np.concatenate([top - found.upper, found.lower - bottom]) / problem.scale
    room = np.concatenate(problem.box.room(u))
    return Residuals(
        stationarity=_max_norm(slope) / problem.scale,
        shares=_max_norm(shares) * unit,
        feasibility=max(_max_norm(np.minimum(room, 0)), required.violation),
        sign=_max_norm(np.minimum(np.concatenate([signed, bounds, m.kinks, 1 - m.kinks]), 0)),
        complementarity=max(
            _max_norm(np.concatenate([m.upper, m.lower]) * slack),
            _max_norm(bounds * room),
            _max_norm(required.complementarity(m.required) / problem.scale),
        ),
    )


def estimate_multipliers(problem: Problem, u: Array) -> Multipliers:
    """The multipliers that come nearest to satisfying the conditions at a point, by bounded least squares.

    Only rows and bounds that are active within `ACTIVE` get any; signs are exact, the rest is least squares.
    """
    found, scale = problem.conditions(u), problem.scale
    rate, weight = _smooth_rate(problem, u), problem.objective.weight
    tops, bottoms = _find_extreme_rows(found.upper, found.lower)
    low, high = (np.flatnonzero(room <= ACTIVE) for room in problem.box.room(u))
    eye, required = np.eye(len(u)), _ConstraintState(problem, u)
    up, down, even = required.active()
    rows = required.gradients
    blocks = [weight * found.upper_gradients[tops].T, -weight * found.lower_gradients[bottoms].T, rate * found.kinks.T,
              -scale * eye[:, low], scale * eye[:, high],
              scale * rows[up].T, -scale * rows[down].T, scale * rows[even].T]  # fmt: skip
    sizes = [block.shape[1] for block in blocks]
    sums = scale * np.repeat(np.eye(8)[: 2 if len(tops) else 0], sizes, axis=1)
    matrix = np.vstack([np.hstack(blocks), sums])
    target = np.append(-rate * found.smooth, np.full(len(sums), scale))
    least = np.repeat([*[0.0] * 7, -np.inf], sizes)
    most = np.repeat([np.inf, np.inf, 1.0, *[np.inf] * 5], sizes)
    solved = lsq_linear(matrix, target, (least, most), method="bvls", tol=1e-15).x if sum(sizes) else np.empty(0)
    mu, nu, theta, below, above, over, under, free = np.split(solved, np.cumsum(sizes)[:-1])
    count = len(rows)
    return Multipliers(
        upper=_scatter(weight * mu, tops, len(found.upper)),
        lower=_scatter(weight * nu, bottoms, len(found.lower)),
        at_lower=_scatter(scale * below, low, len(u)),
        at_upper=_scatter(scale * above, high, len(u)),
        kinks=theta,
        required=scale * (_scatter(over, up, count) - _scatter(under, down, count) + _scatter(free, even, count)),
    )


def _find_extreme_rows(upper: Array, lower: Array) -> tuple[Integers, Integers]:
    """Rows that attain the maximum and rows that attain the minimum."""
    if not len(upper):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    margin = ACTIVE * max(upper.max() - lower.min(), np.finfo(float).tiny)
    return np.flatnonzero(upper >= upper.max() - margin), np.flatnonzero(lower <= lower.min() + margin)


class _ConstraintState:
    """The constraints at a point u (p,): gradients in u (c, p) and the room to either bound (c,), in steps."""

    def __init__(self, problem: Problem, u: Array) -> None:
        constraints, x = problem.constraints, problem.design(u)
        if constraints is None:
            self.gradients, self.above, self.below = np.empty((0, len(u))), np.empty(0), np.empty(0)
            self.equations = np.empty(0, dtype=bool)
            return
        values = constraints.values(x)
        self.gradients = constraints.slopes(x) * problem.box.unit
        self.above, self.below = constraints.upper - values, values - constraints.lower
        self.equations = constraints.lower == constraints.upper

    def active(self) -> tuple[Integers, Integers, Integers]:
        """Rows at their upper bounds, rows at their lower ones, and equations."""
        near = ACTIVE * np.maximum(1.0, np.linalg.norm(self.gradients, axis=1))
        at_upper, at_lower = (np.flatnonzero((r <= near) & ~self.equations) for r in (self.above, self.below))
        return at_upper, at_lower, np.flatnonzero(self.equations)

    @property
    def violation(self) -> float:
        return _max_norm(np.minimum(np.append(self.above, self.below), 0))

    def complementarity(self, multipliers: Array) -> Array:
        """Multipliers times the room to the side that their sign says, (c,)."""
        room = np.where(multipliers > 0, self.above, self.below)
        return np.multiply(multipliers, room, out=np.zeros_like(multipliers), where=multipliers != 0)


@dataclass(frozen=True)
class ActiveBound:
    """A bound with a positive multiplier: what the objective would lose per unit of the box if the bound gave way."""

    name: str
    side: str
    multiplier: float


def find_active_bounds(problem: Problem, multipliers: Multipliers) -> list[ActiveBound]:
    """Bounds that hold the optimum, in the order of the design."""
    limit = ACTIVE * problem.scale
    return [
        ActiveBound(name, side, float(values[j]))
        for j, name in enumerate(problem.box.names)
        for side, values in (("lower", multipliers.at_lower), ("upper", multipliers.at_upper))
        if values[j] > limit
    ]


@dataclass(frozen=True)
class ActiveConstraint:
    """A constraint that holds the optimum: what the objective loses per unit of it if its limit gave way."""

    name: str
    side: str
    multiplier: float
    unit: str


def find_active_constraints(problem: Problem, multipliers: Multipliers) -> list[ActiveConstraint]:
    """Constraints with a multiplier, in the order of their kinds; several rows of one add up."""
    if problem.constraints is None:
        return []
    owner, found = problem.constraints.owner, []
    for k, kind in enumerate(problem.constraints.kinds):
        size = float(np.abs(multipliers.required[owner == k]).sum())
        if size > ACTIVE * problem.scale:
            side = kind.sides[0] if len(kind.sides) == 1 else _name_side(multipliers.required[owner == k])
            found.append(ActiveConstraint(kind.name, side, size / kind.step, kind.unit))
    return found


def _name_side(multipliers: Array) -> str:
    return "max" if multipliers.sum() > 0 else "min"


def kkt_residual(problem: Problem, u: Array) -> float:
    """The residual at a point with its best multipliers: below 1e-6 at an optimum. Dimensionless."""
    return check_conditions(problem, u, estimate_multipliers(problem, u)).worst


def _smooth_rate(problem: Problem, u: Array) -> float:
    return problem.objective.outer(problem.objective.look(problem.design(u)).smooth)[1]


def _scatter(values: Array, places: Integers, size: int) -> Array:
    full = np.zeros(size)
    full[places] = values
    return full


def _max_norm(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
