"""The objective (31) of Wang et al. (2017) over a cycle: over true extremes, over samples, and of
many designs.

from planter import Device, Turns, evaluate_many, load_machine, load_mechanism

device = Device(load_machine("wang2017"))
value, gradient = Turns(device).gradient(device.design)

batch = evaluate_many(device, designs)      # designs (m, p) in SI: an array, a memory map
best = designs[batch.objective.argmin()]

own = load_mechanism("own/slider_crank.toml")
rows = evaluate_many(own, designs, gradients=True, outputs=["M_in_rms_Nm"])
rows["M_in_rms_Nm"], rows.gradient          # (m,), (m, 1, p)
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from planter.engine.cycles import Cycles, Memory
from planter.engine.goal import Goal
from planter.engine.machine import Machine
from planter.engine.outputs import CHUNK, OBJECTIVE, OutputBatch, SampledOutputs, evaluate_outputs
from planter.engine.problem import DesignProblem
from planter.engine.solvers.constraints import Constraints
from planter.engine.solvers.curve_sum import CurveSide
from planter.engine.solvers.cycle_panels import CyclePanels
from planter.engine.solvers.joined import JoinedObjective
from planter.engine.solvers.objective import find_hessian
from planter.engine.solvers.range_variance import Sampling
from planter.engine.solvers.response import ONE_SIDED_OFFSET
from planter.engine.solvers.sampled_cycle import sample_angles
from planter.errors import ComputationError, PlanterError
from planter.files.record import build_frame, format_table
from planter.kernels import Array, CallError
from planter.numerics.statistics import Statistic
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.results import SampledScore, TrueExtremes
from planter.progress import Listener, ProgressPhase

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True)
class Weights:
    """Weights of the objective weight_range * range + weight_variance * scatter.

    The scatter is the population variance [N2] for kind "paper", which is equation (31) as
    published although it adds N to N2, and the standard deviation [N] for kind "newton".
    """

    weight_range: float
    weight_variance: float
    kind: Literal["paper", "newton"]

    def weighted(self, variance: Any, sqrt: Callable[[Any], Any] = math.sqrt) -> Any:
        """Return the weighted scatter of a variance [N2]: a float or, with a matching `sqrt`, a
        symbol or array.
        """
        return self.weight_variance * (variance if self.kind == "paper" else sqrt(variance))

    def value(self, range_N: float, variance: float) -> float:
        """Return the objective of a range [N] and a variance [N2]."""
        return float(self.weight_range * range_N + self.weighted(variance))


def read_weights(machine: PlantingMachine) -> Weights:
    """Return the weights of range and spread of the support force in the machine file."""
    settings = machine.objective
    return Weights(settings.weight_range, settings.weight_variance, settings.kind)


def build_problem(
    device: Device, sampling: Sampling = "refined", constraints: Constraints | None = None
) -> DesignProblem:
    """Return the problem of the sum of measures in the machine file, over true extremes and
    integrals, or that many samples, under constraints if any.

    Parameters are searched in shares of the machine file's bounds.
    """
    machine = device.force.machine
    terms = [measure for measure in machine.objective if measure.weight]
    goal = Goal(machine, terms, (), None if sampling == "refined" else sampling)
    return DesignProblem(goal, sampling, [] if constraints is None else [constraints])


DENSE = np.linspace(0, 2 * np.pi, 721)
"""Carrier angles of a figure's curves [rad]."""


def evaluate_true_extremes(device: Device, x: Array) -> TrueExtremes:
    """True extremes and integrals of the support force of a design x (p,) [SI], and the objective
    of these.
    """
    panels = CyclePanels(device.force, x)
    high, low = (sign * panels.top(CurveSide(0, 0, sign)) for sign in (1, -1))
    mean = Statistic("mean", panels.values[0], panels.shares).value
    variance = Statistic("variance", panels.values[0], panels.shares).value
    objective = read_weights(device.machine).value(high - low, variance)
    return TrueExtremes(high, low, high - low, mean, variance, objective)


def evaluate_samples(device: Device, x: Array, samples: int | None = None) -> SampledScore:
    """Return the objective of a design x (p,) [SI] over samples, those of the machine file if None,
    and its parts.
    """
    count = samples or device.machine.objective.samples
    force = device.support(device.prologue(x), device.force.machine.list_angles(count))
    span, variance = float(np.ptp(force)), float(force.var())
    objective = read_weights(device.machine).value(span, variance)
    return SampledScore(count, objective, span, variance)


