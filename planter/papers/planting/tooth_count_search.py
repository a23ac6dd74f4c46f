"""`planter optimise` with integer tooth numbers: the best numbers, the design for them, and their
price.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from planter.engine.solvers.certificate import ActiveConstraint
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.local_search import AGREEMENT_TOLERANCE, STATIONARITY_TOLERANCE
from planter.engine.solvers.optimiser import Method
from planter.errors import ComputationError, GeometryError
from planter.gears.geometry import cutting
from planter.gears.geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gears.geometry.pitch_curves import build_stage_pair
from planter.kernels import Array
from planter.papers.planting import optimisation
from planter.papers.planting.design_results import (
    ToothCountCandidate,
    ToothCountGear,
    ToothCountResult,
    ToothCountStage,
)
from planter.papers.planting.model import Device
from planter.papers.planting.objective import build_problem
from planter.papers.planting.optimisation import (
    DeviceOptimum,
    Optimisation,
    OptimisationInterrupted,
    Table,
)
from planter.papers.planting.requirements import RequirementConstraints
from planter.papers.planting.tooth_counts import (
    PitchLengthConstraints,
    PitchLengthRange,
    ToothCountSpec,
    compute_length_ranges,
    constraint_name,
)
from planter.papers.planting.toothed import NAMES, SENSES
from planter.progress import Listener, ProgressPhase
from planter.task import AUTO, Means

ToothCounts = tuple[int, ...]
"""Tooth numbers, one for each stage that has a module."""


class ToothCountSearch:
    """Search for tooth numbers near a free optimum (p,), each judged by one local search from
    there.

    The tooth numbers of `constraints` do not count.
    """

    def __init__(
        self,
        constraints: PitchLengthConstraints,
        free: Array,
        sampling: Sampling,
        progress: Listener | None = None,
    ) -> None:
        self.constraints, self.free, self.sampling, self.progress = (
            constraints,
            free,
            sampling,
            progress,
        )
        self.required = RequirementConstraints.from_device(constraints.device)
        self.candidates: dict[ToothCounts, ToothCountCandidate] = {}

    def run(self) -> ToothCountSpec:
        """Return the numbers that no permitted neighbour on one stage improves; the bounds must
        permit some.
        """
        ranges = compute_length_ranges(self.constraints)
        lengths = self.constraints.lengths(self.free)
        counts = tuple(
            bounds.find_tooth_count(length) for bounds, length in zip(ranges, lengths, strict=True)
        )
        while True:
            choices = [counts, *generate_neighbours(counts, ranges)]
            self._evaluate([choice for choice in choices if choice not in self.candidates])
            best = min(choices, key=self._rank)
            if not self._is_better(best, counts):
                return self.constraints.spec.with_teeth(counts)
            counts = best

    def _evaluate(self, choices: list[ToothCounts]) -> None:
        phase = ProgressPhase("teeth", "choice", len(choices), self.progress)
        for counts in choices:
            self.candidates[counts] = self._search_design(counts)
            phase.advance(",".join(map(str, counts)))

    def _search_design(self, counts: ToothCounts) -> ToothCountCandidate:
        constraints = self.constraints.with_spec(self.constraints.spec.with_teeth(counts))
        task = build_problem(constraints.device, self.sampling, self.required, constraints)
        try:
            minimum = optimisation.search_from_design(task, self.free)
        except ComputationError:
            return ToothCountCandidate(list(counts), None, None, settled=False)
        feasible = task.is_feasible(minimum.u)
        return ToothCountCandidate(
            list(counts),
            minimum.objective if feasible else None,
            minimum.residual,
            settled=feasible and minimum.residual < STATIONARITY_TOLERANCE,
        )

    def _rank(self, counts: ToothCounts) -> tuple[bool, float]:
        candidate = self.candidates[counts]
        return (
            not candidate.settled,
            math.inf if candidate.objective is None else candidate.objective,
        )

    def _is_better(self, counts: ToothCounts, reference: ToothCounts) -> bool:
        """Return whether tooth numbers are better by more than two local searches may differ."""
        (unsettled, objective), bar = self._rank(counts), self._rank(reference)
        return (unsettled, objective + AGREEMENT_TOLERANCE * abs(objective)) < bar


def generate_neighbours(
    counts: ToothCounts, ranges: Sequence[PitchLengthRange]
) -> Iterator[ToothCounts]:
    """Yield the permitted tooth numbers that differ by one on one stage."""
    for k, bounds in enumerate(ranges):
        for z in (counts[k] - 1, counts[k] + 1):
            if z in bounds.teeth:
                yield (*counts[:k], z, *counts[k + 1 :])


def evaluate_stages(
    constraints: PitchLengthConstraints, x: Array, free: Array, active: Sequence[ActiveConstraint]
) -> list[ToothCountStage]:
    """Return the stages of an optimum x (p,) with its active constraints, compared with a free
    optimum (p,).
    """
    spec, stages = constraints.spec, []
    slopes = {limit.name: limit.multiplier * (-1 if limit.side == "max" else 1) for limit in active}
    errors = constraints.values(x) / constraints.upper - 1
    lengths = zip(
        spec.stages, constraints.lengths(x), constraints.lengths(free), errors, strict=True
    )
    for k, length, free_length, error in lengths:
        z, module = spec.teeth[k] or 0, spec.modules[k] or 0.0
        pair, refusal = _cut_stage(
            constraints, k, x, ToothOrder(teeth=z, module=module, keep="module")
        )
        gears = (
            None
            if pair is None
            else [
                ToothCountGear(
                    gear.name,
                    gear.z,
                    float(gear.flanks.margins.min()),
                    float(gear.top_lands.min()) * 1e3,
                )
                for gear in pair.gears
            ]
        )
        per_length = slopes.get(constraint_name(k), 0.0)
        stages.append(
            ToothCountStage(
                stage=k + 1,
                z=z,
                module_mm=1e3 * module,
                pitch_length_mm=1e3 * length,
                length_error=float(error),
                free_teeth=free_length / spec.circular_pitch(k),
                price_per_module_mm=per_length * np.pi * z,
                price_per_tooth=per_length * 1e3 * spec.circular_pitch(k),
                gears=gears,
                contact_ratio_min=None if pair is None else float(pair.mesh.contact_ratios.min()),
                refused=refusal,
            )
        )
    return stages


def _cut_stage(
    constraints: PitchLengthConstraints, stage: int, x: Array, order: ToothOrder
) -> tuple[ToothedPair | None, str | None]:
    """Return the teeth of a stage, None if they cannot be cut at all, and the reason if not as
    ordered.
    """
    device = constraints.device
    pair = build_stage_pair(device.stages[stage], device.of_stage(stage, x), SENSES[stage])
    refusal = None
    for attempt in (order, replace(order, process="wire", allow_undercut=True)):
        try:
            teeth = cut_teeth(pair, attempt, f"stage {stage + 1}", NAMES[stage])
            cutting.check_penetration(teeth.mesh, teeth.deepest, teeth.name)
            return teeth, refusal
        except GeometryError as error:
            refusal = refusal or str(error)
    return None, refusal


def optimise_with_tooth_counts(
    device: Device,
    spec: ToothCountSpec | None,
    method: Method = "auto",
    samples: str | None = None,
    seed: int = 0,
    starts: int | None = None,
    progress: Listener | None = None,
    keep: Callable[[Table], None] | None = None,
    means: Means = AUTO,
) -> Optimisation:
    """Return the best design of a device with integer tooth numbers; without `spec` as
    `optimisation.optimise`.

    Missing tooth numbers are searched for. Raises InputError if the bounds do not permit the
    numbers, InfeasibleRequirementsError if no design with them satisfies the requirements.
    """
    if spec is None:
        return optimisation.optimise(
            device, method, samples, seed, starts, progress, keep, means=means
        )
    begin = time.perf_counter()
    _check_feasibility(device, spec, seed)
    free = optimisation.optimise(device, method, samples, seed, starts, progress, means=means)
    device, optimum, candidates = free.devices[device.model], free.optimum, None
    sampling, constraints = optimum.sampling, PitchLengthConstraints(device, spec)
    try:
        if not spec.is_complete:
            count_search = ToothCountSearch(constraints, optimum.design, sampling, progress)
            constraints = constraints.with_spec(count_search.run())
            candidates = list(count_search.candidates.values())
        nearby = [optimum.design]
        optimum = optimisation.search_optimum(
            device, method, sampling, seed, starts, progress, keep, constraints, nearby, means
        )
        return _add_tooth_counts(
            optimisation.evaluate_in_both_models(device, optimum),
            free.optimum,
            constraints,
            candidates,
            begin,
        )
    except KeyboardInterrupt:
        raise OptimisationInterrupted(optimum, device) from None


def _check_feasibility(device: Device, spec: ToothCountSpec, seed: int) -> None:
    """Raise InputError or InfeasibleRequirementsError, before any search, if no design has the
    tooth numbers.
    """
    constraints, required = (
        PitchLengthConstraints(device, spec),
        RequirementConstraints.from_device(device),
    )
    for bounds in compute_length_ranges(constraints):
        bounds.check(spec.teeth[bounds.stage])
    if required is not None and spec.is_complete:
        task = build_problem(device, device.machine.objective.samples, required, constraints)
        optimisation.find_feasible_point(task, required, seed, constraints)


def _add_tooth_counts(
    scored: Optimisation,
    free: DeviceOptimum,
    constraints: PitchLengthConstraints,
    candidates: list[ToothCountCandidate] | None,
    begin: float,
) -> Optimisation:
    """Return an optimum with the limits and the price of its tooth numbers; the searches began at
    `begin` [s].
    """
    device, optimum = constraints.device, scored.optimum
    x, objective = _find_free_optimum(device, free, optimum)
    price = optimum.objective - objective
    teeth = ToothCountResult(
        stages=evaluate_stages(
            constraints, optimum.design, x, optimum.certificate.active_constraints
        ),
        free_objective=objective,
        free_design=device.named(x),
        price=price,
        tried=candidates,
        seconds=time.perf_counter() - begin,
    )
    cost = f"{constraints.spec} raise the objective by {price:.4g}, {100 * price / objective:.3g} %"
    statement = f"{scored.result.statement}; {cost}"
    return replace(scored, result=replace(scored.result, statement=statement, teeth=teeth))


def _find_free_optimum(
    device: Device, free: DeviceOptimum, optimum: DeviceOptimum
) -> tuple[Array, float]:
    """Return the free optimum (p,) and its objective.

    A constrained optimum that is better shows that the free search missed one: it is then repeated
    from there.
    """
    if optimum.objective >= free.objective:
        return free.design, free.objective
    task = build_problem(device, free.sampling, RequirementConstraints.from_device(device))
    minimum = optimisation.search_from_design(task, optimum.design)
    return task.design(minimum.u), minimum.objective
