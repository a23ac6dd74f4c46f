"""Local minimisation by sequential quadratic programming, with the components rebuilt at every
point.

The components at a point u are all extremes of the curve and the constraints. Each step solves,
over d, t_max, t_min and one slack s >= 0,

    minimise  gradient . (d, t) + d' H d / 2 + penalty s subject to  extremes to first order <=
    t_max, >= t_min,  constraints to first order within s of their bounds, u + d in the box,  |d| <=
    radius,

where H is the Hessian of the Lagrangian, made convex without changing the steps which the active
components allow (Nocedal and Wright, Numerical Optimization, 2006, 18.4 and 18.5). A step is judged
by the true objective plus the penalty on the worst violation, so that extremes which the model
misses are accounted for. If the curvature of the active components spoils a step, the step is
corrected to second order; if that fails too, the radius shrinks. Active- set steps run along the
corners of a maximum, where an interior point method converges slowly.

The quadratic programmes are solved by DAQP, a dual active-set method that comes with CasADi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.epigraph import Epigraph
from planter.engine.solvers.objective import BreakpointHold
from planter.engine.solvers.problem import Problem
from planter.errors import ComputationError
from planter.kernels import Array

MAX_ITERATIONS = 100
RADIUS, MAX_RADIUS, MIN_RADIUS = 0.1, 0.5, 1e-11
"""Largest step in any coordinate, in units of the box: initial, maximum, and the value that ends
the search.
"""
GOOD, POOR, ACCEPTED, GROWTH = 0.75, 0.25, 0.05, 2.5
"""Shares of the predicted decrease above which the radius grows, below which it shrinks, above
which a step is accepted; and the growth factor of the radius.
"""
NOISE, MAX_NOISE_STEPS = 1e-12, 2
"""Predicted decrease hidden by rounding, in units of the scale, and the number of such steps before
the end.
"""
ROUNDING = 1e-12
"""Coordinates closer to a bound than this are set onto it, in units of the box."""
PENALTY, PENALTY_GROWTH, MAX_PENALTY = 1.0, 4.0, 1e6
"""Penalty on the worst violation in steps: initial value, growth factor while it is too small, and
maximum.
"""
MIN_CURVATURE = 1e-9
"""Smallest curvature of a model, as a share of its largest."""
MULTIPLIER_TOLERANCE, RANK_TOLERANCE = 1e-7, 1e-9
"""Multipliers above the first mark active components; singular values below the second, as a share
of the largest, count as 0."""


@dataclass(frozen=True)
class SqpResult:
    """The last point u (p,) of a search, the number of iterations, and whether no step predicted a
    decrease.
    """

    u: Array
    iterations: int
    converged: bool


def minimise_by_sqp(
    problem: Problem,
    start: Array,
    holds: Sequence[BreakpointHold] = (),
    most_iterations: int = MAX_ITERATIONS,
) -> SqpResult:
    """Return the local minimum reached from a point u (p,), with the breakpoints constrained by
    `holds`.
    """
    return _SqpSearch(problem, holds).run(problem.box.inside(start), most_iterations)


class _Point:
    """The programme at a point u (p,), to first order.

    Raises ComputationError if the objective or a constraint is not finite.
    """

    def __init__(self, problem: Problem, u: Array, holds: Sequence[BreakpointHold]) -> None:
        self.u, self.problem = u, problem
        self.programme = Epigraph(problem, problem.local(u, holds), u)
        self.z = self.programme.start
        self.f, self.g = self.programme.f(self.z), self.programme.g(self.z)
        if not (np.isfinite(self.f) and np.isfinite(self.g).all()):
            raise ComputationError("the objective, or a constraint, is not finite at this design")

    @property
    def n(self) -> int:
        return self.programme.n

    @cached_property
    def gradient(self) -> Array:
        return self.programme.gradient(self.z)

    @cached_property
    def jacobian(self) -> Array:
        return self.programme.jacobian(self.z)

    @property
    def required(self) -> Array:
        """1 for constraints, which may be violated at a penalty, and 0 for components of the
        epigraph, (m,).
        """
        return (np.arange(len(self.g)) >= self.programme.rows).astype(float)

    @property
    def violation(self) -> float:
        beyond = np.maximum(self.programme.g_lower - self.g, self.g - self.programme.g_upper)
        return float((beyond * self.required).max(initial=0.0))

    def merit(self, penalty: float) -> float:
        return self.f + penalty * self.violation

    def curvature(self, multipliers: Array) -> Array:
        """Hessian of the Lagrangian in the free coordinates, (n, n)."""
        return self.programme.hessian(self.z, 1.0, multipliers)[: self.n, : self.n]


@dataclass(frozen=True)
class _Step:
    """A step in the free coordinates d (n,) and t, the predicted decrease, and multipliers of
    components and bounds.
    """

    move: Array
    fall: float
    rows: Array
    bounds: Array


class _SqpSearch:
    """A search with the radius of its steps and the penalty on violations as state."""

    def __init__(self, problem: Problem, holds: Sequence[BreakpointHold]) -> None:
        self.problem, self.holds = problem, holds
        self.radius, self.penalty = RADIUS, PENALTY

    def run(self, start: Array, most_iterations: int) -> SqpResult:
        point, last = _Point(self.problem, start, self.holds), 0
        model = np.eye(point.n)
        for iteration in range(most_iterations):
            first = self._solve_step(point, model, point.g)
            if first is None:
                return SqpResult(point.u, iteration, False)
            self._reprice(point, first)
            model = _convexify(point.curvature(first.rows), _find_normals(point, first))
            following, fall = self._advance(point, model)
            small = self._is_noise(fall)
            is_stuck = small or following is None
            if is_stuck and point.violation > FEASIBILITY_TOLERANCE and self.penalty < MAX_PENALTY:
                self.penalty *= PENALTY_GROWTH
                self.radius = self.radius if small else RADIUS
                continue
            last += small
            if following is None or last == MAX_NOISE_STEPS:
                return SqpResult((following or point).u, iteration + 1, small)
            point = following
        return SqpResult(point.u, most_iterations, False)

    def _reprice(self, point: _Point, step: _Step) -> None:
        """Raise the penalty if the multipliers of the constraints reach it."""
        if point.required.any() and np.abs(step.rows) @ point.required >= 0.99 * self.penalty:
            self.penalty = min(PENALTY_GROWTH * self.penalty, MAX_PENALTY)

    def _solve_step(self, point: _Point, model: Array, g: Array) -> _Step | None:
        """Return the step of a model with Hessian (n, n) and components g (m,), or None if its
        programme fails.
        """
        n, programme, price = point.n, point.programme, point.required
        size, slack = len(point.z), int(price.any())
        hessian, slope = (
            np.zeros((size + slack, size + slack)),
            np.append(point.gradient, np.full(slack, self.penalty)),
        )
        hessian[:n, :n] = model
        above, below = (
            np.flatnonzero(np.isfinite(b)) for b in (programme.g_upper, programme.g_lower)
        )
        give = -np.append(price[above], price[below])[:, None]
        rows = np.hstack(
            [np.vstack([point.jacobian[above], -point.jacobian[below]]), give[:, :slack]]
        )
        limits = np.append(programme.g_upper[above] - g[above], g[below] - programme.g_lower[below])
        low, high = np.full(size + slack, -np.inf), np.full(size + slack, np.inf)
        low[:n] = np.maximum(programme.lower[:n] - point.z[:n], -self.radius)
        high[:n] = np.minimum(programme.upper[:n] - point.z[:n], self.radius)
        low[size:] = 0.0
        solution = solve_quadratic_program(hessian, slope, rows, limits, (low, high))
        if solution is None:
            return None
        multipliers = np.zeros(len(g))
        multipliers[above] += solution.rows[: len(above)]
        multipliers[below] -= solution.rows[len(above) :]
        cost = slope @ solution.z + solution.z[:n] @ model @ solution.z[:n] / 2
        fall = self.penalty * point.violation - float(cost)
        return _Step(solution.z[:size], fall, multipliers, solution.bounds[:n])

    def _advance(self, point: _Point, model: Array) -> tuple[_Point | None, float]:
        """Return the next point, or None if no radius yields one, and the predicted decrease."""
        fall = 0.0
        while self.radius > MIN_RADIUS:
            step = self._solve_step(point, model, point.g)
            if step is None:
                return None, np.inf
            fall = step.fall
            trial, share = self._try_step(point, model, step)
            length = float(np.abs(step.move[: point.n]).max(initial=0.0))
            if trial is not None and (share > ACCEPTED or self._is_noise(fall)):
                self._resize(share, length, fall)
                return trial, fall
            self.radius = min(self.radius, length) / 3
        return None, fall

    def _is_noise(self, fall: float) -> bool:
        """Return whether a predicted decrease is below rounding."""
        return fall <= NOISE * max(self.penalty, 1.0)

    def _resize(self, share: float, length: float, fall: float) -> None:
        """Enlarge the radius if the model is accurate up to an accepted step; shrink it if the
        model is poor.
        """
        if share > GOOD and length > 0.9 * self.radius:
            self.radius = min(GROWTH * self.radius, MAX_RADIUS)
        elif share < POOR and not self._is_noise(fall):
            self.radius = max(self.radius, length) / 2

    def _try_step(self, point: _Point, model: Array, step: _Step) -> tuple[_Point | None, float]:
        """Return the point after a step, corrected if better, and the achieved share of the
        predicted decrease.
        """
        trial = self._move_point(point, step.move)
        share = self._compute_share(point, trial, step.fall)
        if trial is None or share >= POOR or self._is_noise(step.fall):
            return trial, share
        corrected = self._correct_step(point, model, step, trial)
        if corrected is None or corrected.merit(self.penalty) >= trial.merit(self.penalty):
            return trial, share
        return corrected, self._compute_share(point, corrected, step.fall)

    def _move_point(self, point: _Point, move: Array) -> _Point | None:
        z = point.z.copy()
        z[: point.n] += move[: point.n]
        try:
            u = self.problem.onto(self.problem.box.inside(point.programme.point(z)))
            return _Point(self.problem, self.problem.box.snapped(u, ROUNDING), self.holds)
        except ComputationError:
            return None

    def _compute_share(self, point: _Point, trial: _Point | None, fall: float) -> float:
        """Return the share of the predicted decrease that a trial achieves."""
        if trial is None or fall <= 0:
            return -np.inf
        return (point.merit(self.penalty) - trial.merit(self.penalty)) / fall

    def _correct_step(
        self, point: _Point, model: Array, step: _Step, trial: _Point
    ) -> _Point | None:
        """Return the point after a second-order correction, whose programme uses the components at
        the trial.
        """
        z = point.z + step.move
        z[: point.n] = trial.z[: point.n]
        g = point.programme.g(z)
        again = (
            self._solve_step(point, model, g - point.jacobian @ step.move)
            if np.isfinite(g).all()
            else None
        )
        return None if again is None else self._move_point(point, again.move)


def _find_normals(point: _Point, step: _Step) -> Array:
    """Return normals (k, n) of a step: active constraints, differences of active extremes of a
    side, active bounds.
    """
    n, programme = point.n, point.programme
    carrying = (np.abs(step.rows) > MULTIPLIER_TOLERANCE) | (programme.g_lower == programme.g_upper)
    active = np.flatnonzero(carrying[: programme.rows])
    groups = [
        point.jacobian[active[programme.groups[active] == group], :n]
        for group in range(programme.ends)
    ]
    differences = [group[1:] - group[:1] for group in groups]
    constraints = point.jacobian[programme.rows :, :n][carrying[programme.rows :]]
    low, high = point.z[:n] <= programme.lower[:n], point.z[:n] >= programme.upper[:n]
    is_fixed = (low & (step.bounds < -MULTIPLIER_TOLERANCE)) | (
        high & (step.bounds > MULTIPLIER_TOLERANCE)
    )
    return np.vstack([*differences, constraints, np.eye(n)[is_fixed]])


def _convexify(hessian: Array, normals: Array) -> Array:
    """Return a positive definite matrix (n, n) that leads to the same steps as a Hessian.

    The active components fix a step along the normals (k, n), so that curvature added there changes
    no step. In the orthogonal complement, negative curvature is replaced by its absolute value.
    """
    floor = MIN_CURVATURE * max(1.0, float(np.abs(hessian).max()))
    _, sizes, right = np.linalg.svd(normals)
    rank = int((sizes > RANK_TOLERANCE * sizes.max(initial=0.0)).sum())
    fixed, free = right[:rank].T, right[rank:].T
    total = hessian.copy()
    values, vectors = np.linalg.eigh(free.T @ hessian @ free)
    basis = free @ vectors
    total += (basis * (np.maximum(np.abs(values), floor) - values)) @ basis.T
    if rank:
        mixed, inner = fixed.T @ total @ free, free.T @ total @ free
        rest = fixed.T @ total @ fixed - mixed @ np.linalg.solve(inner, mixed.T)
        total += max(0.0, floor - float(np.linalg.eigvalsh(rest)[0])) * fixed @ fixed.T
    symmetric: Array = (total + total.T) / 2
    return symmetric


DAQP_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "daqp": {"eps_prox": 1e-4, "primal_tol": 1e-10, "dual_tol": 1e-12},
}
"""The proximal term makes a convex programme strictly convex; proximal iterations remove its
effect.
"""


@dataclass(frozen=True)
class QuadraticSolution:
    """A minimum: variables (n,), multipliers of the rows (m,) and of the bounds (n,), positive at
    upper bounds.
    """

    z: Array
    rows: Array
    bounds: Array


def solve_quadratic_program(
    hessian: Array, gradient: Array, rows: Array, limits: Array, bounds: tuple[Array, Array]
) -> QuadraticSolution | None:
    """Minimise gradient . z + z' hessian z / 2 with rows (m, n) . z <= limits (m,) and z (n,)
    within bounds.

    Returns None if the solver fails.
    """
    solver = _build_solver(len(gradient), len(limits))
    low, high = bounds
    unbounded = np.full(len(limits), -np.inf)
    solution = solver(h=hessian, g=gradient, a=rows, lba=unbounded, uba=limits, lbx=low, ubx=high)
    if not solver.stats()["success"]:
        return None
    z, row_multipliers, bound_multipliers = (
        np.asarray(solution[key], dtype=float)[:, 0] for key in ("x", "lam_a", "lam_x")
    )
    return QuadraticSolution(z, row_multipliers, bound_multipliers)


@cache
def _build_solver(size: int, rows: int) -> ca.Function:
    shapes = {"h": ca.Sparsity.dense(size, size), "a": ca.Sparsity.dense(rows, size)}
    return ca.conic("quadratic", "daqp", shapes, DAQP_OPTIONS)
