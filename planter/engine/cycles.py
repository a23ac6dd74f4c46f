"""Outputs of many cycles, and their exact gradients, in one compiled call without Python between
the rows.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Sequence
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planter.engine.loops import VECTOR
from planter.engine.machine import LEAST_PIVOT
from planter.kernels import Array, backends, toolchain
from planter.kernels.compiler import CompilerError
from planter.kernels.lane_graph import NotPrintableError
from planter.numerics import statistics

if TYPE_CHECKING:
    from planter.engine.rows import MachineRows

KINDS = tuple(statistics.REDUCTIONS)
"""Kinds of measures, in the order of their numbers in C."""
SIZES = (
    "values",
    "hoisted",
    "coordinates",
    "lanes",
    "sides",
    "stride",
    "places",
    "guards",
    "terms",
    "outputs",
    "sloped",
    "parameters",
)
CALL = (ctypes.c_void_p, ctypes.c_long, ctypes.c_void_p, ctypes.c_long, *[ctypes.c_void_p] * 5)
"""Types of the arguments of `cycles` in C."""
STATISTICS = 5
"""Numbers of `statistics` in C."""
FUNCTIONS = ("fix", "sample", "slope")
ARRAYS = (
    "shared",
    "states",
    "term",
    "phi",
    "statistics",
    "q",
    "h",
    "dh",
    "rows",
    "slopes",
    "weights",
    "arg",
    "res",
    "iw",
    "w",
)


class CycleTerm(NamedTuple):
    """A measure in the output at an index, of the quantity at a place; `scale` is its part of a
    unit in SI.

    It is a statistic of the samples, or of their sizes, or else the sample at an index.
    """

    output: int
    place: int
    kind: str
    scale: float
    size: bool = False
    sample: int = 0

    @property
    def is_statistic(self) -> bool:
        """Whether it is a statistic of the samples themselves, which is all that C has."""
        return self.kind in KINDS and not self.size

    def reduce(self, samples: Array) -> Array:
        """Return the measure (rows,) of samples (n, rows)."""
        values = np.abs(samples) if self.size else samples
        reduced = (
            values[self.sample % len(values)]
            if self.kind == "at"
            else statistics.reduce_samples(self.kind, values)
        )
        return np.asarray(self.scale * reduced)

    def differentiate(self, samples: Array) -> Array:
        """Return the derivative (n, rows) of the measure in each sample."""
        if self.kind == "at":
            slope = np.zeros_like(samples)
            slope[self.sample % len(samples)] = 1
        else:
            slope = statistics.differentiate_statistic(
                self.kind, np.abs(samples) if self.size else samples
            )
        return np.asarray(self.scale * (np.sign(samples) * slope if self.size else slope))


class _Term(ctypes.Structure):
    """`term` in cycles.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("output", "place", "kind")),
        ("scale", ctypes.c_double),
    )


