"""The objective over a turn, from design vector to value and gradient in one compiled call.

from planter import Device, Turns, load_machine

turns = Turns(Device(load_machine("wang2017")))
value, gradient = turns.gradient(turns.device.design)
"""

from __future__ import annotations

import ctypes
import threading
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError, PlanterError
from planter.kernels import Array, CallError, backends, loops, toolchain
from planter.kernels.toolchain import NoCompiler
from planter.optimise.samples import angles
from planter.optimise.spread import Weighed
from planter.planting.model import Device
from planter.planting.objective import weights

FIELDS = ("objective", "range_N", "variance_N2", "mean_N")
"""What is found of a turn, in the order of the compiled record."""


class _Turn(ctypes.Structure):
    """`turn` in turn.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("parameters", "constants", "angles", "shares")),
        ("weight_range", ctypes.c_double),
        ("weight_variance", ctypes.c_double),
        ("newton", ctypes.c_long),
        *((name, ctypes.c_void_p) for name in
          ("phi", "c", "d", "h", "dh", "force", "g", "weights", "arg", "res", "iw", "w")),
    )  # fmt: skip


class Turns:
    """Objective (31) of a device over N samples of a turn, and its exact gradient; designs x are (p,) in SI.

    Compiles what it needs at the first use and keeps it in the user's cache; without a compiler it works all the same,
    slower. Threads may share an object: each computes in memory of its own.
    Raises ComputationError where a result is not finite, CallError for a design of another shape or not finite.
    """

    def __init__(self, device: Device, samples: int | None = None) -> None:
        self.device = device
        self.samples = samples or device.machine.objective.samples
        self.objective = weights(device.machine)
        self.offsets = device.force.offsets
        self._native = _native(self)

    @property
    def way(self) -> str:
        """How a turn is evaluated: `lanes`, or the fastest of the other ways that there is."""
        return "lanes" if self._native else self.device.force.response.slopes_kernel.way

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
        if self._native:
            return self._native.value(x)
        return float(self._row(x)[0])

    def gradient(self, x: Array) -> tuple[float, Array]:
        """The objective (31) [-] of a design x (p,) and its gradient (p,) [1/SI]: extremes stay at their samples."""
        self._check(x, self.device.design.shape)
        return self._gradient(x, self.device.constants)

    def gradients(self, designs: Array, data: Array) -> tuple[Array, Array]:
        """Objectives (m,) and gradients (m, p) of designs (m, p), each on a machine with other data (m, c) [SI]."""
        self._check(designs, (len(designs), *self.device.design.shape))
        self._check(data, (len(designs), *self.device.constants.shape))
        found = [self._gradient(x, c) for x, c in zip(designs, np.ascontiguousarray(data), strict=True)]
        values, gradients = zip(*found, strict=True)
        return np.array(values), np.array(gradients)

    def _gradient(self, x: Array, c: Array) -> tuple[float, Array]:
        if self._native:
            return self._native.gradient(x, c)
        force, slopes = self.device.force.slopes(self.device.prologue(x, c), self.angles)
        turn = Weighed(self.objective, force)
        return turn.value, turn.gradient(slopes[:, 1:])

    def many(self, designs: Array) -> Array:
        """Rows of objective [-], range [N], variance [N2] and mean [N], (m, 4), for designs (m, p) [SI]."""
        self._check(designs, (len(designs), *self.device.design.shape))
        if self._native:
            return self._native.many(np.ascontiguousarray(designs, dtype=float))
        return np.array([self._row(x) for x in designs])

    def many_gradients(self, designs: Array) -> tuple[Array, Array]:
        """Rows of objective, range, variance and mean, (m, 4), and gradients (m, p) of the objective [1/SI]."""
        self._check(designs, (len(designs), *self.device.design.shape))
        if self._native:
            return self._native.many_gradients(np.ascontiguousarray(designs, dtype=float))
        gradients = [self._gradient(x, self.device.constants)[1] for x in designs]
        return np.array([self._row(x) for x in designs]), np.array(gradients)

    def _row(self, x: Array) -> tuple[float, ...]:
        """`FIELDS` of a design, by the kernels one after another."""
        turn = Weighed(self.objective, self.device.force.value(self.device.prologue(x), self.angles))
        return turn.value, turn.range, turn.variance.value, turn.variance.mean

    def hessian(self, x: Array) -> Array:
        """Hessian (p, p) [1/SI2] of the objective at x (p,) [SI], the extremes staying at their samples."""
        self._check(x, self.device.design.shape)
        if self._native and not self.device.compiled:
            self.device.compile()
        at = self.device.prologue(x)
        force, slopes = self.device.force.slopes(at, self.angles)

        def bent(weights: Array) -> Array:
            return self.device.force.hessian(at, self.angles, weights)[1:, 1:]

        return Weighed(self.objective, force).hessian(slopes[:, 1:], bent)

    @staticmethod
    def _check(given: Array, shape: tuple[int, ...]) -> None:
        if np.shape(given) != shape:
            raise CallError(f"expected the shape {shape}, and was given {np.shape(given)}")


def turn_text() -> str:
    """Return the turn in C: to be linked with a device's kernels."""
    files = ("weighed.c", "turn.c", "gradients.c")
    return "".join(resources.files(__package__).joinpath(file).read_text(encoding="utf-8") for file in files)