def find_curve_angles(device: Device, x: Array) -> Array:
    """Carrier angles (n,) [rad] of a figure of a design x (p,) [SI]: its largest and least force
    are the true ones.

    Beside `DENSE` they hold the extremes of the support force, and both sides of where it may jump.
    """
    period, panels = device.force.period, CyclePanels(device.force, x)
    extremes = panels.extremes(CurveSide(0, 0, 1)).angles
    sides = np.add.outer([-ONE_SIDED_OFFSET, ONE_SIDED_OFFSET], panels.breaks)
    ends = np.mod(np.append(extremes, sides), period)
    cycles = period * np.arange(round(2 * np.pi / period))
    return np.union1d(DENSE, np.add.outer(cycles, ends))


FIELDS = (OBJECTIVE, "range_N", "variance_N2", "mean_N")
"""Results of a turn: the objective, and measures of the force."""


class CycleObjective:
    """Objective (31) of a device over N samples of a turn, and its exact gradient; designs x are
    (p,) in SI.

    Functions are compiled at the first use and stored in the user's cache; without a compiler
    evaluation is slower. Threads may share an object: each has separate memory. Raises
    ComputationError where a result is not finite, CallError for a design of another shape or not
    finite.
    """

    def __init__(self, device: Device, samples: int | None = None) -> None:
        self.device, self._constants = device, device.constants
        self.samples = samples or device.machine.objective.samples
        self.objective, self.offsets = read_weights(device.machine), device.force.offsets
        machine = device.force.machine
        paths = [machine.values[index].path for index in machine.moved]
        names = [OBJECTIVE, *(f"support_{field}" for field in FIELDS[1:])]
        self._outputs = SampledOutputs(machine, paths, names, self.samples)
        self._values, self._slopes = self._outputs.find_cycles(), self._outputs.find_cycles(1)
        if self._slopes is None:
            self._outputs.rows.compile()
            self._outputs.rows.compile_slopes(1)

    @property
    def way(self) -> str:
        """Backend that evaluates a cycle: `lanes`, or the fastest available one of the others."""
        return self._outputs.rows.find_slopes(1).kernel.way

    def __reduce__(self) -> tuple[Any, ...]:
        """Return device and samples for pickling: a loaded copy has memory and compiled functions
        of its own.
        """
        return CycleObjective, (self.device, self.samples)

    def copy(self) -> CycleObjective:
        """Return a copy with separate memory."""
        return CycleObjective(self.device, self.samples)

    @property
    def angles(self) -> Array:
        """The samples [rad] that differ: a half turn of them where both halves are the same."""
        return sample_angles(self.samples, self.device.force.period)

    def value(self, x: Array) -> float:
        """The objective (31) [-] of a design x (p,) [SI]."""
        self._check(x, self.device.design.shape)
        if self._values:
            return float(self._run(self._values, x).outputs[0])
        return float(self.many(np.asarray(x)[None])[0, 0])

    def gradient(self, x: Array) -> tuple[float, Array]:
        """The objective (31) [-] of a design x (p,) and its gradient (p,) [1/SI]: extremes stay at
        their samples.
        """
        self._check(x, self.device.design.shape)
        if self._slopes:
            memory = self._run(self._slopes, x)
            return float(memory.outputs[0]), memory.gradients[0].copy()
        rows, gradients = self.many_gradients(np.asarray(x)[None])
        return float(rows[0, 0]), gradients[0]

    def many(self, designs: Array, threads: int = 1) -> Array:
        """Rows of objective [-], range [N], variance [N2] and mean [N], (m, 4), for designs (m, p)
        [SI].
        """
        self._check(designs, (len(designs), *self.device.design.shape))
        rows = self._outputs.sample(self._join(designs), threads)
        self._check_finite(designs, rows)
        return rows

    def many_gradients(self, designs: Array, threads: int = 1) -> tuple[Array, Array]:
        """Rows of objective, range, variance and mean, (m, 4), and gradients (m, p) of the
        objective [1/SI].
        """
        self._check(designs, (len(designs), *self.device.design.shape))
        rows, slopes = self._outputs.sample_slopes(self._join(designs), threads, 1, compiled=True)
        self._check_finite(designs, rows, slopes[:, 0])
        return rows, slopes[:, 0]

    @cached_property
    def _sum(self) -> JoinedObjective:
        return build_problem(self.device, self.samples).goal.objective

    def hessian(self, x: Array) -> Array:
        """Hessian (p, p) [1/SI2] of the objective at x (p,) [SI], the extremes staying at their
        samples.
        """
        self._check(x, self.device.design.shape)
        return find_hessian(self._sum, x)

    def _run(self, cycles: Cycles, x: Array) -> Memory:
        memory = cycles.run_row(x, self._constants)
        if memory is None:
            raise self._failure(x)
        return memory

    def _join(self, designs: Array) -> Array:
        """Return all values (m, v) of the machine with designs (m, p)."""
        return np.hstack([designs, np.tile(self._constants, (len(designs), 1))])

    def _check_finite(self, designs: Array, *results: Array) -> None:
        failed = np.flatnonzero(~np.isfinite(np.hstack(results)).all(axis=1))
        if len(failed):
            raise self._failure(designs[failed[0]])

    @staticmethod
    def _failure(x: Array) -> PlanterError:
        if np.isfinite(x).all():
            return ComputationError(
                f"the force, or a slope of it, is not finite at the design {list(x)}"
            )
        return CallError(f"a design must be finite, and was given as {list(x)}")

    @staticmethod
    def _check(array: Array, shape: tuple[int, ...]) -> None:
        if np.shape(array) != shape:
            raise CallError(f"expected the shape {shape}, and was given {np.shape(array)}")


