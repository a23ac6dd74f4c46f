"""Tasks of the benchmark: which ways take part, their agreement, then their times."""

from __future__ import annotations

import gc
import os
import platform
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from planter import workers
from planter.cli.bench.results import WORKS, Benchmark, TaskTimes, WayTimes
from planter.cli.bench.ways import BUILDERS, MACHINE, Absent, Call, TimedCycle
from planter.errors import ComputationError
from planter.kernels import Array
from planter.kernels.compiler import CompilerError, find_compiler
from planter.papers.planting import optimisation
from planter.papers.planting.model import Device
from planter.progress import Listener, ProgressPhase
from planter.version import __version__

EXACT = 1e-10
"""Ways must agree to this, relative to the largest entry of what they find."""
CHECKED, DESIGNS = 5, 1000
"""Designs at which the ways must agree; designs of a batch."""
ROUNDS, FEW_ROUNDS = 12, 3
"""Repetitions of a cycle's task, and of those that take seconds."""
SLOT_S, MOST_CALLS = 0.03, 200
"""Duration of a way's part of a round, and the number of its calls at most."""
PACKAGES = ("casadi", "numpy", "jax", "sympy")
UNITS = {
    "cycle": "us per cycle: objective",
    "cycle+gradient": "us per cycle: objective and gradient",
    "hessian": "us per cycle: Hessian of the objective",
    "batch": f"us per {DESIGNS} designs: their objectives",
    "optimise": "us per optimisation of the printed model",
    "derive": "us per derivation, all of generated/",
    "cold start": "us per new process: objective and gradient of a cycle",
}
GRADIENT = f"""\
from planter import Device, Turns, load_machine
turns = Turns(Device(load_machine({MACHINE!r})))
turns.gradient(turns.machine.design)
"""
"""What a new process does."""
DERIVED = ("derive", "generated", "planter")
"""What the derivation reads and writes, in a checkout."""

Calls = Mapping[str, Callable[[Any], Any]]


def run_benchmark(works: Sequence[str], progress: Listener | None = None) -> Benchmark:
    """Return the times of some tasks. Raises ComputationError if a way disagrees with the others."""
    cycle, phase = TimedCycle(), ProgressPhase("bench", "work", len(works), progress)
    skipped = {name: "not among the quick tasks" for name in WORKS if name not in works}
    results = []
    for name in works:
        try:
            results.append(run_task(name, cycle))
        except Absent as reason:
            skipped[name] = str(reason)
        phase.advance(name)
    machine = {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
    }
    return Benchmark(results, machine, list_versions(), skipped)


def run_task(name: str, cycle: TimedCycle) -> TaskTimes:
    """Return the times of a task. Raises Absent if it cannot be done here."""
    if name == "optimise":
        return time_task(name, list_searches(cycle), _count(), "ipopt")
    if name == "derive":
        with prepare_derivation() as derive:
            return time_task(name, {"derive": derive}, _count(), "derive")
    if name == "cold start":
        ways = ("lanes", "casadi-c", "casadi-vm")
        return time_task(name, {way: build_start(way) for way in ways}, _count(), "lanes")
    calls: dict[str, Call] = {}
    skipped = {}
    for way, build in BUILDERS.items():
        try:
            calls[way] = build(cycle, name)
        except Absent as reason:
            skipped[way] = str(reason)
    rng = np.random.default_rng(0)

    def draw() -> Iterator[Array]:
        while True:
            designs = cycle.draw_designs(rng, DESIGNS if name == "batch" else 1)
            yield designs if name == "batch" else designs[0]

    designs = draw()
    check_agreement(name, calls, [next(designs) for _ in range(1 if name == "batch" else CHECKED)])
    return time_task(name, calls, designs, "lanes", skipped)


def _count() -> Iterator[int]:
    yield from range(1_000_000)


def check_agreement(work: str, calls: Mapping[str, Call], inputs: Sequence[Array]) -> None:
    """Raise ComputationError, naming task and way, if a way's results are not those of the first."""
    reference, *compared = calls
    for x in inputs:
        expected = _list_parts(calls[reference](x))
        for name in compared:
            for part, target in zip(_list_parts(calls[name](x)), expected, strict=True):
                off = float(np.abs(part - target).max() / np.abs(target).max())
                if not off <= EXACT:
                    raise ComputationError(
                        f"{work}: {name} is off {reference} by {off:.2g}; {EXACT:g} is allowed"
                    )


def _list_parts(result: Any) -> list[Array]:
    parts = result if isinstance(result, tuple) else (result,)
    return [np.atleast_1d(np.asarray(part, dtype=float)) for part in parts]


