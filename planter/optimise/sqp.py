"""A local minimum of an objective with rows, by sequential quadratic programmes with rows made anew at every point.

At a point u the rows are all the extremes that there are, with the rows of the constraints; over steps d, t_max, t_min
and one slack s >= 0,

    minimise  objective's slope along (d, t) + d' H d / 2 + penalty s
    subject to  rows to first order <= t_max, >= t_min,  constraints to first order within s of their bounds,
                u + d in the box,  |d| <= radius,

H the Hessian of the Lagrangian, taken on where the active rows move and made convex where they hold still (Nocedal and
Wright, Numerical Optimization, 2006, 18.4 and 18.5). A step counts by what it does to the objective itself, with the
penalty on the worst violation: no row that is missed, or that has come to be, can deceive it. Where the active rows
bend too much for it, the step is corrected to second order; failing that the radius shrinks. An interior point method,
which has to leave all rows a distance, creeps along such corners; here they are what a step runs along.

Convex quadratic programmes of a few variables, by DAQP, a dual active-set method that comes with CasADi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise.constraints import FEASIBILITY_TOLERANCE
from planter.optimise.epigraph import Epigraph
from planter.optimise.objective import BreakpointHold
from planter.optimise.problem import Problem

MAX_ITERATIONS = 100
RADIUS, MAX_RADIUS, MIN_RADIUS = 0.1, 0.5, 1e-11
"""Of a step in any coordinate, in the box's unit: at first, at most, and where the search gives up."""
GOOD, POOR, ACCEPTED, GROWTH = 0.75, 0.25, 0.05, 2.5
"""Shares of the predicted fall at which the radius grows, it shrinks, the step is taken at all; and how it grows."""
NOISE, MAX_NOISE_STEPS = 1e-12, 3
"""Predicted falls that rounding hides, the problem's scale being 1, and how many such steps are taken."""
ROUNDING = 1e-12
"""Coordinates closer to their bounds are on them."""
PENALTY, PENALTY_GROWTH, MAX_PENALTY = 1.0, 4.0, 1e6
"""Of the worst violation in steps: at first, by what it grows where it holds the constraints back, and at most."""
MIN_CURVATURE = 1e-9
"""Least curvature of a model, as a share of its greatest."""
MULTIPLIER_TOLERANCE, RANK_TOLERANCE = 1e-7, 1e-9
"""Multipliers above the first belong to active rows; singular values below this share of the largest are none."""


@dataclass(frozen=True)
class SqpResult:
    """Where the search ended: a point u (p,), after how many iterations, and whether no step promised a fall."""

    u: Array
    iterations: int
    converged: bool


def minimise_by_sqp(
    problem: Problem, start: Array, holds: Sequence[BreakpointHold] = (), most_iterations: int = MAX_ITERATIONS
) -> SqpResult:
    """The local minimum reached from a point u (p,), joints held as told."""
    return _SqpSearch(problem, holds).run(problem.box.inside(start), most_iterations)


class _Point:
    """The programme at a point u (p,), to first order. Raises ComputationError where there is none."""

    def __init__(self, problem: Problem, u: Array, holds: Sequence[BreakpointHold]) -> None:
        self.u, self.problem = u, problem
        self.programme = Epigraph(problem, problem.local(u, holds), u)
        self.z = self.programme.start
        self.f, self.g = self.programme.f(self.z), self.programme.g(self.z)
        if not (np.isfinite(self.f) and np.isfinite(self.g).all()):
            raise ComputationError("the objective, or a constraint, is not finite here")

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
        """Which rows may give way, at a price: 1 for those of the constraints, 0 for those of the epigraph."""
        return (np.arange(len(self.g)) >= self.programme.a + self.programme.b).astype(float)

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
    """A step d (n,) in the free coordinates and t, the fall that the model predicts, multipliers of rows and bounds."""

    move: Array
    fall: float
    rows: Array
    bounds: Array


