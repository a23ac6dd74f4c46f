"""What a search for a design is given: the problem under its constraints, a point that keeps them, its task."""

from __future__ import annotations

from collections.abc import Callable

from planter.engine import search
from planter.engine.problem import CurveProblem
from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise.constraints import KEPT, Constraints, joined
from planter.optimise.descent import Minimum, descend
from planter.optimise.feasible import MOST_TRIED, nearest
from planter.optimise.problem import Problem
from planter.optimise.range_and_spread import Sampling
from planter.optimise.starts import Descent, nearer, points
from planter.parallel.task import Task
from planter.planting import objective
from planter.planting.file import Machine
from planter.planting.functions import Model
from planter.planting.model import Device
from planter.planting.requirements.constraints import Required
from planter.planting.requirements.verdict import infeasible
from planter.planting.whole.lengths import Lengths
from planter.planting.whole.wanted import Wanted


def problem(
    device: Device, sampling: Sampling, required: Required | None, lengths: Lengths | None = None
) -> CurveProblem:  # fmt: skip
    """Return the problem of a device under its requirements and lengths of pitch curves, where there are any."""
    parts: list[Constraints | None] = [required, lengths]
    return objective.problem(device, sampling, joined([part for part in parts if part is not None]))


def kept(task: Problem, required: Required | None, seed: int, lengths: Lengths | None = None) -> Array:
    """A point u (p,) that keeps the constraints of a problem.

    Raises Infeasible, with the least violation, where there is none, ComputationError where not even one with the
    lengths was found.
    """
    assert task.constraints is not None
    least = nearest(task, task.constraints, points(task, MOST_TRIED, seed))
    if least.kept:
        return least.u
    of = "" if lengths is None else f" with {lengths.wanted}"
    if required is None or least.excess[: len(required.kinds)].max() <= KEPT:
        raise ComputationError(f"no design{of} was found within the bounds")
    raise infeasible(required, task.design(least.u), least, of)


def beside_design(task: Problem, x: Array) -> Minimum:
    """The local minimum beside a design x (p,)."""
    return descend(task, nearer(task, task.box.point(x)))


def build_task(device: Device, sampling: Sampling, lengths: Lengths | None = None) -> Task:
    """Return the descents on a device's problem, from points (p,), as workers run them."""
    arguments = {"machine": device.machine, "model": device.model, "sampling": sampling, "compiled": device.compiled,
                 "wanted": None if lengths is None else lengths.wanted}  # fmt: skip
    return Task(prepare_descents, arguments)


def prepare_descents(
    machine: Machine, model: Model, sampling: Sampling, compiled: bool, wanted: Wanted | None
) -> Callable[[Array], Descent]:
    """Return the function that descends from a point (p,), with kernels compiled if asked for, whole teeth if any."""
    device = Device(machine, model)
    if compiled:
        device.compile(sampling == "refined")
    lengths = None if wanted is None else Lengths(device, wanted)
    return search.prepare_descents(problem(device, sampling, Required.of(device), lengths))
