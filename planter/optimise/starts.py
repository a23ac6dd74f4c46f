"""Descents from several starts: the design to start from, then points of a Latin hypercube in the box."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from planter.kernels import Array
from planter.optimise.descent import MOST_ITERATIONS, Minimum, descend
from planter.optimise.elastic import least_violation
from planter.optimise.problem import Problem
from planter.progress import Listener, Phase

DEFAULT_STARTS = 8
ONE = 1e-7
"""Starts closer than this in every coordinate, in the box's unit, are one."""
AGREEING = 1e-6
"""Starts agree whose objectives differ by less than this share of the problem's scale."""


def points(problem: Problem, count: int, seed: int) -> list[Array]:
    """Starting points u (p,): the design to start from first; the same seed and count give the same points."""
    from scipy.stats import qmc

    if count < 2:
        return [problem.start]
    cube = qmc.LatinHypercube(len(problem.free), seed=np.random.default_rng(seed)).random(count - 1)
    return [problem.start, *(problem.within(v) for v in cube)]


def nearer(problem: Problem, start: Array) -> Array:
    """A start on the equations, or where the constraints are violated least on the way from there."""
    start = problem.onto(start)
    if problem.constraints is None or problem.kept(start):
        return start
    return least_violation(problem, problem.constraints, start).u


def descents(problem: Problem, count: int, seed: int, progress: Listener | None = None) -> Iterator[Minimum]:
    """The local minima from so many points of the box, one after another as they are found.

    A start that breaks constraints is first taken to where they are violated least.
    """
    phase = Phase("ipopt", "start", count, progress)
    problem.heard = phase.under_way
    for i, start in enumerate(points(problem, count, seed), 1):
        yield descend(problem, nearer(problem, start))
        phase.reached(i, best=problem.least)


def descents_from(problem: Problem, starts: Sequence[Array], most_iterations: int = MOST_ITERATIONS) -> list[Minimum]:
    """The local minima from points u (p,) as they are; starts that are one point descend as one."""
    found: list[Minimum] = []
    for start in starts:
        twins = (end for other, end in zip(starts, found, strict=False) if np.abs(other - start).max() <= ONE)
        found.append(next(twins, None) or descend(problem, start, most_iterations))
    return found