class _SqpSearch:
    """One search, with the radius of its steps and the price of a violation."""

    def __init__(self, problem: Problem, holds: Sequence[BreakpointHold]) -> None:
        self.problem, self.holds = problem, holds
        self.radius, self.penalty = RADIUS, PENALTY

    def run(self, start: Array, most_iterations: int) -> SqpResult:
        here, last = _Point(self.problem, start, self.holds), 0
        model = np.eye(here.n)
        for iteration in range(most_iterations):
            first = self._step(here, model, here.g)
            if first is None:
                return SqpResult(here.u, iteration, False)
            self._reprice(here, first)
            model = _convexify(here.curvature(first.rows), _find_normals(here, first))
            following, fall = self._taken(here, model)
            small = self._noise(fall)
            if small and here.violation > FEASIBILITY_TOLERANCE and self.penalty < MAX_PENALTY:
                self.penalty *= PENALTY_GROWTH
                continue
            last += small
            if following is None or last == MAX_NOISE_STEPS:
                return SqpResult((following or here).u, iteration + 1, small)
            here = following
        return SqpResult(here.u, most_iterations, False)

    def _reprice(self, here: _Point, step: _Step) -> None:
        """A higher penalty where it is what holds the constraints back."""
        if here.required.any() and np.abs(step.rows) @ here.required >= 0.99 * self.penalty:
            self.penalty = min(PENALTY_GROWTH * self.penalty, MAX_PENALTY)

    def _step(self, here: _Point, model: Array, g: Array) -> _Step | None:
        """The step of a model at a point, with rows that are g (m,) there."""
        n, programme, price = here.n, here.programme, here.required
        size, slack = len(here.z), int(price.any())
        hessian, slope = np.zeros((size + slack, size + slack)), np.append(here.gradient, np.full(slack, self.penalty))
        hessian[:n, :n] = model
        above, below = (np.flatnonzero(np.isfinite(b)) for b in (programme.g_upper, programme.g_lower))
        give = -np.append(price[above], price[below])[:, None]
        rows = np.hstack([np.vstack([here.jacobian[above], -here.jacobian[below]]), give[:, :slack]])
        most = np.append(programme.g_upper[above] - g[above], g[below] - programme.g_lower[below])
        low, high = np.full(size + slack, -np.inf), np.full(size + slack, np.inf)
        low[:n] = np.maximum(programme.lower[:n] - here.z[:n], -self.radius)
        high[:n] = np.minimum(programme.upper[:n] - here.z[:n], self.radius)
        low[size:] = 0.0
        found = solve_quadratic_program(hessian, slope, rows, most, (low, high))
        if found is None:
            return None
        multipliers = np.zeros(len(g))
        multipliers[above] += found.rows[: len(above)]
        multipliers[below] -= found.rows[len(above) :]
        cost = slope @ found.z + found.z[:n] @ model @ found.z[:n] / 2
        fall = self.penalty * here.violation - float(cost)
        return _Step(found.z[:size], fall, multipliers, found.bounds[:n])

    def _taken(self, here: _Point, model: Array) -> tuple[_Point | None, float]:
        """The point that a step leads to, None where no radius gives one, and the fall that was predicted."""
        fall = 0.0
        while self.radius > MIN_RADIUS:
            step = self._step(here, model, here.g)
            if step is None:
                return None, np.inf
            fall = step.fall
            trial, share = self._tried(here, model, step)
            length = float(np.abs(step.move[: here.n]).max(initial=0.0))
            if trial is not None and (share > ACCEPTED or self._noise(fall)):
                self._resize(share, length, fall)
                return trial, fall
            self.radius = min(self.radius, length) / 3
        return None, fall

    def _noise(self, fall: float) -> bool:
        """Whether rounding hides a predicted fall."""
        return fall <= NOISE * self.penalty

    def _resize(self, share: float, length: float, fall: float) -> None:
        """The radius after a step that was taken: larger where the model holds as far as it went, smaller if not."""
        if share > GOOD and length > 0.9 * self.radius:
            self.radius = min(GROWTH * self.radius, MAX_RADIUS)
        elif share < POOR and not self._noise(fall):
            self.radius = max(self.radius, length) / 2

    def _tried(self, here: _Point, model: Array, step: _Step) -> tuple[_Point | None, float]:
        """Where a step leads, corrected if that is better, and what part of the predicted fall it makes true."""
        trial = self._trial(here, step.move)
        share = self._share(here, trial, step.fall)
        if trial is None or share >= POOR or self._noise(step.fall):
            return trial, share
        corrected = self._corrected(here, model, step, trial)
        if corrected is None or corrected.merit(self.penalty) >= trial.merit(self.penalty):
            return trial, share
        return corrected, self._share(here, corrected, step.fall)

    def _trial(self, here: _Point, move: Array) -> _Point | None:
        z = here.z.copy()
        z[: here.n] += move[: here.n]
        try:
            u = self.problem.onto(self.problem.box.inside(here.programme.point(z)))
            return _Point(self.problem, self.problem.box.snapped(u, ROUNDING), self.holds)
        except ComputationError:
            return None

    def _share(self, here: _Point, trial: _Point | None, fall: float) -> float:
        """What part of the predicted fall a trial makes true."""
        if trial is None or fall <= 0:
            return -np.inf
        return (here.merit(self.penalty) - trial.merit(self.penalty)) / fall

    def _corrected(self, here: _Point, model: Array, step: _Step, trial: _Point) -> _Point | None:
        """The step anew, with the rows as they are at the trial: right to second order in the active ones."""
        z = here.z + step.move
        z[: here.n] = trial.z[: here.n]
        g = here.programme.g(z)
        again = self._step(here, model, g - here.jacobian @ step.move) if np.isfinite(g).all() else None
        return None if again is None else self._trial(here, again.move)


