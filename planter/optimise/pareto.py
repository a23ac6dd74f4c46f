"""Range against variance: the designs of which neither can be made smaller without the other growing.

Least variance with the range capped, for caps between the range of the least-range design and that of the
least-variance design. Unlike a weighted sum this also finds the straight and the hollow parts of a front.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.optimise import ipopt
from planter.optimise.conditions import Local
from planter.optimise.descent import ROUNDS, VIOLATED
from planter.optimise.epigraph import Epigraph
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Problem
from planter.optimise.range_and_spread import Sampling
from planter.optimise.range_and_spread import problem as over_turn
from planter.optimise.response import Response
from planter.optimise.spread import Weights
from planter.optimise.starts import descents
from planter.progress import Listener, ProgressPhase

LEAST_RANGE, LEAST_VARIANCE = Weights(1.0, 0.0, "paper"), Weights(0.0, 1.0, "paper")
STARTS = 4
FRONT_POINTS = 5
"""Compromises on the way along the front of a machine's optimum."""
SLACK = 1e-6
"""The caps keep this share of the front's length away from its ends, where nothing is left to choose."""


@dataclass(frozen=True)
class Compromise:
    """A design x (p,) in SI on the front, and its evaluation with the variance as objective."""

    design: Array
    evaluation: Evaluation


class Capped(Epigraph):
    """The epigraph form with t_max - t_min <= cap [N] besides."""

    def __init__(self, problem: Problem, local: Local, u: Array, cap: float) -> None:
        super().__init__(problem, local, u)
        self.g_lower = np.append(self.g_lower, -np.inf)
        self.g_upper = np.append(self.g_upper, cap / self.unit)

    def g(self, z: Array) -> Array:
        return np.append(super().g(z), z[-2] - z[-1])

    def jacobian(self, z: Array) -> Array:
        return np.vstack([super().jacobian(z), np.eye(len(z))[-2] - np.eye(len(z))[-1]])

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        return super().hessian(z, weight, multipliers[:-1])


def sweep(
    response: Response, sampling: Sampling, points: int = 15, progress: Listener | None = None
) -> list[Compromise]:
    """A front of at most `points` compromises, evenly spaced in range, from least range to least variance.

    The ends are the best of a few starts; in between each compromise starts from the one before. Caps for which IPOPT
    finds no optimum, and compromises that another one beats, are left out; where both ends have the same range there is
    one design alone. `progress` is told the variance [N2].
    """
    problem = over_turn(response, LEAST_VARIANCE, sampling)
    u = _best(over_turn(response, LEAST_RANGE, sampling), progress)
    other = _best(problem, progress)
    least, most = (problem.evaluate(end).look.range for end in (u, other))
    if most - least <= VIOLATED * most:
        return [Compromise(problem.design(other), problem.evaluate(other))]
    caps = least + (most - least) * np.linspace(SLACK, 1 - SLACK, max(points, 2))
    found, phase = [], ProgressPhase("front", "point", len(caps), progress)
    for count, cap in enumerate(caps, 1):
        reached = _capped(problem, u, float(cap))
        if reached is not None:
            u = reached
            found.append(Compromise(problem.design(u), problem.evaluate(u)))
        phase.report(count, best=found[-1].evaluation.objective if found else None)
    return [one for one in found if not any(_beats(other.evaluation, one.evaluation) for other in found)]


def _best(problem: Problem, progress: Listener | None) -> Array:
    return min(descents(problem, STARTS, seed=0, progress=progress), key=lambda minimum: minimum.objective).u


def _capped(problem: Problem, start: Array, cap: float) -> Array | None:
    """The point of least variance with a range of at most `cap` [N]; None if it was not found."""
    u, local = start, problem.local(start)
    for _ in range(ROUNDS):
        programme = Capped(problem, local, u, cap)
        solution = ipopt.solve(programme, programme.start, problem.most_iterations)
        u = problem.box.inside(programme.point(solution.z))
        high, low = programme.limits(solution.z)
        if solution.converged and problem.evaluate(u).look.range <= cap + VIOLATED * programme.unit:
            return u
        local = local.grown(problem.design(u), high, low)
    return None


def _beats(one: Evaluation, other: Evaluation) -> bool:
    a, b = one.look, other.look
    return a.range <= b.range and a.variance <= b.variance and (a.range < b.range or a.variance < b.variance)
