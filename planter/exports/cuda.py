"""A machine's cycles as CUDA C++, from the same walk as the lane kernels: a thread for each design and angle.

What a design fixes is CasADi's own C, compiled for the graphics processor; what its angles share is computed once for a
design. The templates `turns.cu`, `weighed.cu` and `loops.c` are in the folder of this file.
"""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import casadi as ca
import numpy as np

from planter.engine.machine import LEAST_PIVOT, Machine
from planter.engine.response import INPUTS, MachineResponse
from planter.errors import ComputationError
from planter.exports import c99, quantities
from planter.exports.c99 import join_integers, read_template
from planter.exports.quantities import SampledGoal
from planter.kernels import Array, CallError, builds, lane_source, toolchain
from planter.kernels.compiler import CompilerError
from planter.kernels.lane_graph import ArrayElement, Assignment, LaneGraph
from planter.kernels.lane_source import print_function

MOST_DESIGNS, MEMORY = 65536, 1 << 27
"""Designs that are computed at a time, at most, and the numbers that may be prepared of them."""


def build_source_files(machine: Machine) -> dict[str, str]:
    """Return the text by its file name, `NAME.cu`.

    Raises InputError for an objective of what the machine does not have.
    """
    text = CudaText(machine)
    return {f"{text.name}.cu": read_template("turns.cu").substitute(text.values())}


