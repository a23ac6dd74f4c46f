"""Optimisation of a planting device: least range and scatter of its support force within bounds and
requirements.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from planter import errors
from planter.engine import search
from planter.engine.front import trace_front
from planter.engine.machine import check_samples
from planter.engine.problem import DesignProblem
from planter.engine.search import (
    CandidateDesign,
    DesignOptimum,
    FailedSearchError,
    InterruptedSearch,
    SearchSpec,
    minimise,
)
from planter.engine.sections import HOLD, LEAST
from planter.engine.sensitivity import find_directions
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.curve_sum import DIRECTION_ANGLES, Sampling
from planter.engine.solvers.feasibility import (
    MAX_ELASTIC_STARTS,
    ViolationMinimum,
    find_feasible_or_nearest,
)
from planter.engine.solvers.local_search import (
    DEFAULT_STARTS,
    STATIONARITY_TOLERANCE,
    Descent,
    LocalMinimum,
    SearchRecord,
    sample_starts,
    search_locally,
    select_start,
)
from planter.engine.solvers.optimiser import Method
from planter.engine.solvers.problem import Problem
from planter.engine.solvers.result import OptimiserResult
from planter.errors import ComputationError, InputError, PlanterError
from planter.files.record import build_frame
from planter.kernels import Array
from planter.papers.planting.design_summary import summarise_design
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import FORCE, Device
from planter.papers.planting.objective import (
    build_problem,
    evaluate_samples,
    evaluate_true_extremes,
)
from planter.papers.planting.requirements import RequirementConstraints, build_infeasibility_error
from planter.papers.planting.results import (
    FrontPoint,
    OptimisationFound,
    OptimumFound,
    RequirementResult,
    SampledScore,
    Scores,
    TrueExtremes,
)
from planter.papers.planting.tooth_counts import PitchLengthConstraints, ToothCountSpec
from planter.progress import Listener
from planter.report.labels import count_things
from planter.task import AUTO, Means, Task

if TYPE_CHECKING:
    from pandas import DataFrame


def find_feasible_point(
    task: DesignProblem,
    required: RequirementConstraints | None,
    seed: int,
    lengths: PitchLengthConstraints | None = None,
) -> Array:
    """Return a point u (p,) that satisfies the constraints of a problem.

    Raises InfeasibleRequirementsError, with the smallest violation, if no point does,
    ComputationError if not even one with the lengths was found.
    """
    assert task.constraints is not None
    starts = sample_starts(task, MAX_ELASTIC_STARTS, seed)
    nearest_point = find_feasible_or_nearest(task, task.constraints, starts)
    if nearest_point.is_feasible:
        return nearest_point.u
    raise _build_error(task, required, nearest_point, len(starts), lengths)


def _build_error(
    task: DesignProblem,
    required: RequirementConstraints | None,
    closest: ViolationMinimum,
    starts: int,
    lengths: PitchLengthConstraints | None,
) -> PlanterError:
    """Return the error for the smallest violation that searches from some `starts` ended with."""
    suffix = "" if lengths is None else f" with {lengths.spec}"
    if required is None or closest.excess[: len(required.kinds)].max() <= FEASIBILITY_TOLERANCE:
        return ComputationError(
            f"no design{suffix} was found within the bounds, from {count_things(starts, 'start')}"
        )
    return build_infeasibility_error(required, task, closest, starts, suffix)


def search_from_design(task: Problem, x: Array) -> LocalMinimum:
    """Return the local minimum that a local search from a design x (p,) reaches."""
    return search_locally(task, select_start(task, task.box.point(x)))


def build_descent_task(
    device: Device, sampling: Sampling, lengths: PitchLengthConstraints | None = None
) -> Task:
    """Return the descents on a device's problem, from points (p,), as workers run them."""
    arguments = {
        "machine": device.machine,
        "model": device.model,
        "sampling": sampling,
        "tooth_counts": None if lengths is None else lengths.spec,
    }
    return Task(prepare_device_descents, arguments)