def _native(turns: Turns) -> Native | None:
    """The compiled turn, where lanes are allowed and everything can be compiled; else the fastest other way is set."""
    response = turns.device.force.response
    if backends.allowed()[0] == "lanes":
        try:
            return Native(turns, library(turns.device))
        except loops.NotPrintable:
            pass
        except NoCompiler as reason:
            toolchain.warn(reason)
    for kernel in (response.values_kernel, response.slopes_kernel):
        kernel.compile()
    return None


def library(device: Device) -> Path:
    """The compiled turn of a device: prologue in CasADi's C, lanes of the force, and what joins them."""
    response = device.force.response
    needed = (
        backends.casadi_library(response.hoisting_kernel.work),
        backends.casadi_library(response.prologue_kernel.work),
        backends.lane_library(response.values_kernel.work),
        backends.lane_library(response.slopes_kernel.work),
    )
    return toolchain.library("turn", turn_text(), toolchain.loop_flags(toolchain.OPTIMISED), needed)


class Native:
    """The compiled turn."""

    def __init__(self, turns: Turns, path: Path) -> None:
        self._value, self._slopes, self._many, self._many_slopes = toolchain.functions(
            path, "turn_value", "turn_gradient", "turn_values", "turn_gradients"
        )
        for function, arrays in ((self._many, 2), (self._many_slopes, 3)):
            function.restype = ctypes.c_long
            function.argtypes = (ctypes.c_void_p, ctypes.c_long, *[ctypes.c_void_p] * arrays)
        self._lent, self._constants = _Lent(turns), turns.device.constants

    def value(self, x: Array) -> float:
        own = self._lent.memory
        own.design[:], own.data[:] = x, self._constants
        if self._value(*own.pointers[:3]):
            raise self._failure(x)
        return float(own.found[0])

    def gradient(self, x: Array, c: Array) -> tuple[float, Array]:
        """`c` (n,) are the data of the machine, contiguous."""
        own = self._lent.memory
        own.design[:], own.data[:] = x, c
        if self._slopes(*own.pointers):
            raise self._failure(x)
        return float(own.found[0]), own.gradient.copy()

    def many(self, designs: Array) -> Array:
        """Rows of `FIELDS`, (m, 4), for contiguous designs (m, p)."""
        rows = np.empty((len(designs), len(FIELDS)))
        self._run(self._many, designs, rows)
        return rows

    def many_gradients(self, designs: Array) -> tuple[Array, Array]:
        """Rows of `FIELDS`, (m, 4), and gradients (m, p), for contiguous designs (m, p)."""
        rows, gradients = np.empty((len(designs), len(FIELDS))), np.empty(designs.shape)
        self._run(self._many_slopes, designs, rows, gradients)
        return rows, gradients

    def _run(self, function: Any, designs: Array, *results: Array) -> None:
        """Call a function of many designs, which writes to arrays; raises what its first failure means."""
        own = self._lent.memory
        own.data[:] = self._constants
        failed = function(
            ctypes.addressof(own.turn), len(designs), designs.ctypes.data, *(array.ctypes.data for array in results)
        )
        if failed:
            raise self._failure(designs[failed - 1])

    @staticmethod
    def _failure(x: Array) -> PlanterError:
        if np.isfinite(x).all():
            return ComputationError(f"the force, or a slope of it, is not finite at the design {list(x)}")
        return CallError(f"a design must be finite, and was given as {list(x)}")


class _Memory:
    """What the compiled turn reads and writes."""

    def __init__(self, turns: Turns) -> None:
        self._arrays = _arrays(turns)
        self.data = self._arrays["c"]
        self.turn = _record(turns, self._arrays)
        self.design = np.zeros(len(turns.device.design))
        self.found, self.gradient = np.zeros(len(FIELDS)), np.zeros(len(self.design))
        arrays = (self.design, self.found, self.gradient)
        self.pointers = (ctypes.byref(self.turn), *(ctypes.c_void_p(a.ctypes.data) for a in arrays))


class _Lent(threading.local):
    """`memory` of the thread that asks for it."""

    def __init__(self, turns: Turns) -> None:
        self.memory = _Memory(turns)


def _arrays(turns: Turns) -> dict[str, Array]:
    """What the compiled record points to."""
    response = turns.device.force.response
    function: ca.Function = response.prologue_kernel.function
    other: ca.Function = response.hoisting_kernel.function
    count = len(turns.angles) * len(turns.offsets)
    sizes = {
        "d": len(turns.device.data),
        "h": function.nnz_out(0), "dh": function.nnz_out(1), "force": count, "weights": count,
        "g": (1 + len(turns.device.design)) * count,
        **{name: max(getattr(f, f"sz_{name}")() for f in (function, other)) for name in ("arg", "res", "iw", "w")},
    }  # fmt: skip
    work = {name: np.zeros(size + 1) for name, size in sizes.items()}
    phi = np.add.outer(turns.offsets, turns.angles).ravel()
    return {"phi": phi, "c": np.array(turns.device.constants), **work}


def _record(turns: Turns, arrays: dict[str, Array]) -> _Turn:
    objective: Any = turns.objective
    return _Turn(
        parameters=len(turns.device.design), constants=len(turns.device.constants), angles=len(turns.angles),
        shares=len(turns.offsets),
        weight_range=objective.weight_range, weight_variance=objective.weight_variance,
        newton=int(objective.kind == "newton"), **{name: array.ctypes.data for name, array in arrays.items()},
    )  # fmt: skip
