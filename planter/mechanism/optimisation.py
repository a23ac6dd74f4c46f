"""Optima and sensitivities of machines for the objective of their file, `--least` and `--hold`."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from planter import errors
from planter.engine import search
from planter.engine.front import require_front, trace_front
from planter.engine.goal import (
    Goal,
    evaluate_measure,
    extend_span,
    find_display_unit,
    resolve_limit,
    resolve_measure,
)
from planter.engine.machine import HasMachine, Machine, check_samples, to_machine
from planter.engine.measures import AVERAGES, Limit, Measure, format_sum, parse_limit, parse_sum
from planter.engine.problem import DesignProblem, build_problem
from planter.engine.search import (
    CandidateDesign,
    DesignOptimum,
    FailedSearchError,
    InterruptedSearch,
    SearchSpec,
    minimise,
)
from planter.engine.sensitivity import (
    SensitivityResult,
    compute_sensitivity,
    find_directions,
    move_all,
)
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.local_search import Descent, SearchRecord
from planter.engine.summary import ROUNDING
from planter.engine.wording import describe_measure, describe_sum
from planter.errors import InputError
from planter.kernels import Array
from planter.mechanism.model import require_repeating
from planter.mechanism.motion import MechanismMotion
from planter.mechanism.results import (
    FrontDesign,
    LimitResult,
    MechanismOptimumResult,
)
from planter.progress import Listener
from planter.report.subject import RequirementCheck, to_sentence_case
from planter.task import AUTO, Means, Task

SPREADS = ("jump", "range", "std", "variance")
"""Measures whose least value is zero."""


@dataclass(frozen=True)
class MechanismOptimum:
    """An optimum: the design (p,) in SI, the machine with it in place, its problem, and its
    result.
    """

    x: Array
    machine: Machine
    problem: DesignProblem
    result: MechanismOptimumResult
    goal: StatedGoal
    certificate: str | None = None
    """The text of the file of its proof, if it has one."""


@dataclass(frozen=True)
class UnfinishedOptimum:
    """The best or closest design of a search for the least sum that has no result (yet), in place
    in its machine.
    """

    machine: Machine
    sum_text: str
    candidate: CandidateDesign
    start_design: dict[str, float]
    goal: StatedGoal

    @property
    def design(self) -> dict[str, float]:
        """The design by name, in the units of the file."""
        numbers = self.machine.document.numbers()
        paths = self.machine.moved_paths
        return {
            name: numbers[path] for name, path in zip(self.machine.design_names, paths, strict=True)
        }

    def table(self) -> dict[str, Any]:
        """Return what is known, as an interrupted or failed command reports it."""
        return {
            "machine": self.machine.name,
            "least": self.sum_text,
            "objective": self.candidate.objective,
            "design": self.design,
            "start_design": self.start_design,
            "met": self.candidate.is_feasible,
            "violated": None if self.candidate.is_feasible else self.candidate.violated,
            "seconds": self.candidate.seconds,
        }


@dataclass(frozen=True)
class StatedGoal:
    """The objective and the limits of a machine's file and of a call, in the names of its
    quantities; `sum_text` is the text of the sum, if it is that of the call, and `holds` those of
    all limits, for a file in any folder.
    """

    machine: Machine
    objective: tuple[Measure, ...]
    limits: tuple[Limit, ...]
    sum_text: str = ""
    holds: tuple[str, ...] = ()

    @classmethod
    def read(
        cls, machine: Machine, objective: str | None = None, holds: Sequence[str] = ()
    ) -> StatedGoal:
        """Return the goal of a machine's file; `objective` replaces its sum, `holds` are more
        limits.

        Raises InputError for a text that cannot be parsed, or for unknown quantities.
        """
        terms = machine.objective if objective is None else parse_sum(objective)
        limits = (*machine.limits, *map(parse_limit, holds))
        machine = extend_span(machine, [*terms, *(limit.measure for limit in limits)])
        placed_terms = [term.with_whole_paths(machine.source) for term in terms]
        texts = [
            str(replace(limit, measure=limit.measure.with_whole_paths(machine.source)))
            for limit in limits
        ]
        return cls(
            machine,
            tuple(resolve_measure(machine, measure) for measure in terms),
            tuple(resolve_limit(machine, limit) for limit in limits),
            "" if objective is None else format_sum(placed_terms),
            tuple(dict.fromkeys(texts)),
        )

    def describe(self) -> str:
        """Return the sum in words, each measure with its unit."""
        return describe_sum(self.machine, self.objective)

    def require_objective(self) -> None:
        """Raise InputError if there is no sum, ComputationError for the mean of what does not
        repeat after a cycle.
        """
        if not self.objective:
            raise InputError(
                f"{self.machine.source}: objective.least is missing: give a sum there, or by "
                f"--least"
            )
        self.require_averages()

    def require_spread(self) -> None:
        """Raise InputError for a jump that is zero already, and for a sum of spreads that all are:
        none is less.
        """
        idle = [
            measure
            for measure in self.objective
            if measure.kind in SPREADS and self._is_zero(measure)
        ]
        jumps = [measure for measure in idle if measure.kind == "jump"]
        for measure in jumps or (idle if len(idle) == len(self.objective) else []):
            word = "jump" if measure.kind == "jump" else "change over the cycle"
            reason = (
                f"{measure.name} does not {word} at the machine's own design, and no "
                f"{measure.kind} is below 0"
            )
            raise InputError(
                f"{self.machine.source}: {measure}: {reason}; leave it out, or state it as a limit"
            )

    def _is_zero(self, measure: Measure) -> bool:
        """Return whether a measure is rounding of its quantity at the machine's own design."""
        largest = Measure("max", measure.name, size=True)
        terms = (replace(measure, weight=1.0), largest)
        value, size = (evaluate_measure(self.machine, term) for term in terms)
        return value <= ROUNDING * size

    def build_problem(self, sampling: Sampling) -> DesignProblem:
        """Return the problem of the sum under the limits.

        Raises InputError for a machine without bounds.
        """
        return build_problem(self.machine, self.objective, self.limits, sampling)

    def require_averages(self) -> None:
        """Raise ComputationError for the mean of what does not repeat after a cycle."""
        if self.machine.motion is not None:
            return
        measures = (*self.objective, *(limit.measure for limit in self.limits))
        require_repeating(
            self.machine, [measure.name for measure in measures if measure.kind in AVERAGES]
        )


