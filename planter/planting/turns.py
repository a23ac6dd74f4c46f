"""The objective over a turn, from design vector to value and gradient in one compiled call.

from planter import Device, Turns, load_machine

turns = Turns(Device(load_machine("wang2017")))
value, gradient = turns.gradient(turns.device.design)
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from planter.engine.cycles import Cycles, Memory
from planter.engine.outputs import OBJECTIVE, SampledOutputs
from planter.errors import ComputationError, PlanterError
from planter.kernels import Array, CallError
from planter.optimise.samples import angles
from planter.optimise.spread import Weighed
from planter.planting.model import Device
from planter.planting.objective import weights

FIELDS = (OBJECTIVE, "range_N", "variance_N2", "mean_N")
"""Results of a turn: the objective, and measures of the force."""


class Turns:
    """Objective (31) of a device over N samples of a turn, and its exact gradient; designs x are (p,) in SI.

    Compiles what it needs at the first use and keeps it in the user's cache; without a compiler it works all the same,
    slower. Threads may share an object: each computes in memory of its own.
    Raises ComputationError where a result is not finite, CallError for a design of another shape or not finite.
    """

    def __init__(self, device: Device, samples: int | None = None) -> None:
        self.device, self._constants = device, device.constants
        self.samples = samples or device.machine.objective.samples
        self.objective = weights(device.machine)
        self.offsets = device.force.offsets
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
        """How a turn is evaluated: `lanes`, or the fastest of the other ways that there is."""
        return self._outputs.rows.find_slopes(1).kernel.way

    def __reduce__(self) -> tuple[Any, ...]:
        """As its device and samples: where it is loaded, memory and compiled functions are its own."""
        return Turns, (self.device, self.samples)

    def copy(self) -> Turns:
        """The same with memory of its own."""
        return Turns(self.device, self.samples)

    @cached_property
    def angles(self) -> Array:
        """The samples [rad] that differ: a half turn of them where both halves are the same."""
        return angles(self.samples, self.device.force.period)

    def value(self, x: Array) -> float:
        """The objective (31) [-] of a design x (p,) [SI]."""
        self._check(x, self.device.design.shape)
        if self._values:
            return float(self._run(self._values, x).outputs[0])
        return float(self.many(np.asarray(x)[None])[0, 0])

    def gradient(self, x: Array) -> tuple[float, Array]:
        """The objective (31) [-] of a design x (p,) and its gradient (p,) [1/SI]: extremes stay at their samples."""
        self._check(x, self.device.design.shape)
        if self._slopes:
            memory = self._run(self._slopes, x)
            return float(memory.outputs[0]), memory.gradients[0].copy()
        rows, gradients = self.many_gradients(np.asarray(x)[None])
        return float(rows[0, 0]), gradients[0]

    def gradients(self, designs: Array, data: Array) -> tuple[Array, Array]:
        """Objectives (m,) and gradients (m, p) of designs (m, p), each on a machine with other data (m, c) [SI]."""
        self._check(designs, (len(designs), *self.device.design.shape))
        self._check(data, (len(designs), *self.device.constants.shape))
        rows, gradients = self._differentiate(designs, data)
        return rows[:, 0], gradients

    def many(self, designs: Array, threads: int = 1) -> Array:
        """Rows of objective [-], range [N], variance [N2] and mean [N], (m, 4), for designs (m, p) [SI]."""
        self._check(designs, (len(designs), *self.device.design.shape))
        rows = self._outputs.sample(self._join(designs, self._constants), threads)
        self._check_finite(designs, rows)
        return rows

    def many_gradients(self, designs: Array, threads: int = 1) -> tuple[Array, Array]:
        """Rows of objective, range, variance and mean, (m, 4), and gradients (m, p) of the objective [1/SI]."""
        self._check(designs, (len(designs), *self.device.design.shape))
        return self._differentiate(designs, self.device.constants, threads)

    def hessian(self, x: Array) -> Array:
        """Hessian (p, p) [1/SI2] of the objective at x (p,) [SI], the extremes staying at their samples."""
        self._check(x, self.device.design.shape)
        if self._slopes and not self.device.compiled:
            self.device.compile()
        at = self.device.prologue(x)
        force, slopes = self.device.force.slopes(at, self.angles)

        def bent(weights: Array) -> Array:
            return self.device.force.hessian(at, self.angles, weights)[1:, 1:]

        return Weighed(self.objective, force).hessian(slopes[:, 1:], bent)

    def _differentiate(self, designs: Array, data: Array, threads: int = 1) -> tuple[Array, Array]:
        """Return rows of `FIELDS`, (m, 4), and gradients (m, p), for data (c,), or (m, c)."""
        rows, slopes = self._outputs.sample_slopes(self._join(designs, data), threads, 1, compiled=True)
        self._check_finite(designs, rows, slopes[:, 0])
        return rows, slopes[:, 0]

    def _run(self, cycles: Cycles, x: Array) -> Memory:
        memory = cycles.run_row(x, self._constants)
        if memory is None:
            raise self._failure(x)
        return memory

    @staticmethod
    def _join(designs: Array, data: Array) -> Array:
        """Return all values (m, v) of designs (m, p) and data (c,) or (m, c)."""
        return np.hstack([designs, np.broadcast_to(data, (len(designs), data.shape[-1]))])

    def _check_finite(self, designs: Array, *results: Array) -> None:
        failed = np.flatnonzero(~np.isfinite(np.hstack(results)).all(axis=1))
        if len(failed):
            raise self._failure(designs[failed[0]])

    @staticmethod
    def _failure(x: Array) -> PlanterError:
        if np.isfinite(x).all():
            return ComputationError(f"the force, or a slope of it, is not finite at the design {list(x)}")
        return CallError(f"a design must be finite, and was given as {list(x)}")

    @staticmethod
    def _check(array: Array, shape: tuple[int, ...]) -> None:
        if np.shape(array) != shape:
            raise CallError(f"expected the shape {shape}, and was given {np.shape(array)}")
