"""Pareto front of range and variance: designs of which neither can decrease without an increase of
the other.

The variance is minimised with an upper limit on the range, for limits between the ranges of the two
single-objective optima. Unlike a weighted sum, this also yields the straight and the concave parts
of a front.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.engine.solvers import ipopt
from planter.engine.solvers.epigraph import Epigraph
from planter.engine.solvers.local_search import (
    MAX_ROW_ROUNDS,
    VIOLATION_TOLERANCE,
    search_from_starts,
)
from planter.engine.solvers.objective import LocalModel
from planter.engine.solvers.problem import Problem
from planter.kernels import Array
from planter.progress import Listener, ProgressPhase

STARTS = 4
CAP_MARGIN = 1e-6
"""Distance of the caps from the ends of the front, as a share of its length; the ends leave no
freedom.
"""


@dataclass(frozen=True)
class ParetoPoint:
    """A design x (p,) [SI] on the front, its range and its variance."""

    design: Array
    range: float
    variance: float

    @classmethod
    def at(cls, problem: Problem, u: Array) -> ParetoPoint:
        """Return a point u (p,) of a problem whose groups have the extremes as rows."""
        summary = problem.evaluate(u).summary
        return cls(problem.design(u), max(float(summary.tops.sum()), 0.0), summary.smooth)

    def dominates(self, other: ParetoPoint) -> bool:
        """Return whether this point is nowhere worse than another, and somewhere better."""
        pair, theirs = (self.range, self.variance), (other.range, other.variance)
        return pair != theirs and all(a <= b for a, b in zip(pair, theirs, strict=True))


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
    of_variance: Problem, of_range: Problem, points: int = 15, progress: Listener | None = None
) -> list[ParetoPoint]:
    """Return a front of at most `points` designs, evenly spaced in range, from minimum range to
    minimum variance.

    The problem of the variance has the extremes as groups of weight zero. Each end is the best of
    several local searches; every other point starts from the previous one. Caps for which IPOPT
    does not converge and dominated designs are omitted. If both ends have the same range, the front
    is one design. `progress` receives the variance.
    """
    u, other = (_minimise_globally(problem, progress) for problem in (of_range, of_variance))
    low, high = (ParetoPoint.at(of_variance, end) for end in (u, other))
    if high.range - low.range <= VIOLATION_TOLERANCE * high.range:
        return [high]
    shares = np.linspace(CAP_MARGIN, 1 - CAP_MARGIN, max(points, 2))
    caps = low.range + (high.range - low.range) * shares
    front, phase = list[ParetoPoint](), ProgressPhase("front", "point", len(caps), progress)
    for count, cap in enumerate(caps, 1):
        reached = _minimise_capped(of_variance, u, float(cap))
        if reached is not None:
            u = reached
            front.append(ParetoPoint.at(of_variance, u))
        phase.report(count, best=front[-1].variance if front else None)
    return [point for point in front if not any(other.dominates(point) for other in front)]


def _minimise_globally(problem: Problem, progress: Listener | None) -> Array:
    minima = search_from_starts(problem, STARTS, seed=0, progress=progress)
    return min(minima, key=lambda minimum: minimum.objective).u


def _minimise_capped(problem: Problem, start: Array, cap: float) -> Array | None:
    """Return the point (p,) of minimum variance with a range of at most `cap`, or None without
    convergence.
    """
    u, local = start, problem.local(start)
    for _ in range(MAX_ROW_ROUNDS):
        programme = CappedEpigraph(problem, local, u, cap)
        solution = ipopt.solve_program(programme, programme.start, problem.most_iterations)
        u = problem.box.inside(programme.point(solution.z))
        excess = ParetoPoint.at(problem, u).range - cap
        if solution.converged and excess <= VIOLATION_TOLERANCE * programme.units[0]:
            return u
        local = local.extended(problem.design(u), programme.tops(solution.z))
    return None
