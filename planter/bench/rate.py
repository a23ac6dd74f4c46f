"""Arithmetic of a turn against what the core can do at most.

Counted is the arithmetic of the lanes' graph: every operation once (a select and its comparison are one each, signs and
copies are free), a sine or cosine as the series that is printed for it. A fused multiply-add is two, in the peak as
well, so that a share of 100 % would need nothing but these. What the prologue and the statistics need is left out.
"""

from __future__ import annotations

import ctypes
from importlib import resources

from planter.bench.case import Case
from planter.bench.clock import timed
from planter.bench.results import Arithmetic, Rate
from planter.kernels import Kernel, toolchain
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
    """Arithmetic operations of a lane."""
    graph = Graph.of(kernel.function, kernel.lanes)
    found = [a for a in graph.varying if isinstance(a.source, Operation)]
    turned = {a.arguments for a in found if _text(a) in SERIES}
    return sum(_cost(_text(a)) for a in found) + REDUCTION * len(turned)


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
        """Operations a cycle of the ways that evaluate the lanes' graph, from medians by work and way."""
        force, turn = case.device.force, len(case.lanes)
        counts = {
            "cycle": turn * operations(force.value_kernel),
            "cycle+gradient": turn * operations(force.slopes_kernel),
        }
        rows = [
            Rate(work, way, counts[work], rate := counts[work] / (median * 1e-6 * self.hertz),
                 rate / self.operations_per_cycle)
            for work, medians in medians_us.items() if work in counts
            for way, median in medians.items() if way in ("casadi-vm", "casadi-c", "lanes")
        ]  # fmt: skip
        return Arithmetic(self.hertz / 1e9, self.operations_per_cycle, rows)