@dataclass(frozen=True)
class Batch:
    """The turn of each design, (m,) each: objective (31); range [N], variance [N2] and mean [N] of
    the force.

    `gradient` (m, p) is that of the objective [1/SI], None if it was not asked for.
    """

    objective: Array
    range_N: Array
    variance_N2: Array
    mean_N: Array
    gradient: Array | None = None

    @property
    def _columns(self) -> dict[str, Array]:
        """Return the results of each design by name, without the gradient."""
        return {name: getattr(self, name) for name in FIELDS}

    def to_frame(self) -> DataFrame:
        """A table of pandas, a row for each design; columns in the units [that their names end in].

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        return build_frame(self._columns)

    def _repr_html_(self) -> str:
        best = int(self.objective.argmin())
        rows = (
            (name, values.min(), values[best], values.max())
            for name, values in self._columns.items()
        )
        title = f"{len(self.objective)} designs, the best of them row {best}"
        return format_table(title, ("", "least", "of the best", "largest"), rows)


@overload
def evaluate_many(
    device: Device,
    designs: Array,
    samples: int | None = None,
    progress: Listener | None = None,
    threads: int | None = None,
    *,
    gradients: bool = False,
) -> Batch: ...


@overload
def evaluate_many(
    device: Machine,
    designs: Array,
    samples: int | None = None,
    progress: Listener | None = None,
    threads: int | None = None,
    *,
    gradients: bool = False,
    outputs: Sequence[str],
) -> OutputBatch: ...


def evaluate_many(
    device: Device | Machine,
    designs: Array,
    samples: int | None = None,
    progress: Listener | None = None,
    threads: int | None = None,
    *,
    gradients: bool = False,
    outputs: Sequence[str] = (),
) -> Batch | OutputBatch:
    """The objective over a turn of many designs (m, p) [SI], with its `gradients` if they are asked
    for.

    Of any other machine, as `load_mechanism` returns it, `outputs` by name, which are those of
    `planter sweep`; the designs are then those of its moved values. `progress` receives the number
    of evaluated designs. Beyond the result only some chunks are in memory, whatever m is. Raises
    CallError for designs of another shape, ComputationError, with the row, for one that is not
    finite or has no finite force; other machines have no numbers there. Ctrl-C ends it after the
    chunks in hand.
    """
    if isinstance(device, Machine):
        return evaluate_outputs(device, designs, outputs, samples, progress, threads, gradients)
    if np.ndim(designs) != 2 or np.shape(designs)[1] != len(device.design):
        raise CallError(
            f"designs have the shape (m, {len(device.design)}), and were given as "
            f"{np.shape(designs)}"
        )
    values = np.empty((len(designs), len(FIELDS)))
    slopes = np.empty(np.shape(designs)) if gradients else None
    turns, count = CycleObjective(device, samples), threads or os.cpu_count() or 1
    phase = ProgressPhase("evaluate", "design", len(designs), progress)
    for start in range(0, len(designs), CHUNK):
        part = slice(start, start + CHUNK)
        chunk = np.array(designs[part], dtype=float)
        try:
            if slopes is None:
                values[part] = turns.many(chunk, count)
            else:
                values[part], slopes[part] = turns.many_gradients(chunk, count)
        except (ComputationError, CallError) as error:
            raise ComputationError(f"among the designs from row {start} on: {error}") from error
        phase.report(start + len(chunk))
    return Batch(**dict(zip(FIELDS, values.T, strict=True)), gradient=slopes)
