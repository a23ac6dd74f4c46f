"""The design of a machine, within its bounds, that minimises a sum of measures under limits."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from planter import errors
from planter.engine.goal import find_display_unit
from planter.engine.problem import DesignProblem
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.optimise.local_search import DEFAULT_STARTS, Descent, SearchRecord, run_search
from planter.optimise.optimiser import METHODS, GeneticSettings, Method, OptimiserRun
from planter.optimise.problem import BestPoint
from planter.optimise.range_variance import Sampling
from planter.optimise.result import NoFeasiblePointError, OptimiserResult
from planter.optimise.sections import DEFAULT_GENETIC
from planter.parallel.task import AUTO, Means, Task, count_cores
from planter.progress import Listener, Progress

INTERVAL_S = 1.0
"""Time between two designs that an unfinished search hands over, while it goes from step to step."""

Keep = Callable[[BestPoint, float], None]
"""What takes the best point so far of an unfinished search, and how long that runs [s]."""


@dataclass(frozen=True)
class SearchSpec:
    """Settings of a search: true extremes ("refined") or a number of samples, method, starts."""

    sampling: Sampling = "refined"
    method: Method = "ipopt"
    starts: int = DEFAULT_STARTS
    seed: int = 0
    genetic: GeneticSettings = DEFAULT_GENETIC


@dataclass(frozen=True)
class DesignOptimum:
    """An optimum: the machine's design x (p,) in SI, its problem, and its result."""

    x: Array
    problem: DesignProblem
    result: OptimiserResult


class InterruptedSearch(errors.Interrupted):
    """The user stopped a search; `best` is the optimum so far, None if nothing feasible was met yet."""

    def __init__(self, best: DesignOptimum | None) -> None:
        super().__init__()
        self.best = best


def minimise(
    problem: DesignProblem, spec: SearchSpec, listener: Listener | None = None, task: Task | None = None,
    means: Means = AUTO, feasible: Sequence[Array] = (), keep: Keep | None = None,
) -> DesignOptimum:  # fmt: skip
    """Return the design within the bounds that minimises the objective of a problem under its constraints.

    `feasible` are points u (p,) that satisfy the constraints, `keep` takes the best point so far as it is met. `means`
    says what runs the descents, whose results do not depend on it; workers take those of a task, whose jobs are points.
    Raises InputError for an unknown method, ComputationError if no start leads to a design that satisfies the limits,
    and InterruptedSearch on KeyboardInterrupt.
    """
    if spec.method not in METHODS:
        raise InputError(f"method = {spec.method!r}: choose one of {', '.join(METHODS)}")
    early = _choose_early_means(problem, means)
    search = OptimiserRun(problem, spec.genetic, spec.seed, spec.starts, task=task, means=means, early=early)
    search.progress = listener if keep is None else _Keeper(search.best, keep, listener)
    try:
        return _build_optimum(problem, search.run(spec.method, feasible))
    except NoFeasiblePointError as error:
        raise ComputationError(_describe_infeasibility(problem, error.points)) from None
    except KeyboardInterrupt:
        result = search.so_far(spec.method)
        best = None if result is None else _build_optimum(problem, result)
        raise InterruptedSearch(best) from None


def _build_optimum(problem: DesignProblem, result: OptimiserResult) -> DesignOptimum:
    return DesignOptimum(result.design, problem, result)


class _Keeper:
    """A listener that hands over the best point of a search when there is a better one, not too often."""

    def __init__(self, find_best: Callable[[], BestPoint | None], keep: Keep, listener: Listener | None) -> None:
        self._find_best, self._keep, self._listener = find_best, keep, listener
        self._begun, self._last, self._objective = time.perf_counter(), 0.0, float("inf")

    def __call__(self, step: Progress) -> None:
        self._hand_over(step)
        if self._listener is not None:
            self._listener(step)

    def _hand_over(self, step: Progress) -> None:
        now = time.perf_counter()
        if step.best is None or step.best >= self._objective:
            return
        if now - self._last < INTERVAL_S and step.done < step.total:
            return
        best = self._find_best()
        if best is not None and best.objective < self._objective:
            self._last, self._objective = now, best.objective
            self._keep(best, now - self._begun)


def _choose_early_means(problem: DesignProblem, means: Means) -> Means | None:
    """Return what runs the starts while the genetic algorithm runs here; None if they come after it."""
    if means != AUTO:
        return means
    spare = count_cores() - 1
    return Means(spare) if spare and problem.is_slow else None


def prepare_descents(problem: DesignProblem) -> Callable[[Descent], SearchRecord]:
    """Return the function that descends on a problem: the job of a worker."""
    return lambda descent: run_search(problem, descent)


def _describe_infeasibility(problem: DesignProblem, points: Sequence[Array]) -> str:
    """Return which limit the best of the points violates most."""
    u, constraints = min(points, key=problem.violation), problem.constraints
    assert constraints is not None
    kind = constraints.kinds[int(np.argmax(constraints.excess(problem.design(u))))]
    limit = next((limit for limit in problem.goal.limits if str(limit) == kind.name), None)
    value = None if limit is None else problem.goal.evaluate_limit(problem.find_design(u), limit)
    unit = "" if limit is None else find_display_unit(problem.goal.machine, limit.measure).text
    reached = "" if value is None else f": the best design found reaches {f'{value:.6g} {unit}'.rstrip()}"
    return f"no design within the bounds satisfies {kind.name}{reached}"
