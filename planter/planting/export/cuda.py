"""A device's turn as CUDA C++, from the same walk as the lane kernels: a thread for each design and angle.

What a design fixes is CasADi's own C, compiled for the device; what its angles share is computed once for a design.
The template `turns.cu` stands beside this file.
"""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from pathlib import Path
from string import Template

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, CallError, builds, toolchain
from planter.kernels.loops import functions
from planter.kernels.loops.graph import Assignment, Graph, NotPrintable, Place
from planter.kernels.toolchain import NoCompiler
from planter.planting import cycle
from planter.planting.export import c99
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.turns import FIELDS


def source_files(device: Device) -> dict[str, str]:
    """The text by its file name, `NAME.cu`."""
    own = c99.name(device)
    return {f"{own}.cu": Template(c99.template("turns.cu")).substitute(_values(device, own))}


def _values(device: Device, own: str) -> dict[str, object]:
    response = device.force.response
    function: ca.Function = response.hoisting_kernel.function
    work = response.values_kernel.work
    graph = Graph.of(work.function, work.varying)
    shared = _shared(graph)
    return {
        **c99.description(device), "name": own, "prologue": _for_device(c99.casadi_text(own, [function])),
        "weighed": _for_device(c99.template("weighed.c")),
        "functions": functions.fused(), "kernels": _kernels(graph, shared), "lane": work.function.name(),
        "parameters": len(device.design), "constants": len(device.constants), "shared": len(shared),
        "shares": len(device.force.offsets), "hoisted": function.nnz_out(0),
        **{key: getattr(function, f"sz_{key}")() + 1 for key in ("arg", "res", "iw", "w")},
    }  # fmt: skip


def _for_device(text: str) -> str:
    """CasADi's C with every function and table on the device: definitions are what begins in the first column."""
    return re.sub(r"^(?=(?:static |casadi_real |casadi_int |void |int )[^;\n]*[(\[])", "__device__ ", text, flags=re.M)


def _shared(graph: Graph) -> dict[str, int]:
    """Values that the angles share and use, each with its place."""
    own = {a.name for a in graph.invariant}
    used = [name for a in graph.varying for name in a.arguments if name in own]
    used += [store.value for store in graph.stores if store.value in own]
    return {name: index for index, name in enumerate(dict.fromkeys(used))}


def _kernels(graph: Graph, shared: dict[str, int]) -> str:
    """`before`: what the angles of a design share; and the function of an angle. Raises NotPrintable."""
    inputs, varying = graph.function.name_in(), graph.lanes
    if len(varying) != 1 or graph.function.numel_in(varying[0]) != 1 or len(graph.stores) != 1:
        raise NotPrintable(f"{graph.function.name()} is not one number for one angle")
    given = ", ".join(f"const double *{name}" for name in inputs if name not in varying)
    before = [f"static __device__ void before({given}, double *own)", "{"]
    before += [f"  {_line(a)}" for a in graph.invariant]
    before += [f"  own[{index}] = {name};" for name, index in shared.items()]
    lane = [f"static __device__ double {graph.function.name()}(double {varying[0]}, const double *own)", "{"]
    lane += [f"  const double {name} = own[{index}];" for name, index in shared.items()]
    lane += [f"  {_line(a)}" for a in graph.varying]
    lane += [f"  return {graph.stores[0].value};"]
    return "\n".join([*before, "}", "", *lane, "}", ""])


def _line(assignment: Assignment) -> str:
    source = assignment.source
    if isinstance(source, Place):
        value = source.name if assignment.varies else f"{source.name}[{source.index}]"
    else:
        value = source.text.format(*assignment.arguments)
    return f"const double {assignment.name} = {value};"


def build(device: Device, folder: Path, architecture: str = "native") -> Path:
    """The shared library of a device, made in a folder by NVIDIA's compiler. Raises NoCompiler where it is not."""
    compiler = shutil.which("nvcc")
    if compiler is None:
        raise NoCompiler("there is no CUDA compiler 'nvcc'")
    ((file, text),) = source_files(device).items()
    source, library = folder / file, folder / f"lib{file.removesuffix('.cu')}.so"
    source.write_text(text, encoding="utf-8", newline="\n")
    command = [compiler, "-O3", f"-arch={architecture}", "-shared", "-Xcompiler", "-fPIC", str(source)]
    try:
        builds.run([*command, "-o", str(library)], toolchain.TIMEOUT_S, folder)
    except (OSError, subprocess.SubprocessError) as error:
        raise NoCompiler(f"{compiler} did not compile {file}: {toolchain.said(error)}") from error
    return library


class Batches:
    """Turns of many designs on a graphics processor, by the library that `build` made.

    Raises NoCompiler where no processor answers.
    """

    def __init__(self, device: Device, library: Path, samples: int | None = None) -> None:
        self.device, self.objective = device, weights(device.machine)
        self.samples = samples or device.machine.objective.samples
        own, raw = c99.name(device), ctypes.CDLL(str(library))
        self._run, self._error = getattr(raw, f"{own}_turns"), getattr(raw, f"{own}_error")
        self._error.restype = ctypes.c_char_p
        if not getattr(raw, f"{own}_devices")():
            raise NoCompiler("there is no graphics processor that runs CUDA")

    def __call__(self, designs: Array) -> Array:
        """Rows of `FIELDS`, (m, 4), for designs (m, p) in SI.

        Raises ComputationError, with the row, for a design without a finite force, or with what the processor said;
        CallError for designs of another shape.
        """
        if designs.ndim != 2 or designs.shape[1] != len(self.device.design):
            raise CallError(f"designs have the shape (m, {len(self.device.design)}), and were given as {designs.shape}")
        x, found = np.ascontiguousarray(designs, dtype=float), np.empty((len(designs), len(FIELDS)))
        angles = c99.angles_of(self.device, self.samples)
        phi = np.add.outer(self.device.force.offsets, cycle.angles(self.samples)[:angles]).ravel()
        code = self._run(
            ctypes.c_long(len(x)), _pointer(x), _pointer(self.device.constants), ctypes.c_long(angles), _pointer(phi),
            ctypes.c_double(self.objective.weight_range), ctypes.c_double(self.objective.weight_variance),
            int(self.objective.kind == "newton"), _pointer(found),
        )  # fmt: skip
        if code:
            raise ComputationError(f"the graphics processor failed: {self._error(code).decode()}")
        failed = ~np.isfinite(found).all(axis=1)
        if failed.any():
            raise ComputationError(f"the force is not finite at the design in row {int(failed.argmax())}")
        return found


def _pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
