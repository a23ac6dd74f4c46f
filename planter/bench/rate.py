"""Arithmetic of a turn against what the core can do at most.

Counted is what is executed: of compiled lanes the arithmetic of the vector loop in their machine code, since a
compiler removes what cancels and what another step computes too; of CasADi's virtual machine, which executes all of
it, every operation of the graph once (a select and its comparison are one each, signs and copies are free). A fused
multiply-add is two, in the peak as well, so that a share of 100 % would need nothing but these. Left out is what the
prologue and the statistics need, and what a function of a library does, such as the arc tangent of vectors.
"""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

from planter.bench.case import Case
from planter.bench.clock import timed
from planter.bench.results import Arithmetic, Rate
from planter.kernels import Kernel, backends, builds, toolchain
from planter.kernels.loops import Graph, functions
from planter.kernels.loops.graph import Assignment
from planter.kernels.loops.operations import Operation

FREE = ("{0}", "-{0}")
REDUCTION = 13
"""Of an angle to a quarter turn, shared by sine and cosine."""
SERIES = {"turned_sin({0})": 2 * (functions.TERMS - 1) + 2, "turned_cos({0})": 2 * functions.TERMS + 1}
SUMS = 12
ROUNDS, CYCLES, FUSED = 9, 200_000, 200_000


def operations(kernel: Kernel) -> int:
    """Arithmetic operations of a lane's graph."""
    graph = Graph.of(kernel.function, kernel.lanes)
    assignments = [a for a in graph.varying if isinstance(a.source, Operation)]
    turned = {a.arguments for a in assignments if _text(a) in SERIES}
    return sum(_cost(_text(a)) for a in assignments) + REDUCTION * len(turned)


_INSTRUCTION = re.compile(r"^\s+([0-9a-f]+):\s+(\S+)\s*(.*)$", re.MULTILINE)
_PACKED = re.compile(r"v(add|sub|mul|div|sqrt|max|min|cmp\w*|blend\w*|round|rndscale)pd|(vfn?m(add|sub)\d+pd)")
_WIDTHS = ("zmm", "ymm")


def executed_operations(library: Path, name: str) -> int | None:
    """Arithmetic operations of a lane in the vector loop of a compiled function, from its machine code.

    None without objdump (GNU binutils), on processors other than x86-64, and where there is no loop in vectors.
    """
    tool = shutil.which("objdump")
    if tool is None:
        return None
    command = [tool, "-d", "--no-show-raw-insn", f"--disassemble={name}", str(library)]
    try:
        text = builds.run(command, toolchain.TIMEOUT_S).stdout.decode(errors="replace")
    except (OSError, subprocess.SubprocessError):
        return None
    instructions = [(address, code, operands) for address, code, operands in _INSTRUCTION.findall(text)]
    counts = [_vector_operations(body) for body in _loop_bodies(instructions)]
    return max(counts, default=0) or None


def _loop_bodies(instructions: list[tuple[str, str, str]]) -> Iterator[list[tuple[str, str, str]]]:
    """Instructions from the target of each jump back to that jump."""
    places = {address: index for index, (address, _, _) in enumerate(instructions)}
    for index, (_, code, operands) in enumerate(instructions):
        target = places.get(operands.partition(" ")[0], index) if code.startswith("j") else index
        if target < index:
            yield instructions[target : index + 1]


def _vector_operations(body: list[tuple[str, str, str]]) -> int:
    """Operations of the packed arithmetic of a loop on its widest registers; a fused multiply-add is two."""
    packed = [(match, operands) for _, code, operands in body if (match := _PACKED.fullmatch(code))]
    widest = next((width for width in _WIDTHS if any(width in operands for _, operands in packed)), None)
    return sum(2 if match[2] else 1 for match, operands in packed if widest and widest in operands)


def _text(assignment: Assignment) -> str:
    return assignment.source.text if isinstance(assignment.source, Operation) else ""


def _cost(text: str) -> int:
    return 0 if text in FREE else SERIES.get(text, 1)


class Peak:
    """Measured on one core: cycles and operations a second, and the width of a vector. Raises NoCompiler."""

    def __init__(self) -> None:
        source = resources.files(__package__).joinpath("peak.c").read_text(encoding="utf-8")
        raw = toolchain.load(toolchain.library("peak", source, toolchain.OPTIMISED))
        raw.fused.argtypes = (ctypes.c_long, ctypes.c_double, ctypes.c_double)
        raw.fused.restype, raw.cycles.argtypes = ctypes.c_double, (ctypes.c_long, ctypes.c_long)
        self.lanes = int(raw.lanes())
        clock = min(timed(lambda: raw.cycles(CYCLES, 1)) for _ in range(ROUNDS))
        fused = min(timed(lambda: raw.fused(FUSED, 0.5, 1.0)) for _ in range(ROUNDS))
        self.hertz = 16 * CYCLES / clock
        self.operations_per_cycle = 2 * SUMS * self.lanes * FUSED / fused / self.hertz

    @property
    def vector_width(self) -> int:
        """Bits."""
        return 64 * self.lanes

    def table(self, case: Case, medians_us: dict[str, dict[str, float]]) -> Arithmetic:
        """Operations a cycle of the ways whose operations can be counted, from medians by work and way."""
        response, turn = case.device.force.response, len(case.lanes)
        kernels = {"cycle": response.values_kernel, "cycle+gradient": response.slopes_kernel}
        rows = []
        for work, kernel in kernels.items():
            counts = {"casadi-vm": operations(kernel), "lanes": _compiled_operations(kernel)}
            for way, median in medians_us.get(work, {}).items():
                if count := counts.get(way):
                    rate = turn * count / (median * 1e-6 * self.hertz)
                    rows.append(Rate(work, way, turn * count, rate, rate / self.operations_per_cycle))
        return Arithmetic(self.hertz / 1e9, self.operations_per_cycle, rows)


def _compiled_operations(kernel: Kernel) -> int | None:
    kernel.compile()
    return executed_operations(backends.lane_library(kernel.work), kernel.function.name())
