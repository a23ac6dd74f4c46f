"""Descents from several starts: the design to start from, then points of a Latin hypercube in the box."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise.descent import Minimum, descend
from planter.optimise.elastic import least_violation
from planter.optimise.problem import Best, Counts, Problem
from planter.parallel.jobs import Jobs, run_in_order
from planter.parallel.task import AUTO, Means, Task
from planter.progress import Listener, ProgressPhase

DEFAULT_STARTS = 8
ONE = 1e-7
"""Starts closer than this in every coordinate, in the box's unit, are one."""
AGREEING = 1e-6
"""Starts agree whose objectives differ by less than this share of the problem's scale."""


def points(problem: Problem, count: int, seed: int) -> list[Array]:
    """Return starting points u (p,), that of the design first; the same seed and count give the same points."""
    from scipy.stats import qmc

    problem.restart()
    first = problem.complete(problem.start)
    if count < 2:
        return [first]
    cube = qmc.LatinHypercube(len(problem.independent), seed=np.random.default_rng(seed)).random(count - 1)
    return [first, *(problem.within(v) for v in cube)]


def nearer(problem: Problem, start: Array) -> Array:
    """A start on the equations, or where the constraints are violated least on the way from there."""
    start = problem.onto(start)
    if problem.constraints is None or problem.kept(start):
        return start
    return least_violation(problem, problem.constraints, start).u


@dataclass(frozen=True)
class Descent:
    """The minimum or the error by which a descent ended on a problem, with all that the problem met on the way."""

    end: Minimum | ComputationError
    counts: Counts
    best: Best | None
    history: list[tuple[int, float]]

    def join(self, problem: Problem) -> Minimum | ComputationError:
        """Return the end, all that was met counted as met by a problem."""
        problem.absorb(self.counts, self.best, self.history)
        return self.end


def run_descent(problem: Problem, start: Array) -> Descent:
    """Return the descent on a problem anew from a start (p,): the job of a worker."""
    problem = problem.anew()
    return Descent(_attempt(problem, start), problem.counts, problem.best, problem.history)


def _attempt(problem: Problem, start: Array) -> Minimum | ComputationError:
    """Return the minimum reached from a start, or why none is; neither depends on the descents before."""
    problem.restart()
    try:
        return descend(problem, nearer(problem, start))
    except ComputationError as error:
        return error


def descents(
    problem: Problem, count: int, seed: int, progress: Listener | None = None, task: Task | None = None,
    means: Means = AUTO, under_way: Jobs | None = None,
) -> Iterator[Minimum]:  # fmt: skip
    """Yield the local minima from `count` points of the box, as `find_minima` those of given points."""
    phase = ProgressPhase("ipopt", "start", count, progress)
    return find_minima(
        problem, points(problem, count, seed) if under_way is None else (), phase, task, means, under_way
    )


def find_minima(
    problem: Problem, starts: Sequence[Array], phase: ProgressPhase, task: Task | None = None, means: Means = AUTO,
    under_way: Jobs | None = None,
) -> Iterator[Minimum]:  # fmt: skip
    """Yield the local minima from points u (p,), in their order, as they are reached.

    A start that breaks constraints is first taken to where they are violated least; one that leads nowhere is left out.
    Workers run the descents of a task, whose jobs are points, as `run_in_order`; or they are `under_way`. Raises
    ComputationError if no start leads anywhere.
    """
    problem.heard = phase.report_if_slow
    minima, error = 0, None

    def join(descent: Descent) -> Minimum | ComputationError:
        return descent.join(problem)

    def wait() -> None:
        phase.report_if_slow(problem.least)

    ends: Iterator[Minimum | ComputationError]
    if under_way is None:
        ends = run_in_order(task, starts, means, lambda start: _attempt(problem, start), join, wait)
    else:
        ends = map(join, under_way.in_order(wait))
    for done, end in enumerate(ends, 1):
        if isinstance(end, ComputationError):
            error = end
        else:
            minima += 1
            yield end
        phase.report(done, best=problem.least)
    if error is not None and not minima:
        raise ComputationError(f"no start leads anywhere: {error.message}")


def descents_from(
    problem: Problem, starts: Sequence[Array], most_iterations: int | None = None
) -> list[Minimum]:  # fmt: skip
    """The local minima from points u (p,) as they are; starts that are one point descend as one."""
    found: list[Minimum] = []
    for start in starts:
        twins = (end for other, end in zip(starts, found, strict=False) if np.abs(other - start).max() <= ONE)
        found.append(next(twins, None) or descend(problem, start, most_iterations))
    return found