def optimise_machine(
    machine: Machine,
    least: str | None = None,
    holds: Sequence[str] = (),
    spec: SearchSpec | None = None,
    listener: Listener | None = None,
    means: Means = AUTO,
    keep: Callable[[UnfinishedOptimum], None] | None = None,
) -> MechanismOptimum:
    """Return the design within the file's bounds that minimises a sum of measures under limits.

    `least` replaces the file's objective, `holds` are additional limits, `means` the processes of
    the local searches, on which results do not depend; `keep` takes the best design so far, or the
    closest one while none satisfies the limits. Raises InputError for measures that cannot be
    parsed, a file without bounds or sum, or a spread that is zero already; FailedSearchError, whose
    `partial` is the closest design, if no start leads to one that satisfies the limits;
    ComputationError for the mean of a quantity that does not repeat after a cycle.
    """
    begun = time.perf_counter()
    goal = StatedGoal.read(machine, least, holds)
    machine = goal.machine  # which moves for as long as the goal asks
    goal.require_objective()
    goal.require_spread()
    spec = spec or SearchSpec(machine.sampling)
    stated = {
        "searched": machine.searched,
        "least": least,
        "holds": list(holds),
        "sampling": spec.sampling,
    }
    task = Task(prepare_descents, {"build": partial(machine.build, machine.document), **stated})
    words = least or format_sum(machine.objective)

    def place(candidate: CandidateDesign) -> UnfinishedOptimum:
        _, start, best = _place_design(machine, candidate.x)
        return UnfinishedOptimum(best, words, candidate, start, goal)

    def keep_design(candidate: CandidateDesign) -> None:
        assert keep is not None
        keep(place(candidate))

    try:
        optimum = minimise(
            goal.build_problem(spec.sampling),
            spec,
            listener,
            task,
            means,
            keep=None if keep is None else keep_design,
        )
    except InterruptedSearch as stop:
        if stop.best is not None:
            best = _record(machine, words, goal, stop.best, begun)
            if keep is not None:
                keep_design(
                    CandidateDesign(stop.best.x, best.result.objective, 0.0, best.result.seconds)
                )
            raise errors.Interrupted(best.result.table()) from None
        raise errors.Interrupted(
            None if stop.candidate is None else place(stop.candidate).table()
        ) from None
    except FailedSearchError as error:
        if error.candidate is not None:
            reasons = {} if error.infeasibility is None else error.infeasibility.table()
            error.partial = place(error.candidate).table() | reasons
        raise
    return _record(machine, words, goal, optimum, begun)