def prepare_device_descents(
    machine: PlantingMachine,
    model: Model,
    sampling: Sampling,
    tooth_counts: ToothCountSpec | None,
) -> Callable[[Descent], SearchRecord]:
    """Return the function that descends from a point (p,), with whole teeth if any."""
    device = Device(machine, model)
    lengths = None if tooth_counts is None else PitchLengthConstraints(device, tooth_counts)
    return search.prepare_descents(
        build_problem(device, sampling, RequirementConstraints.from_device(device), lengths)
    )


@dataclass(frozen=True, kw_only=True)
class DeviceOptimum(OptimiserResult):
    """A device's optimum: `design` x (p,) in SI, with the range and the scatter of the force there.

    `insensitive` spans the directions in which the force does not change at the optimum, each
    [{name: weight}, ...] in parts of the box width: along these the design is not determined.
    """

    sampling: Sampling
    score: SampledScore | TrueExtremes
    effective_parameters: int
    insensitive: list[list[dict[str, float]]]
    requirements: list[RequirementResult]

    def build_record(self, device: Device) -> OptimumFound:
        """The optimum as results show it."""
        return OptimumFound(
            method=self.method,
            samples=self.sampling,
            objective=self.objective,
            design=device.named(self.design),
            range_N=self.score.range_N,
            variance_N2=self.score.variance_N2,
            start_objective=self.start_objective,
            evaluations=self.evaluations,
            seconds=self.seconds,
            certificate=self.certificate,
            effective_parameters=self.effective_parameters,
            insensitive=self.insensitive,
            requirements=self.requirements or None,
            searches=self.searches,
            wider=self.wider,
        )


Table = dict[str, Any]
"""What is known of an unfinished search, as the interface gives it."""


class OptimisationInterrupted(errors.Interrupted):
    """The user stopped an optimisation; `best` is the result so far, None if nothing feasible was
    evaluated yet.

    `partial` is that result, or else the table of the closest design if there is one.
    """

    def __init__(
        self, best: DeviceOptimum | None, device: Device, closest: Table | None = None
    ) -> None:
        super().__init__(closest if best is None else best.build_record(device).table())
        self.best = best


def search_optimum(
    device: Device,
    method: Method = "auto",
    samples: Sampling = "refined",
    seed: int = 0,
    starts: int | None = None,
    progress: Listener | None = None,
    keep: Callable[[Table], None] | None = None,
    lengths: PitchLengthConstraints | None = None,
    nearby: Sequence[Array] = (),
    means: Means = AUTO,
) -> DeviceOptimum:
    """The best design of a device within its bounds, with its certificate.

    `samples` is "refined" for true extremes and integrals, or a number of angles of a cycle.
    `starts` is the number of descents, `progress` hears how far the search is, `keep` gets the best
    so far as it is found. With `lengths` the pitch curves have these, for whole teeth; minima next
    to the designs `nearby`, (p,) each, count too. `means` says what runs the descents, whose
    results do not depend on it.

    Raises InputError for an unknown method, InfeasibleRequirementsError if no design satisfies the
    requirements, and Interrupted, with the best so far, on KeyboardInterrupt.
    """
    for key, measures in (
        (HOLD, device.machine.measure_limits),
        (LEAST, device.machine.objective_terms),
    ):
        if measures:
            reason = "planter optimise and optimise_machine search with measures, this does not"
            raise InputError(f"{device.machine.source}: {key}: {reason}")
    start_s, required = time.perf_counter(), RequirementConstraints.from_device(device)
    task = build_problem(device, samples, required, lengths)
    spec = SearchSpec(
        samples, method, starts or DEFAULT_STARTS, seed, device.machine.genetic_algorithm
    )

    def build_optimum(best: DesignOptimum) -> DeviceOptimum:
        result = replace(best.result, seconds=time.perf_counter() - start_s)
        return _build_optimum(device, required, lengths, samples, result)

    def build_table(candidate: CandidateDesign) -> Table:
        score = evaluate_force(device, candidate.x, samples)
        return {
            "machine": device.machine.name,
            "model": device.model,
            "method": method,
            "samples": samples,
            "seed": seed,
            "objective": candidate.objective,
            "design": device.named(candidate.x),
            "range_N": score.range_N,
            "variance_N2": score.variance_N2,
            "start_objective": task.reference.objective,
            "seconds": candidate.seconds,
            "met": candidate.is_feasible,
            "violated": None if candidate.is_feasible else candidate.violated,
        }

    def hand_over(candidate: CandidateDesign) -> None:
        if keep is not None:
            keep(build_table(candidate))

    def build_closest() -> Table | None:
        """Return the closest design that the search for a feasible one has met."""
        if task.closest is None:
            return None
        x, seconds = task.design(task.closest.u), time.perf_counter() - start_s
        return build_table(
            CandidateDesign(x, task.score(x).objective, task.closest.violation, seconds)
        )

    try:
        feasible = [search_from_design(task, x).u for x in nearby]
        feasible = [u for u in feasible if task.is_feasible(u)]
        descents = build_descent_task(device, samples, lengths)
        return build_optimum(
            minimise(task, spec, progress, descents, means, feasible, keep and hand_over)
        )
    except FailedSearchError as error:
        if error.candidate is None or error.candidate.closest is None:
            raise
        raise _build_error(task, required, error.candidate.closest, spec.starts, lengths) from None
    except InterruptedSearch as stop:
        best = None if stop.best is None else build_optimum(stop.best)
        closest = None if stop.candidate is None else build_table(stop.candidate)
        raise OptimisationInterrupted(best, device, closest or build_closest()) from None
    except KeyboardInterrupt:
        raise OptimisationInterrupted(None, device, build_closest()) from None


