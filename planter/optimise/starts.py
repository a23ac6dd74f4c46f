"""Descents from several starts: the design to start from, then points of a Latin hypercube in the box."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise.descent import MOST_ITERATIONS, Minimum, descend
from planter.optimise.elastic import least_violation
from planter.optimise.problem import Best, Counts, Problem
from planter.parallel.jobs import Jobs, run_in_order
from planter.parallel.task import HERE, Means, Task
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


@dataclass(frozen=True)
class Descent:
    """Where a descent ended on a problem, or the error that it ended by, with all that the problem met on the way."""

    minimum: Minimum | None
    error: ComputationError | None
    counts: Counts
    best: Best | None
    history: list[tuple[int, float]]

    def join(self, problem: Problem) -> Minimum:
        """Return the minimum, all that was met counted as met by a problem. Raises the error if there is one."""
        problem.absorb(self.counts, self.best, self.history)
        if self.minimum is None:
            raise self.error or ComputationError("this start leads nowhere")
        return self.minimum


def run_descent(
    problem: Problem, find_start: Callable[[], Array], most_iterations: int = MOST_ITERATIONS
) -> Descent:  # fmt: skip
    """Return the descent on a problem anew from a start (p,): the job of a worker."""
    problem, minimum, reason = problem.anew(), None, None
    try:
        minimum = descend(problem, nearer(problem, find_start()), most_iterations)
    except ComputationError as error:
        reason = error
    return Descent(minimum, reason, problem.counts, problem.best, problem.history)


def descents(
    problem: Problem, count: int, seed: int, progress: Listener | None = None, task: Task | None = None,
    means: Means = HERE, under_way: Jobs | None = None,
) -> Iterator[Minimum]:  # fmt: skip
    """The local minima from so many points of the box, one after another as they are found.

    A start that breaks constraints is first taken to where they are violated least. Workers run the descents of a task,
    whose jobs are points (p,), as `run_in_order`; or they are `under_way`.
    """
    phase = Phase("ipopt", "start", count, progress)
    problem.heard = phase.under_way

    def run_here(start: Array) -> Minimum:
        return descend(problem, nearer(problem, start))

    def join(descent: Descent) -> Minimum:
        return descent.join(problem)

    def wait() -> None:
        phase.under_way(problem.least)

    if under_way is None:
        minima = run_in_order(task, points(problem, count, seed), means, run_here, join, wait)
    else:
        minima = map(join, under_way.in_order(wait))
    for done, minimum in enumerate(minima, 1):
        yield minimum
        phase.reached(done, best=problem.least)


def descents_from(problem: Problem, starts: Sequence[Array], most_iterations: int = MOST_ITERATIONS) -> list[Minimum]:
    """The local minima from points u (p,) as they are; starts that are one point descend as one."""
    found: list[Minimum] = []
    for start in starts:
        twins = (end for other, end in zip(starts, found, strict=False) if np.abs(other - start).max() <= ONE)
        found.append(next(twins, None) or descend(problem, start, most_iterations))
    return found