def time_task(
    name: str, calls: Calls, inputs: Iterator[Any], over: str, skipped: dict[str, str] | None = None
) -> TaskTimes:
    """Return the times of each way on inputs that are new every time, with ratios to that of `over`.

    In a round every way has its slot, of as many calls as fill it; who begins changes from round to
    round. The first calls, which also fill caches, are not timed.
    """
    counts = {}
    for way, call in calls.items():
        call(next(inputs))
        counts[way] = max(1, min(MOST_CALLS, int(SLOT_S / time_call(call, next(inputs)))))
    rounds = ROUNDS if max(counts.values()) > 1 else FEW_ROUNDS
    seconds: dict[str, list[float]] = {way: [] for way in calls}
    order = list(calls)
    gc.disable()
    try:
        for _ in range(rounds):
            for way in order:
                slot = [next(inputs) for _ in range(counts[way])]
                seconds[way] += [time_call(calls[way], x) for x in slot]
            order.append(order.pop(0))
    finally:
        gc.enable()
    medians = {way: 1e6 * float(np.median(taken)) for way, taken in seconds.items()}
    reference = medians.get(over, next(iter(medians.values())))
    ways = [WayTimes(way, us, us / reference, len(seconds[way])) for way, us in medians.items()]
    return TaskTimes(name, UNITS[name], ways, skipped or {})


def time_call(call: Callable[[Any], Any], x: Any) -> float:
    """Return the duration of a call [s]."""
    begun = time.perf_counter()
    call(x)
    return time.perf_counter() - begun


def list_searches(cycle: TimedCycle) -> Calls:
    """Return the searches for the optimum of the printed model by their seed: it has one basin."""
    device = Device(cycle.device.machine, "printed")
    device.compile()
    samples = device.machine.objective.samples

    def search(method: Any, starts: int | None) -> Callable[[int], object]:
        return lambda seed: optimisation.search_optimum(device, method, samples, seed, starts)

    return {
        "ga": search("ga", None),
        "ipopt": search("ipopt", 1),
        "hybrid": search("hybrid", None),
    }


def build_start(way: str) -> Callable[[object], None]:
    """Return the start of a new process that evaluates kernels by a way, those in the cache."""
    command = workers.python_command(GRADIENT)
    return lambda _: run_process(command, PLANTER_KERNELS=way)


def run_process(command: Sequence[str], cwd: Path | None = None, **variables: str) -> None:
    """Run a process in a folder. Raises ComputationError if it fails."""
    done = workers.run_command(command, cwd, variables)
    if done.returncode:
        reason = " ".join(done.stderr.strip().splitlines()[-1:])
        raise ComputationError(f"a process of Python ended with {done.returncode}: {reason}")


@contextmanager
def prepare_derivation() -> Iterator[Callable[[object], None]]:
    """Yield `python -m derive` in a copy of the checkout. Raises Absent outside one."""
    place = find_spec("derive")
    source = Path(place.origin).parents[1] if place and place.origin else Path()
    if find_spec("sympy") is None or not all((source / name).is_dir() for name in DERIVED):
        raise Absent("this is no checkout with SymPy")
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        copy = Path(folder)
        for name in DERIVED:
            shutil.copytree(source / name, copy / name)
        command = workers.program_command("derive", checkout=copy)
        yield lambda _: run_process(command, copy)


def list_versions() -> dict[str, str]:
    """Return the versions of all installed packages that take part, and of the compiler."""
    versions = {"planter": __version__, "python": platform.python_version()}
    versions |= {name: metadata.version(name) for name in PACKAGES if find_spec(name)}
    try:
        return {**versions, "compiler": find_compiler().version}
    except CompilerError:
        return versions


Table = tuple[Sequence[str], Sequence[Sequence[object]]]


def tabulate_benchmark(result: Benchmark) -> dict[str, Table]:
    """Return the tables of a benchmark by title: head and rows."""
    tables: dict[str, Table] = {}
    for task in result.work:
        rows = [(row.way, f"{row.median_us:.3g}", f"{row.ratio:.3g}") for row in task.ways]
        rows += [(way, "-", reason) for way, reason in task.skipped.items()]
        tables[f"{task.name} [{task.unit}]"] = ("way", "median / us", "ratio"), rows
    surroundings = {**result.machine, **result.versions}
    tables["Where it ran"] = ("name", "value"), list(surroundings.items())
    tables["Left out"] = ("task", "reason"), list(result.skipped.items())
    return tables


def format_markdown(tables: Mapping[str, Table]) -> str:
    """Return tables in Markdown."""
    lines = []
    for title, (head, rows) in tables.items():
        lines += [f"## {title}", ""]
        lines += [f"| {' | '.join(map(str, row))} |" for row in (head, ["---"] * len(head), *rows)]
        lines.append("")
    return "\n".join(lines)
