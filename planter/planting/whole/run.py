"""`planter optimise` with whole teeth: the best design whose gears have them, beside the best without that care."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from planter.kernels import Array
from planter.optimise.hybrid import Method
from planter.parallel.task import AUTO, Means
from planter.planting import optimisation
from planter.planting.model import Device
from planter.planting.optimisation import DeviceOptimum, Optimisation, OptimisationInterrupted, Table
from planter.planting.requirements.constraints import Required
from planter.planting.whole import made
from planter.planting.whole.choice import Choice
from planter.planting.whole.extent import extents
from planter.planting.whole.lengths import Lengths
from planter.planting.whole.results import TriedTeeth, WholeTeeth
from planter.planting.whole.wanted import Wanted
from planter.progress import Listener


def optimise(
    device: Device,
    wanted: Wanted | None,
    method: Method = "hybrid",
    samples: str | None = None,
    seed: int = 0,
    starts: int | None = None,
    progress: Listener | None = None,
    keep: Callable[[Table], None] | None = None,
    means: Means = AUTO,
) -> Optimisation:
    """The best design of a device with whole teeth, if any are wanted; all else as `optimisation.optimise`.

    Teeth that are not given are chosen. Raises InputError where the bounds do not permit the teeth, Infeasible where no
    design with them keeps the requirements.
    """
    if wanted is None:
        return optimisation.optimise(device, method, samples, seed, starts, progress, keep, means=means)
    begun = time.perf_counter()
    _check(device, wanted, seed)
    free = optimisation.optimise(device, method, samples, seed, starts, progress, means=means)
    device, sampling = free.devices[device.model], free.found.sampling
    reached, lengths, tried = free.found, Lengths(device, wanted), None
    try:
        if not wanted.settled:
            choice = Choice(lengths, free.found.design, sampling, progress)
            lengths = lengths.of(choice.run())
            tried = list(choice.tried.values())
        near = [free.found.design]
        reached = optimisation.search_optimum(
            device, method, sampling, seed, starts, progress, keep, lengths, near, means
        )
        return _with_teeth(optimisation.evaluate_in_both_models(device, reached), free.found, lengths, tried, begun)
    except KeyboardInterrupt:
        raise OptimisationInterrupted(reached, device.scale) from None


def _check(device: Device, wanted: Wanted, seed: int) -> None:
    """Raise InputError or Infeasible for teeth that no design has, before anything is searched for."""
    lengths, required = Lengths(device, wanted), Required.of(device)
    for extent in extents(lengths):
        extent.check(wanted.teeth[extent.stage])
    if required is not None and wanted.settled:
        optimisation.find_feasible_point(
            optimisation.build_constrained_problem(device, device.machine.objective.samples, required, lengths),
            required,
            seed,
            lengths,
        )


def _with_teeth(
    scored: Optimisation, free: DeviceOptimum, lengths: Lengths, tried: list[TriedTeeth] | None, begun: float
) -> Optimisation:
    """An optimum with whole teeth, with their limits and their price beside the free one; `begun` is when [s]."""
    device, found = lengths.device, scored.found
    x, objective = _free(device, free, found)
    price = found.objective - objective
    teeth = WholeTeeth(
        stages=made.stages(lengths, found.design, x, found.certificate.active_constraints),
        free_objective=objective,
        free_design=device.named(x),
        price=price,
        tried=tried,
        seconds=time.perf_counter() - begun,
    )
    cost = f"{lengths.wanted} raise the objective by {price:.4g}, {100 * price / objective:.3g} %"
    said = f"{scored.result.statement}; {cost}"
    return replace(scored, result=replace(scored.result, statement=said, teeth=teeth))


def _free(device: Device, free: DeviceOptimum, found: DeviceOptimum) -> tuple[Array, float]:
    """The free optimum (p,) and its objective: better than one with whole teeth, or it is looked for beside that."""
    if found.objective >= free.objective:
        return free.design, free.objective
    task = optimisation.build_constrained_problem(device, free.sampling, Required.of(device))
    below = optimisation.search_from_design(task, found.design)
    return task.design(below.u), below.objective