def _build_optimum(
    device: Device,
    required: RequirementConstraints | None,
    lengths: PitchLengthConstraints | None,
    sampling: Sampling,
    result: OptimiserResult,
) -> DeviceOptimum:
    x, machine = result.design, device.force.machine
    equation_gradients = None if lengths is None else lengths.slopes(x)
    placed = replace(machine, data=machine.build_data(x))
    count = DIRECTION_ANGLES if sampling == "refined" else sampling
    directions = find_directions(placed, machine.objective, count, equation_gradients)
    return DeviceOptimum(
        **vars(result),
        sampling=sampling,
        score=evaluate_force(device, x, sampling),
        effective_parameters=directions.effective_parameters,
        insensitive=directions.named,
        requirements=[] if required is None else required.record(x),
    )


def evaluate_force(device: Device, x: Array, sampling: Sampling) -> SampledScore | TrueExtremes:
    """Return range and scatter of the force of a design x (p,), true or over samples."""
    if sampling == "refined":
        return evaluate_true_extremes(device, x)
    return evaluate_samples(device, x, sampling)


@dataclass(frozen=True)
class Optimisation:
    """An optimum, the devices of the models by name, and the result as the interface returns it."""

    optimum: DeviceOptimum
    devices: dict[str, Device]
    result: OptimisationFound
    certificate: str | None = None
    """The text of the file of its proof, if it has one."""

    def show(self) -> Any:
        """Return a notebook widget that animates the optimum, with the path of the tip before.

        Raises InputError where anywidget is missing.
        """
        from planter.papers.planting.report.scene import build_scene
        from planter.report.animation import build_widget

        device = self.devices[self.result.model]
        return build_widget(build_scene(device, self.optimum.design, device.design))

    def to_frame(self) -> DataFrame:
        """The design before and after as a table of pandas, a row for each parameter, values in the
        unit [of its name].

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        start, best = self.result.start_design, self.result.design
        return build_frame(
            [{"parameter": name, "start": start[name], "optimum": best[name]} for name in best]
        )

    def _repr_html_(self) -> str:
        return self.result._repr_html_()


def optimise(
    device: Device,
    method: Method = "auto",
    samples: str | None = None,
    seed: int = 0,
    starts: int | None = None,
    progress: Listener | None = None,
    keep: Callable[[Table], None] | None = None,
    means: Means = AUTO,
) -> Optimisation:
    """The best design of a device within its bounds; `keep` is handed the best so far as it is
    found.

    `samples` is "refined", the default, for true extremes and integrals, or a number of angles of a
    cycle. Raises InputError for `samples` that are neither, Interrupted with what was found so far
    when the user stops the search.
    """
    sampling = parse_sampling(samples)
    optimum = search_optimum(device, method, sampling, seed, starts, progress, keep, means=means)
    try:
        return evaluate_in_both_models(device, optimum)
    except KeyboardInterrupt:
        raise OptimisationInterrupted(optimum, device) from None


def add_pareto_front(optimisation: Optimisation, progress: Listener | None = None) -> Optimisation:
    """Return the optimum with the Pareto front from the smallest range to the smallest variance."""
    device = optimisation.devices[optimisation.result.model]
    front = trace_front(device.force.machine, FORCE, optimisation.optimum.sampling, progress)
    points = [FrontPoint(a, b, device.named(x)) for a, b, x in front]
    return replace(optimisation, result=replace(optimisation.result, front=points))


def evaluate_in_both_models(device: Device, optimum: DeviceOptimum) -> Optimisation:
    """Return an optimum and the design it started from, evaluated in both models."""
    sampling, record = optimum.sampling, optimum.build_record(device)
    devices: dict[str, Device] = {
        model: device if model == device.model else Device(device.machine, model)
        for model in MODELS
    }
    starts, ends = (
        {model: evaluate_force(other, x, sampling) for model, other in devices.items()}
        for x in (device.design, optimum.design)
    )
    start = starts[device.model]
    result = OptimisationFound(
        machine=device.machine.name,
        model=device.model,
        **vars(record),
        sampled=evaluate_samples(device, optimum.design),
        refined=evaluate_true_extremes(device, optimum.design),
        seed=optimum.seed,
        start_design=device.named(device.design),
        start_range_N=start.range_N,
        start_variance_N2=start.variance_N2,
        cross={model: Scores(starts[model].objective, ends[model].objective) for model in devices},
        statement=describe_optimum(start.range_N, record, device.size),
        designer=summarise_design(device, optimum.design),
        start_designer=summarise_design(device, device.design),
    )
    return Optimisation(optimum, devices, result)


def describe_optimum(start_range_N: float, record: OptimumFound, parameters: int) -> str:
    """Return an optimisation in one sentence: the range before and after, how certain it is, and
    what limits it.
    """
    share = 100 * (record.range_N / start_range_N - 1)
    proof = record.certificate
    names = {requirement.name for requirement in record.requirements or ()}
    active = [each for each in proof.active_constraints if each.name in names]
    sure = proof.kkt_residual < STATIONARITY_TOLERANCE and (
        proof.agreeing_starts > 1 or not proof.starts
    )
    parts = [f"{len(proof.active_bounds)} of {parameters} parameters at a bound"]
    if record.requirements is not None:
        parts.append(count_things(len(active), "active requirement"))
    if not sure:
        parts.append(
            f"KKT residual {proof.kkt_residual:.1e}, {proof.agreeing_starts} of {proof.starts} "
            f"starts agree"
        )
    word = "certified" if sure else "not certified"
    over = "" if record.samples == "refined" else f" over {record.samples} samples"
    return (
        f"range {start_range_N:#.4g} to {record.range_N:#.4g} N{over}, {share:+.1f} %, {word}; "
        f"{'; '.join(parts)}"
    )


def parse_sampling(text: str | None) -> Sampling:
    """A number of samples of a cycle, or "refined", the default, for its true extremes and
    integrals.
    """
    if text is None or text == "refined":
        return "refined"
    try:
        samples = int(text)
    except ValueError:
        allowed = "it must be a number of angles or refined"
        raise InputError.for_value("--samples", text, allowed) from None
    check_samples(samples)
    return samples
