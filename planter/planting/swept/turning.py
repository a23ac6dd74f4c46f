"""Statistics of chosen quantities over the turns of many devices of one build: designs and data in rows."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cached_property
from importlib import resources
from pathlib import Path

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, Kernel, backends, loops, toolchain
from planter.kernels.toolchain import NoCompiler
from planter.optimise.samples import angles
from planter.planting.model import Device
from planter.planting.swept.measures import FOUND, key_of

OFFSETS = (0.0, -np.pi)
"""Where the two sides stand [rad]."""


class _Turns(ctypes.Structure):
    """`turns` in statistics.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("parameters", "constants", "angles", "shares", "quantities")),
        *((name, ctypes.c_void_p) for name in ("folded", "phi", "h", "rows", "arg", "res", "iw", "w")),
    )


class Turning:
    """Quantities of a device, by the keys that they are shown with, over `samples` angles of a turn.

    Those of a side are those of side 1. Compiled at the first use; without a compiler it works all the same, slower.
    """

    def __init__(self, device: Device, keys: Sequence[str], samples: int) -> None:
        self.device, self.keys = device, tuple(keys)
        self.angles = angles(samples, float(np.pi))
        self.phi = np.add.outer(OFFSETS, self.angles).ravel()
        self._rows, self.folded = self._graph()

    def _graph(self) -> tuple[list[ca.SX], Array]:
        """A quantity each at a lane's angle: of a side, a side's share of a total, or a total that has no shares."""
        machine, functions = self.device.force.machine, self.device.functions
        vectors = self.device.sidecar["vectors"]
        names = {key_of(entry): entry["name"] for part in ("side", "totals") for entry in vectors[part]}
        graph, folded = machine.rows([names[key] for key in self.keys])
        rows = ca.Function("rows", list(machine.symbols), [graph])
        d, q = ca.vertcat(functions.x, functions.c), ca.SX(0, 1)
        return ca.vertsplit(rows(functions.phi, d, functions.h, q)), np.array(folded)

    @cached_property
    def stated(self) -> ca.Function:
        """(phi, x, c, h) -> the rows of a lane."""
        functions = self.device.functions
        rows = ca.cse([ca.densify(ca.vertcat(*self._rows))])
        return ca.Function("stated", functions.inputs, rows, ["phi", "x", "c", "h"], ["rows"])

    @cached_property
    def kernel(self) -> Kernel:
        return Kernel(self.stated, lanes=["phi"])

    def many(self, designs: Array, data: Array) -> Array:
        """`FOUND` of each quantity, (m, k, 4) in SI, of designs (m, p) with data (m, c); NaN in rows without result."""
        if self._native is None:
            return np.array([self._one(x, c) for x, c in zip(designs, data, strict=True)])
        found = np.empty((len(designs), len(self.keys), len(FOUND)))
        failed = np.zeros(len(designs), dtype=np.uint8)
        given = [np.ascontiguousarray(array, dtype=float) for array in (designs, data)]
        memory = _arrays(self)
        record = _record(self, memory)
        self._native(ctypes.byref(record), len(designs), *(_place(array) for array in (*given, found, failed)))
        found[failed.astype(bool)] = np.nan
        return found

    def values(self, x: Array, c: Array) -> list[Array]:
        """Samples of each quantity over a turn, in SI: (n,) each, or of a side the samples of the whole turn.

        Raises ComputationError where one is not finite.
        """
        h = self.device.hoisting_kernel(x=x, c=c)["h"][:, 0]
        rows = self.kernel(phi=self.phi, x=x, c=c, h=h)["rows"]
        return [self.fold(row) if folded else row for row, folded in zip(rows, self.folded, strict=True)]

    def whole(self, x: Array, c: Array) -> Array:
        """Each quantity in all lanes, (k, lanes): totals are the same half a turn later. Raises as `values`."""
        return np.array([
            np.tile(row, len(OFFSETS)) if folded else row
            for row, folded in zip(self.values(x, c), self.folded, strict=True)
        ])  # fmt: skip

    def fold(self, row: Array) -> Array:
        """The sum of the shares (..., lanes) at each angle, (..., angles)."""
        found: Array = row.reshape(*row.shape[:-1], len(OFFSETS), -1).sum(axis=-2)
        return found

    def _one(self, x: Array, c: Array) -> Array:
        try:
            found = self.values(x, c)
        except ComputationError:
            return np.full((len(self.keys), len(FOUND)), np.nan)
        return np.array([[row.max(), row.min(), row.mean(), row.var()] for row in found])

    @cached_property
    def _native(self) -> ctypes._NamedFuncPointer | None:
        """The compiled turns; None where they cannot be compiled, or are not to be."""
        if backends.allowed()[0] == "lanes":
            try:
                (run,) = toolchain.functions(self._library(), "turned_many")
            except loops.NotPrintable:
                pass
            except NoCompiler as reason:
                toolchain.warn(reason)
            else:
                run.restype = None
                run.argtypes = (ctypes.c_void_p, ctypes.c_long, *[ctypes.c_void_p] * 4)
                return run
        self.kernel.compile()
        return None

    def _library(self) -> Path:
        source = resources.files(__package__).joinpath("statistics.c").read_text(encoding="utf-8")
        hoisting, stated = self.device.hoisting_kernel.work, self.kernel.work
        needed = backends.casadi_library(hoisting), backends.lane_library(stated)
        return toolchain.library("statistics", source, toolchain.loop_flags(toolchain.OPTIMISED), needed)


def _arrays(turning: Turning) -> dict[str, Array]:
    """What the compiled record points to."""
    function: ca.Function = turning.device.hoisting_kernel.function
    sizes = {"h": function.nnz_out(0), "rows": len(turning.keys) * len(turning.phi),
             **{name: getattr(function, f"sz_{name}")() for name in ("arg", "res", "iw", "w")}}  # fmt: skip
    work = {name: np.zeros(size + 1) for name, size in sizes.items()}
    return {"folded": turning.folded.astype(ctypes.c_long), "phi": turning.phi, **work}


def _record(turning: Turning, arrays: dict[str, Array]) -> _Turns:
    return _Turns(
        parameters=len(turning.device.design), constants=len(turning.device.constants), angles=len(turning.angles),
        shares=len(OFFSETS), quantities=len(turning.keys), **{name: array.ctypes.data for name, array in arrays.items()}
    )  # fmt: skip


def _place(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
