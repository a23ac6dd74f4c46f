"""Pareto front of range and variance: designs of which neither can decrease without an increase of
the other.

The variance is minimised with an upper limit on the range, for limits between the ranges of the two
single-objective optima. Unlike a weighted sum, this also yields the straight and the concave parts
of a front.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.optimise import ipopt
from planter.optimise.epigraph import Epigraph
from planter.optimise.local_search import MAX_ROW_ROUNDS, VIOLATION_TOLERANCE, search_from_starts
from planter.optimise.objective import LocalModel, ObjectiveEvaluation
from planter.optimise.problem import Problem
from planter.optimise.range_variance import Sampling
from planter.optimise.range_variance import build_range_problem as over_turn
from planter.optimise.response import CycleResponse
from planter.optimise.variance import Weights
from planter.progress import Listener, ProgressPhase

RANGE_ONLY, VARIANCE_ONLY = Weights(1.0, 0.0, "paper"), Weights(0.0, 1.0, "paper")
STARTS = 4
FRONT_POINTS = 5
"""Default number of points on the front of a machine."""
CAP_MARGIN = 1e-6
"""Distance of the caps from the ends of the front, as a share of its length; the ends leave no
freedom.
"""


@dataclass(frozen=True)
class ParetoPoint:
    """A design x (p,) [SI] on the front and its evaluation, with the variance as objective."""

    design: Array
    evaluation: ObjectiveEvaluation


class CappedEpigraph(Epigraph):
    """Epigraph form with the additional constraint t_max - t_min <= cap [N]."""

    def __init__(self, problem: Problem, local: LocalModel, u: Array, cap: float) -> None:
        super().__init__(problem, local, u)
        self.g_lower = np.append(self.g_lower, -np.inf)
        self.cap_row = np.append(np.zeros(self.n), self.units)
        self.g_upper = np.append(self.g_upper, cap - self.levels.sum())

    def g(self, z: Array) -> Array:
        """Return the constraints (m,) at z (n,)."""
        return np.append(super().g(z), self.cap_row @ z)

    def jacobian(self, z: Array) -> Array:
        """Return the Jacobian (m, n) of g at z (n,)."""
        return np.vstack([super().jacobian(z), self.cap_row])

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        """Return the Hessian (n, n) of weight * f + multipliers . g at z (n,)."""
        return super().hessian(z, weight, multipliers[:-1])


def trace_pareto_front(
    response: CycleResponse, sampling: Sampling, points: int = 15, progress: Listener | None = None
) -> list[ParetoPoint]:
    """Return a front of at most `points` designs, evenly spaced in range, from minimum range to
    minimum variance.

    Each end is the best of several local searches; every other point starts from the previous one.
    Caps for which IPOPT does not converge and dominated designs are omitted. If both ends have the
    same range, the front is one design. `progress` receives the variance [N2].
    """
    problem = over_turn(response, VARIANCE_ONLY, sampling)
    u = _minimise_globally(over_turn(response, RANGE_ONLY, sampling), progress)
    other = _minimise_globally(problem, progress)
    min_range, max_range = (problem.evaluate(end).look.range for end in (u, other))
    if max_range - min_range <= VIOLATION_TOLERANCE * max_range:
        return [ParetoPoint(problem.design(other), problem.evaluate(other))]
    caps = min_range + (max_range - min_range) * np.linspace(
        CAP_MARGIN, 1 - CAP_MARGIN, max(points, 2)
    )
    front, phase = [], ProgressPhase("front", "point", len(caps), progress)
    for count, cap in enumerate(caps, 1):
        reached = _minimise_capped(problem, u, float(cap))
        if reached is not None:
            u = reached
            front.append(ParetoPoint(problem.design(u), problem.evaluate(u)))
        phase.report(count, best=front[-1].evaluation.objective if front else None)
    return [
        point
        for point in front
        if not any(_dominates(other.evaluation, point.evaluation) for other in front)
    ]


def _minimise_globally(problem: Problem, progress: Listener | None) -> Array:
    return min(
        search_from_starts(problem, STARTS, seed=0, progress=progress),
        key=lambda minimum: minimum.objective,
    ).u


def _minimise_capped(problem: Problem, start: Array, cap: float) -> Array | None:
    """Return the point (p,) of minimum variance with a range of at most `cap` [N], or None without
    convergence.
    """
    u, local = start, problem.local(start)
    for _ in range(MAX_ROW_ROUNDS):
        programme = CappedEpigraph(problem, local, u, cap)
        solution = ipopt.solve_program(programme, programme.start, problem.most_iterations)
        u = problem.box.inside(programme.point(solution.z))
        tops = programme.tops(solution.z)
        if (
            solution.converged
            and problem.evaluate(u).look.range <= cap + VIOLATION_TOLERANCE * programme.units[0]
        ):
            return u
        local = local.grown(problem.design(u), tops)
    return None


def _dominates(first: ObjectiveEvaluation, second: ObjectiveEvaluation) -> bool:
    a, b = first.look, second.look
    return (
        a.range <= b.range
        and a.variance <= b.variance
        and (a.range < b.range or a.variance < b.variance)
    )