def _place_design(machine: Machine, x: Array) -> tuple[dict[str, float], dict[str, float], Machine]:
    """Return a design x (p,) by name in the units of the file, that of the file, and the machine
    with the design.
    """
    names, paths = machine.design_names, machine.moved_paths
    design, numbers = (
        [float(f"{value:.15g}") for value in x / machine.scale],
        machine.document.numbers(),
    )
    document = machine.document.with_numbers(dict(zip(paths, design, strict=True)))
    best = replace(machine, document=document, data=machine.build_data(x))
    start = {name: numbers[path] for name, path in zip(names, paths, strict=True)}
    return dict(zip(names, design, strict=True)), start, best


def prepare_descents(
    build: Callable[[], Machine],
    searched: Mapping[str, Any],
    least: str | None,
    holds: Sequence[str],
    sampling: Sampling,
) -> Callable[[Descent], SearchRecord]:
    """Return the local search from a point for an objective under limits, in a worker.

    `build` gives the machine of the file, `searched` are the fields that the search has changed.
    """
    goal = StatedGoal.read(replace(build(), **searched), least, holds)
    return search.prepare_descents(goal.build_problem(sampling))


def evaluate_limits(machine: Machine, changing: Collection[str] = ()) -> list[LimitResult]:
    """Return the limits of a machine's file with their values at its own design, by true extremes
    and integrals.

    `changing` are the keys of quantities that do not repeat after a cycle, which have no averages.
    Raises InputError for limits on unknown quantities, ComputationError without a cycle.
    """
    stated = StatedGoal.read(machine)
    goal, x, results = Goal(stated.machine, (), stated.limits), stated.machine.design, []
    for limit in goal.limits:
        result, parts = (
            _evaluate_limit(goal, x, limit),
            stated.machine.list_parts(limit.measure.name),
        )
        is_changing = any(stated.machine.find_quantity(part).key in changing for part in parts)
        averaged = limit.measure.kind in AVERAGES and is_changing
        results.append(replace(result, value=None, active=False, met=False) if averaged else result)
    return results


def judge_motion(motion: MechanismMotion, machine: Machine) -> MechanismMotion:
    """Return a motion with the limits of its machine's file. Raises as `evaluate_limits`."""
    holds = evaluate_limits(machine)
    met = all(hold.met for hold in holds)
    return replace(motion, result=replace(motion.result, holds=holds, met=met))


