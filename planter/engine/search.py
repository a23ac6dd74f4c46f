"""The design of a machine, within its bounds, that minimises a sum of measures under limits."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter import errors
from planter.engine.infeasibility import Infeasibility, explain_infeasibility
from planter.engine.problem import DesignProblem
from planter.engine.sections import DEFAULT_GENETIC
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.feasibility import (
    ViolationMinimum,
    relax_single_kind,
    select_smallest_violation,
)
from planter.engine.solvers.local_search import (
    DEFAULT_STARTS,
    Approach,
    Descent,
    SearchRecord,
    run_search,
)
from planter.engine.solvers.optimiser import METHODS, GeneticSettings, Method, OptimiserRun
from planter.engine.solvers.result import NoFeasiblePointError, OptimiserResult
from planter.engine.wider import search_wider
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.progress import Listener, Progress
from planter.task import AUTO, Means, Task

INTERVAL_S = 1.0
"""Time between two designs that an unfinished search hands over, while it goes from step to
step.
"""


@dataclass(frozen=True)
class CandidateDesign:
    """The best design x (p,) in SI of an unfinished search, or, if none is feasible, the closest
    one.

    `objective` is None where only the constraints were evaluated, `violation` the largest one in
    steps; of a search that has ended, `violated` names that constraint, and `closest` has the
    violation of each. `seconds` is how long the search has run.
    """

    x: Array
    objective: float | None
    violation: float
    seconds: float
    violated: str | None = None
    closest: ViolationMinimum | None = None

    @property
    def is_feasible(self) -> bool:
        """Whether the design satisfies all constraints."""
        return self.violation <= FEASIBILITY_TOLERANCE

    @property
    def rank(self) -> tuple[float, float]:
        """Sort key, smallest for the best: the violation if there is one, then the objective."""
        objective = math.inf if self.objective is None else self.objective
        return (0.0, objective) if self.is_feasible else (self.violation, 0.0)


Keep = Callable[[CandidateDesign], None]
"""What takes the best, or else the closest, design so far of an unfinished search."""


@dataclass(frozen=True)
class SearchSpec:
    """Settings of a search: true extremes ("refined") or a number of samples, method, starts."""

    sampling: Sampling = "refined"
    method: Method = "auto"
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
    """The user stopped a search; `best` is the optimum so far, else `candidate` the closest design,
    if there is one.
    """

    def __init__(self, best: DesignOptimum | None, candidate: CandidateDesign | None) -> None:
        super().__init__()
        self.best, self.candidate = best, candidate


class FailedSearchError(ComputationError):
    """A search ended without a result; `candidate` is the best or closest design, None if none
    could be evaluated, and `infeasibility` what stands in the way of a feasible one, if that is the
    reason.
    """

    name = "ComputationError"

    def __init__(
        self,
        reason: str,
        candidate: CandidateDesign | None,
        infeasibility: Infeasibility | None = None,
    ) -> None:
        super().__init__(reason)
        self.candidate, self.infeasibility = candidate, infeasibility


def minimise(
    problem: DesignProblem,
    spec: SearchSpec,
    listener: Listener | None = None,
    task: Task | None = None,
    means: Means = AUTO,
    feasible: Sequence[Array] = (),
    keep: Keep | None = None,
) -> DesignOptimum:
    """Return the design within the bounds that minimises the objective of a problem under its
    constraints.

    `feasible` are points u (p,) that satisfy the constraints, `keep` takes the best design so far
    as it is met, the closest one while none is feasible, and the last one if the search ends
    without a result. `means` says what runs the descents, whose results do not depend on it;
    workers take those of a task, whose jobs are points. Raises InputError for an unknown method,
    FailedSearchError if no start leads to a design that satisfies the limits, and InterruptedSearch
    on KeyboardInterrupt. If bounds are active, the result says what wider ones would bring.
    """
    if spec.method not in METHODS:
        raise InputError(f"method = {spec.method!r}: choose one of {', '.join(METHODS)}")
    search = OptimiserRun(problem, spec.genetic, spec.seed, spec.starts, task=task, means=means)
    keeper = _Keeper(problem, search, keep, listener)
    search.progress = keeper
    try:
        return _run(problem, search, keeper, spec, feasible)
    except KeyboardInterrupt:
        partial = search.so_far(spec.method)
        best = None if partial is None else _build_optimum(problem, partial)
        raise InterruptedSearch(best, None if best is not None else keeper.finish(())) from None


def _run(
    problem: DesignProblem,
    search: OptimiserRun,
    keeper: _Keeper,
    spec: SearchSpec,
    feasible: Sequence[Array],
) -> DesignOptimum:
    """Return the optimum of a search. Raises FailedSearchError as `minimise`."""
    try:
        result = search.run(spec.method, feasible)
    except NoFeasiblePointError as error:
        if not search.violations or problem.constraints is None:
            raise FailedSearchError(error.message, keeper.finish(error.points)) from None
        smallest = select_smallest_violation(search.violations)
        closest = relax_single_kind(search.ipopt, problem.constraints, smallest)
        candidate = keeper.finish([closest.u])
        infeasibility = explain_infeasibility(problem, closest, spec.starts)
        if candidate is not None:
            candidate = replace(candidate, closest=closest)
        raise FailedSearchError(str(infeasibility), candidate, infeasibility) from None
    except ComputationError as error:
        raise FailedSearchError(error.message, keeper.finish(())) from None
    return _build_optimum(problem, replace(result, wider=search_wider(problem, result)))


def _build_optimum(problem: DesignProblem, result: OptimiserResult) -> DesignOptimum:
    return DesignOptimum(result.design, problem, result)


class _Keeper:
    """A listener that hands over the best or closest design of a search when there is a better one,
    not too often.

    It evaluates nothing before the search has ended, whose last digits would depend on when it was
    asked.
    """

    def __init__(
        self,
        problem: DesignProblem,
        search: OptimiserRun,
        keep: Keep | None,
        listener: Listener | None,
    ) -> None:
        self._problem, self._search, self._keep, self._listener = problem, search, keep, listener
        self._begun, self._last = time.perf_counter(), 0.0
        self._best: CandidateDesign | None = None

    def __call__(self, step: Progress) -> None:
        if self._keep is not None and (
            step.done == step.total or time.perf_counter() - self._last > INTERVAL_S
        ):
            for candidate in self._list_met():
                self._hand_over(candidate)
        if self._listener is not None:
            self._listener(step)

    def finish(self, points: Sequence[Array]) -> CandidateDesign | None:
        """Hand over and return the best design of all; without a feasible one the closest of
        `points` (p,), if there are any. None if there is none.
        """
        met = self._list_met()
        designs = [design for design in met if design.is_feasible]
        if not designs:
            places = [self._problem.design(u) for u in points] or [design.x for design in met]
            designs = [
                design for design in map(self._evaluate, places) if design is not None
            ] or met
        best = min(designs, key=lambda design: design.rank, default=None)
        if best is not None and self._keep is not None:
            self._keep(best)
        return best

    def _list_met(self) -> list[CandidateDesign]:
        seconds = time.perf_counter() - self._begun
        best, closest = self._search.best(), self._search.closest()
        find, met = self._problem.design, list[CandidateDesign]()
        if best is not None:
            met.append(CandidateDesign(find(best.u), best.objective, 0.0, seconds))
        if closest is not None:
            met.append(CandidateDesign(find(closest.u), None, closest.violation, seconds))
        return met

    def _hand_over(self, candidate: CandidateDesign) -> None:
        if self._best is None or candidate.rank < self._best.rank:
            self._best = candidate
            if self._keep is not None:
                self._last = time.perf_counter()
                self._keep(candidate)

    def _evaluate(self, x: Array) -> CandidateDesign | None:
        """Return a design x (p,) with its objective and what it violates most, None if it has no
        cycle.
        """
        problem, seconds = self._problem, time.perf_counter() - self._begun
        try:
            objective, name, violation = problem.score(x).objective, None, 0.0
            if problem.constraints is not None:
                excess = problem.constraints.excess(x)
                worst = int(np.argmax(excess))
                name, violation = problem.constraints.kinds[worst].name, float(excess[worst])
        except ComputationError:
            return None
        return CandidateDesign(x, objective, violation, seconds, name)


def prepare_descents(problem: DesignProblem) -> Callable[[Descent | Approach], SearchRecord]:
    """Return the function that searches on a problem: the job of a worker."""
    return lambda job: run_search(problem, job)
