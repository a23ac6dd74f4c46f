"""Where a benchmark ran: processor, load, versions, compiler and flags."""

from __future__ import annotations

import ctypes
import gc
import os
import platform
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import metadata, resources
from pathlib import Path
from typing import Any

import numpy as np

from planter.bench.case import BenchmarkCase, Call, Contender
from planter.bench.results import (
    ArithmeticPeak,
    ArithmeticRate,
    BenchmarkMachine,
    DurationQuartiles,
)
from planter.errors import ComputationError
from planter.kernels import Array, Kernel, backends, builds, lane_source, toolchain
from planter.kernels.compiler import CompilerError, find_compiler
from planter.kernels.lane_graph import Assignment, LaneGraph, ScalarOperation
from planter.version import __version__

PACKAGES = ("casadi", "numpy", "scipy", "jax", "jaxlib", "sympy", "ezdxf", "ncgears")


def describe_machine() -> BenchmarkMachine:
    """Return processor, cores, system, and the load before the benchmark, which is None if it is
    unknown.
    """
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    system = f"{platform.system()} {platform.release()}"
    return BenchmarkMachine(_processor(), platform.machine(), os.cpu_count(), system, load)


def _processor() -> str:
    """Return the name of the processor, with family, model and stepping if the system has them."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor()
    first = text.partition("\n\n")[0]
    fields = {
        key.strip(): value.strip()
        for key, _, value in (line.partition(":") for line in first.splitlines())
    }
    if "model name" not in fields:
        return platform.processor()
    numbers = [
        f"{key.split()[-1]} {fields[key]}"
        for key in ("cpu family", "model", "stepping")
        if key in fields
    ]
    return f"{fields['model name']} ({', '.join(numbers)})" if numbers else fields["model name"]


def list_versions() -> dict[str, str]:
    """Return the versions of all installed packages that take part, of the compiler and its
    flags.
    """
    versions_by_name = {"planter": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            versions_by_name[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    libc = " ".join(platform.libc_ver()).strip()
    return {**versions_by_name, **({"libc": libc} if libc else {}), **_compiler()}


def _compiler() -> dict[str, str]:
    try:
        cc = find_compiler()
    except CompilerError:
        return {}
    flags = " ".join((*toolchain.OPTIMISED, *cc.flags))
    return {
        "compiler": cc.version,
        "flags": flags,
        "flags of lanes": " ".join((*toolchain.loop_flags(toolchain.OPTIMISED), *cc.flags)),
    }


MOST_CALLS = 200
"""Calls of a way before the next one has its turn."""


class Disagreement(ComputationError):
    """A way disagrees with the others, so that its time would mean nothing."""


@dataclass
class Times:
    """Durations of single calls [s]."""

    seconds: list[float] = field(default_factory=list)

    @property
    def median_us(self) -> float:
        return float(np.median(self.seconds)) * 1e6

    def quartiles(self) -> DurationQuartiles:
        """Return quartiles [us] and the number of calls."""
        low, high = np.percentile(self.seconds, (25, 75)) * 1e6
        return DurationQuartiles(float(low), float(high), len(self.seconds))


def check_agreement(
    work: str, contenders: Mapping[str, Contender], inputs: Sequence[Array]
) -> dict[str, float]:
    """Return the largest relative difference of each way from the first one over the inputs.

    Raises Disagreement, naming task and way, if a difference exceeds its tolerance.
    """
    reference, *_ = contenders
    worst = dict.fromkeys(contenders, 0.0)
    for x in inputs:
        expected = _parts(contenders[reference].call(x))
        for name, contender in contenders.items():
            parts = _parts(contender.call(x))
            if len(parts) != len(expected):
                raise Disagreement(
                    f"{work}: {name} gives {len(parts)} results, and {reference} {len(expected)}"
                )
            for part, target, tolerance in zip(parts, expected, contender.tolerances, strict=False):
                off = relative_difference(part, target)
                worst[name] = max(worst[name], off)
                if not off <= tolerance:
                    raise Disagreement(
                        f"{work}: {name} is off {reference} by {off:.2g}; {tolerance:g} is allowed"
                    )
    return worst


def relative_difference(values: Array, target: Array) -> float:
    """Return the largest difference relative to the largest entry; infinite if shapes differ or
    values are infinite.
    """
    if values.shape != target.shape or not np.isfinite(values).all():
        return float("inf")
    return float(np.abs(values - target).max() / np.abs(target).max())


def _parts(result: Any) -> list[Array]:
    return [
        np.atleast_1d(np.asarray(part, dtype=float))
        for part in (result if isinstance(result, tuple) else (result,))
    ]


def time_calls(
    calls: Mapping[str, Call], inputs: Iterator[Any], rounds: int, slot_s: float
) -> dict[str, Times]:
    """Return the times of each call on inputs that are new every time.

    In a round every way has its slot of about `slot_s` seconds (0: one call); who begins changes
    from round to round. The first call of a slot of many is not timed: it fetches a way's code and
    data into the caches again.
    """
    counts = {name: _calls(call, inputs, slot_s) for name, call in calls.items()}
    times = {name: Times() for name in calls}
    names = list(calls)
    with _undisturbed():
        for turn in range(rounds):
            for name in (*names[turn % len(names) :], *names[: turn % len(names)]):
                warm = counts[name] > 1
                _slot(
                    calls[name],
                    [next(inputs) for _ in range(counts[name] + warm)],
                    warm,
                    times[name],
                )
    return times


def _slot(call: Call, inputs: Sequence[Any], warm: bool, times: Times) -> None:
    if warm:
        call(inputs[0])
    for x in inputs[warm:]:
        times.seconds.append(time_call(lambda x=x: call(x)))  # type: ignore[misc]


def _calls(call: Call, inputs: Iterator[Any], slot_s: float) -> int:
    """Return the number of calls that fill a slot; 1, without a trial, for a slot of length 0."""
    if slot_s == 0:
        return 1
    taken = min(time_call(lambda: call(next(inputs))) for _ in range(2))
    return max(1, min(MOST_CALLS, int(slot_s / taken)))


def time_call(call: Callable[[], Any]) -> float:
    """Return the duration of a call [s]."""
    begun = time.perf_counter()
    call()
    return time.perf_counter() - begun


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Without the garbage collector's pauses."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


FREE = ("{0}", "-{0}")
REDUCTION = 13
"""Of an angle to a quarter turn, shared by sine and cosine."""
SERIES = {
    "turned_sin({0})": 2 * (lane_source.TERMS - 1) + 2,
    "turned_cos({0})": 2 * lane_source.TERMS + 1,
}
SUMS = 12
ROUNDS, CYCLES, FUSED = 9, 200_000, 200_000


def count_operations(kernel: Kernel) -> int:
    """Return the number of arithmetic operations in the graph of a lane."""
    graph = LaneGraph.from_function(kernel.function, kernel.lanes)
    assignments = [a for a in graph.varying if isinstance(a.source, ScalarOperation)]
    turned = {a.arguments for a in assignments if _text(a) in SERIES}
    return sum(_cost(_text(a)) for a in assignments) + REDUCTION * len(turned)


_INSTRUCTION = re.compile(r"^\s+([0-9a-f]+):\s+(\S+)\s*(.*)$", re.MULTILINE)
_PACKED = re.compile(
    r"v(add|sub|mul|div|sqrt|max|min|cmp\w*|blend\w*|round|rndscale)pd|(vfn?m(add|sub)\d+pd)"
)
_WIDTHS = ("zmm", "ymm")


def count_executed_operations(library: Path, name: str) -> int | None:
    """Return the number of arithmetic operations of a lane in the vector loop of a compiled
    function's machine code.

    Return None without objdump (GNU binutils), on processors other than x86-64, and if no loop has
    vectors.
    """
    tool = shutil.which("objdump")
    if tool is None:
        return None
    command = [tool, "-d", "--no-show-raw-insn", f"--disassemble={name}", str(library)]
    try:
        text = builds.run_program(command, toolchain.TIMEOUT_S).stdout.decode(errors="replace")
    except (OSError, subprocess.SubprocessError):
        return None
    instructions = [
        (address, code, operands) for address, code, operands in _INSTRUCTION.findall(text)
    ]
    counts = [_vector_operations(body) for body in _loop_bodies(instructions)]
    return max(counts, default=0) or None


def _loop_bodies(instructions: list[tuple[str, str, str]]) -> Iterator[list[tuple[str, str, str]]]:
    """Yield the instructions from the target of each backward jump to that jump."""
    places = {address: index for index, (address, _, _) in enumerate(instructions)}
    for index, (_, code, operands) in enumerate(instructions):
        target = places.get(operands.partition(" ")[0], index) if code.startswith("j") else index
        if target < index:
            yield instructions[target : index + 1]


def _vector_operations(body: list[tuple[str, str, str]]) -> int:
    """Return the number of packed operations of a loop on its widest registers; a fused
    multiply-add is two.
    """
    packed = [(match, operands) for _, code, operands in body if (match := _PACKED.fullmatch(code))]
    widest = next(
        (width for width in _WIDTHS if any(width in operands for _, operands in packed)), None
    )
    return sum(2 if match[2] else 1 for match, operands in packed if widest and widest in operands)


def _text(assignment: Assignment) -> str:
    return assignment.source.text if isinstance(assignment.source, ScalarOperation) else ""


def _cost(text: str) -> int:
    return 0 if text in FREE else SERIES.get(text, 1)


class Peak:
    """Cycles per second, operations per cycle, and vector width of one core, measured.

    Raises CompilerError.
    """

    def __init__(self) -> None:
        source = resources.files(__package__).joinpath("peak.c").read_text(encoding="utf-8")
        raw = toolchain.load_library(toolchain.build_library("peak", source, toolchain.OPTIMISED))
        raw.fused.argtypes = (ctypes.c_long, ctypes.c_double, ctypes.c_double)
        raw.fused.restype, raw.cycles.argtypes = ctypes.c_double, (ctypes.c_long, ctypes.c_long)
        self.lanes = int(raw.lanes())
        clock = min(time_call(lambda: raw.cycles(CYCLES, 1)) for _ in range(ROUNDS))
        fused = min(time_call(lambda: raw.fused(FUSED, 0.5, 1.0)) for _ in range(ROUNDS))
        self.hertz = 16 * CYCLES / clock
        self.operations_per_cycle = 2 * SUMS * self.lanes * FUSED / fused / self.hertz

    @property
    def vector_width(self) -> int:
        """Width of a vector [bit]."""
        return 64 * self.lanes

    def table(self, case: BenchmarkCase, medians_us: dict[str, dict[str, float]]) -> ArithmeticPeak:
        """Return the operations per cycle of the ways whose operations can be counted, from medians
        by task and way.
        """
        response, turn = case.device.force.response, len(case.lanes)
        kernels = {"cycle": response.values_kernel, "cycle+gradient": response.slopes_kernel}
        rows = []
        for work, kernel in kernels.items():
            counts = {"casadi-vm": count_operations(kernel), "lanes": _compiled_operations(kernel)}
            for way, median in medians_us.get(work, {}).items():
                if count := counts.get(way):
                    rate = turn * count / (median * 1e-6 * self.hertz)
                    rows.append(
                        ArithmeticRate(
                            work, way, turn * count, rate, rate / self.operations_per_cycle
                        )
                    )
        return ArithmeticPeak(self.hertz / 1e9, self.operations_per_cycle, rows)


def _compiled_operations(kernel: Kernel) -> int | None:
    kernel.compile()
    return count_executed_operations(
        backends.build_lane_library(kernel.work), kernel.function.name()
    )
