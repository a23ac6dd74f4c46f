"""IPOPT from several starts: the machine's own design, then points of a Latin hypercube in the box."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.stats import qmc

from planter.kernels import Array
from planter.optimise.descent import Minimum, descend
from planter.optimise.elastic import least_violation
from planter.optimise.problem import Problem
from planter.optimise.progress import Progress

DEFAULT_STARTS = 8
AGREEING = 1e-6
"""Starts agree whose objectives differ by less than this share of the objective of the machine's own design."""


def points(problem: Problem, count: int, seed: int) -> list[Array]:
    """Starting points u (p,): the machine's own design first; the same seed and count give the same points."""
    if count < 2:
        return [problem.start]
    cube = qmc.LatinHypercube(len(problem.free), seed=np.random.default_rng(seed)).random(count - 1)
    return [problem.start, *(problem.point(v) for v in cube)]


def _nearer(problem: Problem, start: Array) -> Array:
    """A start, or where the constraints are violated least on the way from it."""
    if problem.constraints is None or problem.kept(start):
        return start
    return least_violation(problem, problem.constraints, start).u


def descents(
    problem: Problem, count: int, seed: int, progress: Callable[[Progress], None] | None = None
) -> Iterator[Minimum]:
    """The local minima, one for each start, as they are found."""
    for i, start in enumerate(points(problem, count, seed), 1):
        yield descend(problem, _nearer(problem, start))
        if progress is not None and problem.best is not None:
            progress(Progress("ipopt", "start", i, count, problem.best.objective))