def list_limit_checks(machine: Machine, results: Sequence[LimitResult]) -> list[RequirementCheck]:
    """Return the limits of a machine with their results as a page has them."""
    checks = []
    for limit, result in zip(machine.limits, results, strict=True):
        margin = None if result.value is None else limit.sign * (result.limit - result.value)
        lower, upper = (None, result.limit) if limit.sign > 0 else (result.limit, None)
        words = to_sentence_case(describe_measure(machine, limit.measure))
        checks.append(
            RequirementCheck(
                str(limit.measure),
                result.unit,
                result.value,
                margin,
                result.met,
                lower,
                upper,
                words,
            )
        )
    return checks


def with_front(optimum: MechanismOptimum, listener: Listener | None = None) -> MechanismOptimum:
    """Return an optimum with the Pareto front, from the smallest range to the smallest variance.

    Raises InputError as `require_front`.
    """
    machine = optimum.problem.machine
    name = require_front(optimum.problem)
    front = []
    for least_range, variance, x in trace_front(machine, name, optimum.problem.sampling, listener):
        design = dict(zip(machine.design_names, (x / machine.scale).tolist(), strict=True))
        front.append(FrontDesign(least_range, variance, design))
    return replace(optimum, result=replace(optimum.result, front=front))


def _evaluate_limit(goal: Goal, x: Array, limit: Limit, active: bool | None = None) -> LimitResult:
    """Return a limit with its value; without a certificate it is active if it is reached to
    rounding.
    """
    value = goal.evaluate_limit(x, limit)
    margin = (
        float("inf") if value is None else limit.sign * (limit.number - value) / goal.step(limit)
    )
    return LimitResult(
        limit_on=str(limit),
        value=value,
        limit=limit.number,
        active=abs(margin) <= FEASIBILITY_TOLERANCE if active is None else active,
        met=margin >= -FEASIBILITY_TOLERANCE,
        unit=find_display_unit(goal.machine, limit.measure).text,
    )


def _record(
    machine: Machine, words: str, stated: StatedGoal, optimum: DesignOptimum, begun: float
) -> MechanismOptimum:
    problem, x, reached = optimum.problem, optimum.x, optimum.result
    goal, certificate = problem.goal, reached.certificate
    design, start_design, best = _place_design(machine, x)
    prices = {
        constraint.name: constraint.multiplier for constraint in certificate.active_constraints
    }
    holds = [
        replace(
            _evaluate_limit(goal, x, limit, str(limit) in prices), price=prices.get(str(limit), 0.0)
        )
        for limit in goal.limits
    ]
    directions = find_directions(best, stated.objective, machine.samples)
    result = MechanismOptimumResult(
        machine=machine.name,
        method=reached.method,
        least=words,
        objective=reached.objective,
        start_objective=reached.start_objective,
        design=design,
        start_design=start_design,
        holds=holds,
        met=all(hold.met for hold in holds),
        certificate=certificate,
        evaluations=reached.evaluations,
        samples=goal.samples,
        seconds=time.perf_counter() - begun,
        effective_parameters=directions.effective_parameters,
        insensitive=directions.named,
        searches=reached.searches,
        wider=reached.wider,
    )
    return MechanismOptimum(x, best, problem, result, stated)


def compute_objective_sensitivity(
    machine: Machine | HasMachine,
    samples: int | None = None,
    least: str | None = None,
    all_values: bool = False,
) -> SensitivityResult:
    """Return the sensitivity of a file's objective, or of the sum `least`, in the values that have
    bounds, or in all.

    Without `samples` it is that of true extremes, unless the file asks for samples. Raises
    InputError for a file without a sum or bounds; ComputationError for the mean of what does not
    repeat after a cycle.
    """
    machine = to_machine(machine)
    check_samples(samples)
    goal = StatedGoal.read(machine, least)
    machine = goal.machine
    goal.require_objective()
    if not (machine.moved or all_values):
        raise InputError(
            f"{machine.source}: none of its values has bounds: ask for all values by --all"
        )
    if samples is None and machine.sampling != "refined":
        samples = machine.sampling
    return compute_sensitivity(
        move_all(machine) if all_values else machine, goal.objective, samples
    )
