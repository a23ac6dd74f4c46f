"""A local minimum from one start: IPOPT on a set of rows that is complete when it ends, on a kink where that is needed.

1. Rows. IPOPT solves the epigraph form on the rows in hand. Samples that violate t_max or t_min join the rows until none
   does; true extremes are asked for anew, and if the last windows hide none, the rows are complete.
2. Kinks. A sampled objective has a kink in x wherever a joint of order 1 passes a sample. IPOPT works with the one-sided
   derivatives of the side it is on, which are exact, and most optima lie on no kink. If it stalls beside one, the sample
   is pinned on the joint, which makes the problem smooth again, and solved for there. The certificate then decides with
   both one-sided gradients: if zero is not in Clarke's subdifferential, the best point found stands, with its residual.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.optimise import certificate, ipopt
from planter.optimise.conditions import Local
from planter.optimise.epigraph import Epigraph
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Problem
from planter.optimise.samples import SampledRows, Samples

ROUNDS = 12
"""Most times that rows are added, or pins."""
VIOLATED = 1e-9
"""A row violates an extreme if it exceeds it by more than this share of the range."""
STATIONARY = 1e-6
"""Residual of the certificate at which a point counts as optimal."""
BESIDE = 1e-4
"""How near to a sample a joint must be for the sample to be pinned on it [rad]."""
SNAPS = (0.0, 1e-7, 1e-5, 1e-3)
"""Coordinates this close to their bounds, as a share of the box, are set onto them if the point is the better for it."""


@dataclass(frozen=True)
class Minimum:
    """Where a descent ended: point u (p,), its evaluation, its residual (dimensionless) and IPOPT's iterations."""

    u: Array
    evaluation: Evaluation
    residual: float
    iterations: int

    @property
    def stationary(self) -> bool:
        return self.residual < STATIONARY


def descend(problem: Problem, start: Array, most_iterations: int = 100) -> Minimum:
    """The local minimum reached from a point u (p,) of the box."""
    found = _complete(problem, start, problem.turn.local(problem.design(start)), most_iterations)
    if found.stationary or not isinstance(problem.turn, Samples):
        return found
    return _on_kinks(problem, problem.turn, found, most_iterations)


def _complete(problem: Problem, start: Array, local: Local, most_iterations: int) -> Minimum:
    """Solved with rows added until no other row of the turn exceeds the bounds on the force."""
    u, iterations, best = start, 0, None
    for _ in range(ROUNDS):
        programme = Epigraph(problem, local, u)
        solution = ipopt.solve(programme, programme.start, most_iterations)
        iterations += solution.iterations
        u = problem.point(np.clip(solution.z[:-2], 0, 1))
        found = _minimum(problem, u, iterations)
        if best is None or found.evaluation.objective < best.evaluation.objective or found.stationary:
            best = Minimum(found.u, found.evaluation, found.residual, iterations)
        grown = _grown(problem, local, found, solution.z[-2:] * programme.unit + programme.level)
        if found.stationary or grown is None:
            break
        local = grown
    assert best is not None
    return best


def _grown(problem: Problem, local: Local, found: Minimum, ends: Array) -> Local | None:
    """The rows with those added that a solution violates; None if there are none."""
    x = problem.design(found.u)
    margin = VIOLATED * problem.reference.range_N
    above, below = found.evaluation.max_N > ends[0] + margin, found.evaluation.min_N < ends[1] - margin
    if not (above or below):
        return None
    if not isinstance(local, SampledRows):
        return problem.turn.local(x)
    upper, lower = local.beyond(x, ends[0] + margin, ends[1] - margin)
    return local.grown(upper, lower)


def _minimum(problem: Problem, u: Array, iterations: int) -> Minimum:
    """A point, with coordinates beside their bounds set onto them: an interior-point method never quite reaches those."""
    points = {p.tobytes(): p for p in (np.where(u < s, 0.0, np.where(u > 1 - s, 1.0, u)) for s in SNAPS)}
    found = [
        Minimum(p, problem.evaluate(p), certificate.kkt_residual(problem, p), iterations) for p in points.values()
    ]
    return min(found, key=lambda m: (not m.stationary, m.evaluation.objective))