class CudaText:
    """Values of the template for a machine."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.name, self.goal = machine, quantities.build_name(machine), SampledGoal(machine)
        self.guards, self.fixed = [guard.name for guard in machine.guards], quantities.list_fixed(machine)
        self.coordinates = machine.loops.size if machine.loops else 0

    @cached_property
    def graph(self) -> LaneGraph:
        """(phi, d, h, q) -> rows and guards."""
        symbols = list(self.machine.symbols)
        parts = [self.goal.response.values_function(*symbols)]
        if self.guards:
            parts.append(MachineResponse(self.machine, self.guards).values_function(*symbols))
        function = ca.Function("lane", symbols, [ca.vertcat(*parts)], list(INPUTS), ["rows"])
        return LaneGraph.from_function(function, ["phi", "q"] if self.coordinates else ["phi"])

    def values(self) -> dict[str, object]:
        """Return the template's words."""
        machine, goal, graph = self.machine, self.goal, self.graph
        hoisting = quantities.build_prologues(machine, goal.response.tangent)[0]
        shared = _list_shared(graph)
        course = c99.compute_course_size(machine.loops) if machine.loops else 1
        prepared = len(machine.values) + len(shared) + course
        fields = [f"found[{i}] {field.printed}" for i, field in enumerate(goal.fields)]
        return {
            **c99.describe_machine(machine), "name": self.name, "purpose": self._purpose(),
            "fields": c99.list_lines("Results:", fields),
            "prologue": _to_device(c99.build_casadi_text(self.name, [hoisting])),
            "functions": lane_source.print_fused_functions(), "kernels": self._kernels(shared), "loops": self._loops(),
            "parameters": len(machine.moved), "constants": len(self.fixed), "values": len(machine.values),
            "shared": max(len(shared), 1), "shares": len(goal.response.offsets), "rows": len(goal.rows),
            "guards": len(self.guards), "nodes": len(goal.nodes), "field_count": len(goal.fields),
            "coordinates": max(self.coordinates, 1), "course": course,
            "chunk": min(MOST_DESIGNS, MEMORY // prepared), "hoisted": max(hoisting.nnz_out(0), 1),
            "design_places": join_integers(machine.moved), "machine_places": join_integers(self.fixed),
            "is_share": join_integers(row.shared for row in goal.rows),
            "is_size": join_integers(row.absolute for row in goal.rows),
            "node_rows": join_integers(row for row, _ in goal.nodes), "least_pivot": repr(LEAST_PIVOT),
            "guard_kinds": join_integers(machine.find_quantity(name).role == "states" for name in self.guards),
            "follow": _FOLLOW if self.coordinates else "", "place": _PLACE if self.coordinates else "",
            "weigh": _WEIGH.replace("PARAMETERS_OR_ONE", str(max(len(machine.moved), 1))) if goal.measures else "",
            "weighed": self._weighed(),
            **{key: getattr(hoisting, f"sz_{key}")() + 1 for key in ("arg", "res", "iw", "w")},
        }  # fmt: skip

    def _purpose(self) -> str:
        if self.goal.measures:
            return f"the objective {c99.to_plain(self.goal.text)}"
        return "range, variance and mean of all results"

    def _weighed(self) -> str:
        """Return the function with separate weights if range and spread of one row make the objective."""
        kinds = {measure.kind for measure in self.goal.measures}
        if len(self.goal.rows) != 1 or not kinds or not kinds <= {"range", "variance", "std"}:
            return ""
        return read_template("weighed.cu").substitute(name=self.name)

    def _kernels(self, shared: dict[str, int]) -> str:
        """Return `before`, what the angles of a design share, `lane`, and what is called once."""
        single = []
        if self.machine.loops:
            single += [self.machine.loops.steps_function, self.machine.loops.start_function]
        if self.goal.measures:
            single.append(self.goal.function)
        texts = [f"static {print_function(LaneGraph.from_function(function, []), summed=False)}" for function in single]
        return "\n".join([*_list_lane_lines(self.graph, shared), *map(_to_device, texts)])

    def _loops(self) -> str:
        if self.machine.loops is None:
            return ""
        statuses = "".join(f"#define LOOPS_{status} {i}\n" for i, status in enumerate(c99.STATUSES, 1))
        return statuses + _to_device(c99.build_loops_text(self.machine.loops, "LOOPS"))


_FOLLOW = "  if (!failed) failed = follow_loops(values, own + SHARED);\n"
_PLACE = "      failed = place_loops(values, given + VALUES + SHARED, phi[share * count + i], q);\n"
_WEIGH = """\
    double slope[4 * ROWS], node_slope[NODES + 1], moved_slope[PARAMETERS_OR_ONE];
    weigh(1, values, statistics, nodes, result++, slope, node_slope, moved_slope);
"""


def _to_device(text: str) -> str:
    """Return C with every function and table on the device: definitions are what begins in the first column."""
    return re.sub(r"^(?=(?:static |casadi_real |casadi_int |void |int )[^;\n]*[(\[])", "__device__ ", text, flags=re.M)


def _list_shared(graph: LaneGraph) -> dict[str, int]:
    """Return values that the angles share and use, each with its place."""
    invariants = {a.name for a in graph.invariant}
    used = [name for a in graph.varying for name in a.arguments if name in invariants]
    used += [store.value for store in graph.stores if store.value in invariants]
    return {name: index for index, name in enumerate(dict.fromkeys(used))}


def _list_lane_lines(graph: LaneGraph, shared: dict[str, int]) -> Iterator[str]:
    """Yield `before`: what the angles of a design share; and `lane`, the rows at an angle."""
    yield "static __device__ void before(const double *d, const double *h, double *own)"
    yield "{"
    yield from (f"  {_assign(a)}" for a in graph.invariant)
    yield from (f"  own[{index}] = {name};" for name, index in shared.items())
    yield "}\n"
    yield "static __device__ void lane(double phi, const double *q, const double *own, double *rows)"
    yield "{"
    yield from (f"  const double {name} = own[{index}];" for name, index in shared.items())
    yield from (f"  {_assign(a)}" for a in graph.varying)
    yield from (f"  rows[{store.place.index}] = {store.value};" for store in graph.stores)
    yield "}\n"


def _assign(assignment: Assignment) -> str:
    source = assignment.source
    if isinstance(source, ArrayElement):
        value = source.name if source.name == "phi" else f"{source.name}[{source.index}]"
    else:
        value = source.text.format(*assignment.arguments)
    return f"const double {assignment.name} = {value};"


def build_library(machine: Machine, folder: Path, architecture: str = "native") -> Path:
    """Return the shared library of a machine, built in a folder by nvcc. Raises CompilerError without it."""
    compiler = shutil.which("nvcc")
    if compiler is None:
        raise CompilerError("there is no CUDA compiler 'nvcc'")
    ((file, text),) = build_source_files(machine).items()
    source, library = folder / file, folder / f"lib{file.removesuffix('.cu')}.so"
    source.write_text(text, encoding="utf-8", newline="\n")
    command = [compiler, "-O3", f"-arch={architecture}", "-shared", "-Xcompiler", "-fPIC", str(source)]
    try:
        builds.run_program([*command, "-o", str(library)], toolchain.TIMEOUT_S, folder)
    except (OSError, subprocess.SubprocessError) as error:
        raise CompilerError(f"{compiler} did not compile {file}: {toolchain.summarise_error(error)}") from error
    return library


class Batches:
    """Cycles of many designs on a graphics processor, by the library that `build_library` made.

    Raises CompilerError if no processor answers.
    """

    def __init__(self, machine: Machine, library: Path, samples: int | None = None) -> None:
        self.machine, self.goal = machine, SampledGoal(machine)
        self.samples = samples or self.goal.samples
        name, raw = quantities.build_name(machine), ctypes.CDLL(str(library))
        self._run, self._error = getattr(raw, f"{name}_cycles"), getattr(raw, f"{name}_error")
        self._error.restype = ctypes.c_char_p
        if not getattr(raw, f"{name}_devices")():
            raise CompilerError("there is no graphics processor that runs CUDA")

    def __call__(self, designs: Array) -> Array:
        """Return rows of the goal's fields, (m, f), for designs (m, p) in SI.

        Raises ComputationError, with the row, for a design without a cycle, or with what the processor said;
        CallError for designs of another shape.
        """
        size = len(self.machine.moved)
        if designs.ndim != 2 or designs.shape[1] != size:
            raise CallError(f"designs have the shape (m, {size}), and were given as {designs.shape}")
        x, results = np.ascontiguousarray(designs, dtype=float), np.empty((len(designs), len(self.goal.fields)))
        angles = self.goal.count_angles(self.samples)
        nodes = [angle for _, angle in self.goal.nodes]
        phi = np.concatenate([self.machine.list_angles(self.samples)[:angles], nodes])
        lanes = np.add.outer(self.goal.response.offsets, phi).ravel()
        data = self.machine.data[quantities.list_fixed(self.machine)]
        code = self._run(
            ctypes.c_long(len(x)),
            _pointer(x),
            _pointer(data),
            ctypes.c_long(angles),
            _pointer(lanes),
            _pointer(results),
        )
        if code:
            raise ComputationError(f"the graphics processor failed: {self._error(code).decode()}")
        failed = ~np.isfinite(results).all(axis=1)
        if failed.any():
            raise ComputationError(f"there is no cycle at the design in row {int(failed.argmax())}")
        return results


def _pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