def _find_normals(here: _Point, step: _Step) -> Array:
    """Normals (k, n) of what holds a step: active constraints, differences of active rows of one side, bounds."""
    n, programme = here.n, here.programme
    carrying = (np.abs(step.rows) > MULTIPLIER_TOLERANCE) | (programme.g_lower == programme.g_upper)
    sides = np.split(np.arange(len(step.rows)), [programme.a, programme.a + programme.b])
    rows = [here.jacobian[side[carrying[side]], :n] for side in sides]
    apart = [group[1:] - group[:1] for group in rows[:2]]
    low, high = here.z[:n] <= programme.lower[:n], here.z[:n] >= programme.upper[:n]
    held = (low & (step.bounds < -MULTIPLIER_TOLERANCE)) | (high & (step.bounds > MULTIPLIER_TOLERANCE))
    return np.vstack([*apart, rows[2], np.eye(n)[held]])


def _convexify(hessian: Array, normals: Array) -> Array:
    """A positive definite matrix (n, n) that gives the same steps as a Hessian where what is active holds them.

    Along the normals (k, n) a step is fixed, so that curvature added there changes none; of what remains, negative
    curvature is taken for positive.
    """
    floor = MIN_CURVATURE * max(1.0, float(np.abs(hessian).max()))
    _, sizes, right = np.linalg.svd(normals)
    rank = int((sizes > RANK_TOLERANCE * sizes.max(initial=0.0)).sum())
    along, free = right[:rank].T, right[rank:].T
    total = hessian.copy()
    values, vectors = np.linalg.eigh(free.T @ hessian @ free)
    basis = free @ vectors
    total += (basis * (np.maximum(np.abs(values), floor) - values)) @ basis.T
    if rank:
        mixed, inner = along.T @ total @ free, free.T @ total @ free
        rest = along.T @ total @ along - mixed @ np.linalg.solve(inner, mixed.T)
        total += max(0.0, floor - float(np.linalg.eigvalsh(rest)[0])) * along @ along.T
    symmetric: Array = (total + total.T) / 2
    return symmetric


DAQP_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "daqp": {"eps_prox": 1e-4, "primal_tol": 1e-10, "dual_tol": 1e-12},
}
"""The proximal term makes what is only convex strictly so; it is taken back by iterating."""


@dataclass(frozen=True)
class QuadraticSolution:
    """A minimum: variables (n,), multipliers of the rows (m,) and of the bounds (n,), positive at upper ones."""

    z: Array
    rows: Array
    bounds: Array


def solve_quadratic_program(
    hessian: Array, gradient: Array, rows: Array, most: Array, bounds: tuple[Array, Array]
) -> QuadraticSolution | None:
    """Minimise gradient . z + z' hessian z / 2 with rows (m, n) . z <= most and z in bounds; None where that failed."""
    solver = _build_solver(len(gradient), len(most))
    low, high = bounds
    least = np.full(len(most), -np.inf)
    found = solver(h=hessian, g=gradient, a=rows, lba=least, uba=most, lbx=low, ubx=high)
    if not solver.stats()["success"]:
        return None
    z, along, held = (np.asarray(found[key], dtype=float)[:, 0] for key in ("x", "lam_a", "lam_x"))
    return QuadraticSolution(z, along, held)


@cache
def _build_solver(size: int, rows: int) -> ca.Function:
    shapes = {"h": ca.Sparsity.dense(size, size), "a": ca.Sparsity.dense(rows, size)}
    return ca.conic("quadratic", "daqp", shapes, DAQP_OPTIONS)
