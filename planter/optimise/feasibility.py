"""The least violation: which constraint has to give way, by how much, so that all the others are kept.

Over z = (u, s), s >= 0 one for each kind of constraint in its steps:

    minimise  sum s + WEIGHT/2 |u - start|^2   subject to  lower - s <= rows(u) <= upper + s,  u in the box.

The sum has few terms at its minimum. Where more than one remains, each is tried alone with the others kept. Kinds that
may not give way have no s.

Is there a point that keeps all constraints? If not, the nearest to it: which ones give way, by how much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise import ipopt
from planter.optimise.constraints import FEASIBILITY_TOLERANCE, Constraints
from planter.optimise.problem import Problem

DISTANCE_WEIGHT = 1e-5
"""Of the distance from the start: it only makes the point unique."""
VIOLATION_ROUNDING = 1e-6
"""Violations below this many steps are rounding of the solver."""
MAX_ELASTIC_ITERATIONS = 80


class ElasticProgram:
    """A `Programme` for `planter.optimise.ipopt`; `giving` (kinds,) says which may give way."""

    def __init__(self, problem: Problem, constraints: Constraints, start: Array, giving: Flags) -> None:
        self.problem, self.constraints, self.u = problem, constraints, start
        self.p, self.kinds = len(start), len(giving)
        owner = np.eye(self.kinds)[constraints.owner]
        self.held = constraints.even & ~giving[constraints.owner]
        self.below, self.above = (np.isfinite(b) & ~self.held for b in (constraints.lower, constraints.upper))
        equations = np.zeros((int(self.held.sum()), self.kinds))
        self.owner = np.vstack([owner[self.above], owner[self.below], equations])
        count = len(self.owner)
        self.lower = np.append(problem.box.bottom, np.zeros(self.kinds))
        self.upper = np.append(problem.box.top, np.where(giving, np.inf, 0.0))
        self.g_lower, self.g_upper = np.full(count, -np.inf), np.zeros(count)
        self.g_lower[count - len(equations) :] = 0.0
        self.start = np.append(start, np.where(giving, constraints.excess(problem.design(start)), 0.0))

    def _x(self, z: Array) -> Array:
        return self.problem.design(z[: self.p])

    def f(self, z: Array) -> float:
        """Return the objective at z (n,)."""
        return float(z[self.p :].sum() + DISTANCE_WEIGHT / 2 * ((z[: self.p] - self.u) ** 2).sum())

    def gradient(self, z: Array) -> Array:
        """Return the gradient (n,) of the objective at z (n,)."""
        return np.append(DISTANCE_WEIGHT * (z[: self.p] - self.u), np.ones(self.kinds))

    def g(self, z: Array) -> Array:
        """Return the constraints (m,) at z (n,)."""
        c = self.constraints
        try:
            rows = c.values(self._x(z))
        except ComputationError:
            rows = np.full(c.count, np.nan)
        beyond = [(rows - c.upper)[self.above], (c.lower - rows)[self.below], (rows - c.upper)[self.held]]
        found: Array = np.concatenate(beyond) - self.owner @ z[self.p :]
        return found

    def jacobian(self, z: Array) -> Array:
        """Return the Jacobian (m, n) of g at z (n,)."""
        slopes = self.constraints.slopes(self._x(z)) * self.problem.box.unit
        return np.hstack([np.vstack([slopes[self.above], -slopes[self.below], slopes[self.held]]), -self.owner])

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        """Return the Hessian (n, n) of weight * f + multipliers . g at z (n,)."""
        weights = np.zeros(self.constraints.count)
        above, below, held = np.split(multipliers, np.cumsum([self.above.sum(), self.below.sum()]))
        weights[self.above] += above
        weights[self.below] -= below
        weights[self.held] += held
        width = self.problem.box.unit
        total = np.zeros((len(z), len(z)))
        bent = self.constraints.curvature(self._x(z), weights) * np.outer(width, width)
        total[: self.p, : self.p] = bent + weight * DISTANCE_WEIGHT * np.eye(self.p)
        return total


@dataclass(frozen=True)
class ViolationMinimum:
    """A point u (p,) and by how many steps each kind is violated there, (kinds,); all 0 where all are kept.

    `stationary` says whether the violation is least there to first order, rather than where the search was cut short.
    """

    u: Array
    excess: Array
    stationary: bool

    @property
    def total(self) -> float:
        return float(self.excess.sum())

    @property
    def kept(self) -> bool:
        return float(self.excess.max()) <= FEASIBILITY_TOLERANCE


def minimise_violation(problem: Problem, constraints: Constraints, start: Array) -> ViolationMinimum:
    """The least violation reached from a point u (p,), of one kind alone if that can be."""
    kinds = np.arange(len(constraints.kinds))
    found = _solve_elastic(problem, constraints, start, constraints.giving)
    broken = np.flatnonzero((found.excess > VIOLATION_ROUNDING) & constraints.giving)
    if len(broken) < 2:
        return found
    alone = [_solve_elastic(problem, constraints, found.u, kinds == k) for k in broken]
    single = [one for one, k in zip(alone, broken, strict=True) if np.delete(one.excess, k).max() <= VIOLATION_ROUNDING]
    return min(single, key=lambda one: one.total, default=found)


def _solve_elastic(problem: Problem, constraints: Constraints, start: Array, giving: Flags) -> ViolationMinimum:
    programme = ElasticProgram(problem, constraints, start, giving)
    solution = ipopt.solve_program(programme, programme.start, MAX_ELASTIC_ITERATIONS)
    u = problem.box.inside(solution.z[: len(start)])
    try:
        return ViolationMinimum(u, constraints.excess(problem.design(u)), solution.converged)
    except ComputationError:
        return ViolationMinimum(start, constraints.excess(problem.design(start)), stationary=False)


MAX_ELASTIC_STARTS = 2
"""How many points the least violation is looked for from."""


def find_feasible_or_nearest(problem: Problem, constraints: Constraints, starts: Sequence[Array]) -> ViolationMinimum:
    """A point that keeps all constraints, looked for from those of `starts` with the least violation.

    Where there is none, `kept` is False and the least violation that was found is told.
    """
    found: list[ViolationMinimum] = []
    for start in sorted(map(problem.onto, starts), key=problem.violation)[:MAX_ELASTIC_STARTS]:
        found.append(minimise_violation(problem, constraints, start))
        if found[-1].kept:
            return found[-1]
    return select_smallest_violation(found)


def select_smallest_violation(found: Sequence[ViolationMinimum]) -> ViolationMinimum:
    """The least of several violations, fewest kinds of constraints first."""
    return min(found, key=lambda least: (int((least.excess > FEASIBILITY_TOLERANCE).sum()), least.total))
