"""Feasible points, or else the smallest violation: which constraints to relax, and by how much.

The elastic programme over z = (u, s) has a slack s >= 0 in steps for each kind of constraint:

    minimise  sum s + WEIGHT/2 |u - start|^2   subject to  lower - s <= rows(u) <= upper + s,  u in
    the box.

The sum has few terms at its minimum. If more than one remains, each is relaxed alone with the
others satisfied. Kinds that are not relaxable have no slack. Where only a feasible point is asked
for, the first iterate that is one ends the programme.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.engine.solvers import ipopt
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE, Constraints
from planter.engine.solvers.problem import Problem
from planter.errors import ComputationError
from planter.kernels import Array, Flags

DISTANCE_WEIGHT = 1e-5
"""Weight of the distance from the start, which only makes the point unique."""
VIOLATION_ROUNDING = 1e-6
"""Violations below this many steps are attributed to rounding."""
MAX_ELASTIC_ITERATIONS, MAX_ROW_ROUNDS = 80, 10


class FeasibleIterate(Exception):
    """A point u (p,) of a programme under way that satisfies all constraints."""

    def __init__(self, u: Array) -> None:
        super().__init__()
        self.u = u


class ElasticProgram:
    """Elastic `NonlinearProgram`; `giving` (kinds,) flags the relaxable kinds.

    If it `stops`, its constraints raise FeasibleIterate at the first feasible point.
    """

    def __init__(
        self,
        problem: Problem,
        constraints: Constraints,
        start: Array,
        giving: Flags,
        stops: bool = False,
    ) -> None:
        self._true, self._stops = constraints, stops
        constraints = constraints.at(problem.design(start))
        self.problem, self.constraints, self.u = problem, constraints, start
        self.p, self.kinds = len(start), len(giving)
        owner = np.eye(self.kinds)[constraints.owner]
        self.fixed = constraints.even & ~giving[constraints.owner]
        self.below, self.above = (
            np.isfinite(b) & ~self.fixed for b in (constraints.lower, constraints.upper)
        )
        equations = np.zeros((int(self.fixed.sum()), self.kinds))
        self.owner = np.vstack([owner[self.above], owner[self.below], equations])
        count = len(self.owner)
        self.lower = np.append(problem.box.bottom, np.zeros(self.kinds))
        self.upper = np.append(problem.box.top, np.where(giving, np.inf, 0.0))
        self.g_lower, self.g_upper = np.full(count, -np.inf), np.zeros(count)
        self.g_lower[count - len(equations) :] = 0.0
        self.start = np.append(
            start, np.where(giving, constraints.excess(problem.design(start)), 0.0)
        )

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
            excess = np.maximum(rows - c.upper, c.lower - rows)
            u, worst = self.problem.box.inside(z[: self.p]), int(excess.argmax())
            violation = max(float(excess[worst]), 0.0)
            self.problem.record_violation(u, violation, c.kinds[c.owner[worst]].name)
            is_feasible = violation <= FEASIBILITY_TOLERANCE and self._stops
            if is_feasible and self._true.violation(self._x(u)) <= FEASIBILITY_TOLERANCE:
                raise FeasibleIterate(u)
        except ComputationError:
            rows = np.full(c.count, np.nan)
        beyond = [
            (rows - c.upper)[self.above],
            (c.lower - rows)[self.below],
            (rows - c.upper)[self.fixed],
        ]
        violations: Array = np.concatenate(beyond) - self.owner @ z[self.p :]
        return violations

    def jacobian(self, z: Array) -> Array:
        """Return the Jacobian (m, n) of g at z (n,)."""
        slopes = self.constraints.slopes(self._x(z)) * self.problem.box.unit
        return np.hstack(
            [np.vstack([slopes[self.above], -slopes[self.below], slopes[self.fixed]]), -self.owner]
        )

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        """Return the Hessian (n, n) of weight * f + multipliers . g at z (n,)."""
        weights = np.zeros(self.constraints.count)
        above, below, fixed = np.split(multipliers, np.cumsum([self.above.sum(), self.below.sum()]))
        weights[self.above] += above
        weights[self.below] -= below
        weights[self.fixed] += fixed
        width = self.problem.box.unit
        total = np.zeros((len(z), len(z)))
        curvature = self.constraints.curvature(self._x(z), weights) * np.outer(width, width)
        total[: self.p, : self.p] = curvature + weight * DISTANCE_WEIGHT * np.eye(self.p)
        return total


@dataclass(frozen=True)
class ViolationMinimum:
    """A point u (p,) and the violation `excess` (kinds,) of each kind there, in steps.

    `stationary` is true if the violation is minimal to first order, false if the search stopped
    before.
    """

    u: Array
    excess: Array
    stationary: bool

    @property
    def total(self) -> float:
        return float(self.excess.sum())

    @property
    def is_feasible(self) -> bool:
        return float(self.excess.max(initial=0.0)) <= FEASIBILITY_TOLERANCE


def minimise_violation(
    problem: Problem, constraints: Constraints, start: Array
) -> ViolationMinimum:
    """Return the smallest violation reached from a point u (p,), of a single kind if possible."""
    return relax_single_kind(problem, constraints, approach_limits(problem, constraints, start))


def approach_limits(
    problem: Problem, constraints: Constraints, start: Array, stops: bool = False
) -> ViolationMinimum:
    """Return the smallest sum of violations reached from a point u (p,), or, if the search
    `stops`, the first feasible point on the way there.
    """
    try:
        minimum = _solve_elastic(problem, constraints, start, constraints.giving, stops)
        for _ in range(
            MAX_ROW_ROUNDS if constraints.windows else 0
        ):  # rows near a start are not those near the end
            if minimum.is_feasible:
                break
            following = _solve_elastic(problem, constraints, minimum.u, constraints.giving, stops)
            if following.total >= minimum.total * (1 - VIOLATION_ROUNDING):
                break
            minimum = following
    except FeasibleIterate as end:
        return ViolationMinimum(end.u, np.zeros(len(constraints.kinds)), stationary=True)
    return minimum


def relax_single_kind(
    problem: Problem, constraints: Constraints, minimum: ViolationMinimum
) -> ViolationMinimum:
    """Return the smallest violation of a single kind near one of several, or that one if no single
    kind suffices.
    """
    kinds = np.arange(len(constraints.kinds))
    broken = np.flatnonzero((minimum.excess > VIOLATION_ROUNDING) & constraints.giving)
    if len(broken) < 2:
        return minimum
    alone = [_solve_elastic(problem, constraints, minimum.u, kinds == k) for k in broken]
    single = [
        end
        for end, k in zip(alone, broken, strict=True)
        if np.delete(end.excess, k).max() <= VIOLATION_ROUNDING
    ]
    return min(single, key=lambda end: end.total, default=minimum)


def _solve_elastic(
    problem: Problem, constraints: Constraints, start: Array, giving: Flags, stops: bool = False
) -> ViolationMinimum:
    programme = ElasticProgram(problem, constraints, start, giving, stops)
    solution = ipopt.solve_program(programme, programme.start, MAX_ELASTIC_ITERATIONS)
    u = problem.box.inside(solution.z[: len(start)])
    try:
        return ViolationMinimum(u, constraints.excess(problem.design(u)), solution.converged)
    except ComputationError:
        return ViolationMinimum(start, constraints.excess(problem.design(start)), stationary=False)


MAX_ELASTIC_STARTS = 2
"""Maximum number of starts of the search for a feasible point."""


def find_feasible_or_nearest(
    problem: Problem, constraints: Constraints, starts: Sequence[Array]
) -> ViolationMinimum:
    """Return a feasible point, searched from the `starts` (p,) with the smallest violation.

    If none is found, return the point with the smallest violation.
    """
    minima: list[ViolationMinimum] = []
    for start in sorted(map(problem.onto, starts), key=problem.violation)[:MAX_ELASTIC_STARTS]:
        minima.append(minimise_violation(problem, constraints, start))
        if minima[-1].is_feasible:
            return minima[-1]
    return select_smallest_violation(minima)


def select_smallest_violation(minima: Sequence[ViolationMinimum]) -> ViolationMinimum:
    """Return the smallest of several violations: the fewest violated kinds, then the smallest
    total.
    """
    return min(
        minima,
        key=lambda minimum: (int((minimum.excess > FEASIBILITY_TOLERANCE).sum()), minimum.total),
    )