class _Cycle(ctypes.Structure):
    """`cycle` in cycles.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in SIZES),
        ("least_pivot", ctypes.c_double),
        *((name, ctypes.c_void_p) for name in (*FUNCTIONS, *ARRAYS)),
    )


class Cycles:
    """`outputs` sums of terms over the cycle of each row, and the slopes of the first `sloped` of
    them, compiled.

    Threads may share an object: each computes in separate memory.
    """

    def __init__(
        self,
        rows: MachineRows,
        terms: Sequence[CycleTerm],
        averages: Sequence[tuple[int, int]],
        outputs: int,
        sloped: int = 0,
    ) -> None:
        """`averages` are the outputs that quantities, by place, must repeat for.

        Raises CompilerError, or NotPrintableError for quantities that cannot be evaluated in lanes.
        """
        terms = sorted(terms)
        self._averages = averages
        self.rows, weighed = rows, [term.place for term in terms if term.output < sloped]
        stacked, fixed = (
            (rows.find_slopes(1 + max(weighed)), rows.tangents)
            if weighed
            else (rows.values, rows.hoist)
        )
        stacked.kernel.compile()
        if stacked.kernel.loop is None:
            raise NotPrintableError(f"{stacked.kernel.function.name()} is not evaluated in lanes")
        (fix,) = toolchain.load_functions(
            backends.build_library(fixed.work, "casadi-c"), fixed.function.name()
        )
        text = resources.files(__package__).joinpath("cycles.c").read_text(encoding="utf-8")
        path = toolchain.build_library("cycles", text, toolchain.loop_flags(toolchain.OPTIMISED))
        (self._run,) = toolchain.load_functions(path, "cycles")
        self._run.restype, self._run.argtypes = ctypes.c_long, CALL
        machine, count = rows.machine, len(rows.steps)
        self._functions = {"fix": fix, "slope" if weighed else "sample": stacked.kernel.loop}
        self._constants: dict[str, NDArray[Any]] = {
            "shared": np.array(rows.shared, dtype=ctypes.c_long),
            "states": np.array(
                [guard.role == "states" for guard in rows.guards], dtype=ctypes.c_long
            ),
            "term": np.array(
                [(term.output, term.place, KINDS.index(term.kind), term.scale) for term in terms],
                dtype=_Term,
            ),
            "phi": align_numbers(rows.steps),
        }
        self._sizes = {
            "values": len(machine.values),
            "hoisted": machine.prologue.numel_out(0),
            "coordinates": machine.loops.size if machine.loops else 0,
            "lanes": count,
            "sides": rows.sides,
            "stride": rows.stride,
            "places": len(rows.names),
            "guards": len(rows.guards),
            "terms": len(terms),
            "outputs": outputs,
            "sloped": sloped,
            "parameters": len(machine.moved),
        }
        function = fixed.function
        self._memory_sizes = {
            "statistics": STATISTICS * len(rows.names),
            "q": self._sizes["coordinates"] * count,
            "h": function.nnz_out(0),
            "dh": function.nnz_out(1) if weighed else 0,
            "rows": stacked.kernel.function.nnz_out(0) * count,
            "slopes": stacked.kernel.function.nnz_out(1) * count if weighed else 0,
            "weights": count,
            **{name: getattr(function, f"sz_{name}")() + 1 for name in ("arg", "res", "iw", "w")},
        }
        self._lent = _Lent(self)

    def evaluate(self, d: Array, threads: int = 1) -> tuple[Array, Array]:
        """Return outputs (r, k) and gradients (r, s, p) of rows of values d (r, v); rows without a
        cycle have none.
        """
        if self.rows.machine.loops:
            self.rows.machine.loops.compile()
        table = self.rows.split(d, self._evaluate_part, threads)
        outputs, gradients = np.split(table, [self._sizes["outputs"]], axis=1)
        return outputs, gradients.reshape(len(d), self._sizes["sloped"], self._sizes["parameters"])

    def _evaluate_part(self, d: Array) -> Array:
        """Return outputs, then gradients, as a row each."""
        closed = self.rows.close(np.ascontiguousarray(d, dtype=float))
        alive, size = (
            np.flatnonzero(closed.alive),
            self._sizes["sloped"] * self._sizes["parameters"],
        )
        outputs, gradients = (
            np.empty((len(alive), self._sizes["outputs"])),
            np.empty((len(alive), size)),
        )
        failures, width = np.empty(len(alive), dtype=np.uint8), closed.places.shape[2]
        index = alive.astype(ctypes.c_long)
        arrays = (closed.d, np.ascontiguousarray(closed.places), outputs, gradients, failures)
        addresses = (array.ctypes.data for array in arrays)
        self._run(self._lent.memory.address, len(alive), index.ctypes.data, width, *addresses)
        repeats = self.rows.find_repeats(closed, alive)
        for k, place in self._averages:
            outputs[~repeats[place], k] = np.nan
        table = np.full((len(d), outputs.shape[1] + size), np.nan)
        table[alive] = np.hstack([outputs, gradients])
        table[alive[failures == 1]] = np.nan
        return table

    def run_row(self, d: Array) -> Memory | None:
        """Return where a row of values d (v,) was evaluated, or None if it failed.

        It is memory of this thread, until the next call. The machine has no loops.
        """
        memory = self._lent.memory
        memory.d[:] = d
        return None if self._run(*memory.arguments) else memory


class _Lent(threading.local):
    """`memory` of the thread that asks for it."""

    def __init__(self, cycles: Cycles) -> None:
        self.memory = Memory(cycles)


class Memory:
    """Memory that a row is evaluated in: values `d` (v,), results `outputs` (k,) and `gradients`
    (s, p).
    """

    def __init__(self, cycles: Cycles) -> None:
        sizes = cycles._sizes
        arrays = {
            name: align_numbers(np.zeros(size)) for name, size in cycles._memory_sizes.items()
        }
        self._arrays = cycles._constants | arrays
        addresses = {name: array.ctypes.data for name, array in self._arrays.items()}
        functions = {
            name: ctypes.cast(function, ctypes.c_void_p)
            for name, function in cycles._functions.items()
        }
        self._cycle = _Cycle(least_pivot=LEAST_PIVOT, **sizes, **functions, **addresses)
        self.address = ctypes.addressof(self._cycle)
        self.d, self.outputs = np.zeros(sizes["values"]), np.zeros(sizes["outputs"])
        self.gradients, self._failures = (
            np.zeros((sizes["sloped"], sizes["parameters"])),
            np.zeros(1, dtype=np.uint8),
        )
        self._index = np.zeros(1, dtype=ctypes.c_long)
        results = (self.d, self.d, self.outputs, self.gradients, self._failures)
        self.arguments = (
            self.address,
            1,
            self._index.ctypes.data,
            1,
            *(array.ctypes.data for array in results),
        )


def align_numbers(numbers: Array) -> Array:
    """Return a copy that begins at a whole vector, so that loops over lanes read and write no
    vector in two parts.
    """
    memory = np.empty(numbers.size + VECTOR)
    start = -memory.ctypes.data // memory.itemsize % VECTOR
    aligned = memory[start : start + numbers.size]
    aligned[:] = numbers
    return aligned


def build_cycles(
    rows: MachineRows,
    terms: Sequence[CycleTerm],
    averages: Sequence[tuple[int, int]],
    outputs: int,
    sloped: int = 0,
) -> Cycles | None:
    """Return `Cycles`, or None where they cannot be compiled, with one warning if there is no
    compiler.
    """
    if backends.list_allowed()[0] != "lanes":
        return None
    try:
        return Cycles(rows, terms, averages, outputs, sloped)
    except NotPrintableError:
        return None
    except CompilerError as reason:
        toolchain.warn_once(reason)
        return None
