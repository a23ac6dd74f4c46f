"""Tasks of the benchmark: which ways take part, their agreement, then their times; each ends as a
record.
"""

from __future__ import annotations

import io
import itertools
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from ezdxf.entities.lwpolyline import LWPolyline
from ezdxf.filemanagement import read

from planter.bench import casadi_backends, measurement, mechanisms
from planter.bench.array_backends import (
    build_jax_contender,
    build_numpy_contender,
    build_stacked_contender,
    build_sympy_contender,
)
from planter.bench.casadi_backends import (
    build_c_contender,
    build_fast_c_contender,
    build_virtual_machine,
)
from planter.bench.case import Absent, BenchmarkCase, Contender
from planter.bench.measurement import Peak, Times, check_agreement, time_calls
from planter.bench.mechanisms import cold_starts, prepare_derivation
from planter.bench.results import (
    WAYS,
    WORKS,
    ArithmeticPeak,
    BasinSearch,
    Benchmark,
    BenchmarkSettings,
    DrawnOutline,
    ReachedObjectives,
    SeedTimes,
    SkippedTask,
    SkippedWay,
    TaskTimes,
    WayTimes,
)
from planter.gear_geometry import cutting, pitch_curves
from planter.gear_geometry.cutting import ToothOrder
from planter.kernels import Array
from planter.kernels.compiler import CompilerError
from planter.optimise import optimiser
from planter.optimise.local_search import search_from_starts
from planter.planting import optimisation
from planter.planting.model import Device
from planter.planting.objective import build_problem
from planter.progress import Listener, ProgressPhase
from planter.workshop import drawing
from planter.workshop.arcs import ArcFit, fit_arcs
from planter.workshop.drawing import DrawingLine

REFERENCE = "ipopt"
SEARCHES = {
    "ga": "the machine file's settings, a new seed at every call",
    "ipopt": "from the machine file's design",
    "hybrid": "both, IPOPT from the default number of starts, and the best individuals polished",
}
MOST_STARTS = 64
CLOSE = 1e-9


def compile_device(case: BenchmarkCase, model: str) -> Device:
    """The device in a model, everything compiled beforehand: compile time is not counted."""
    device = case.device if model == case.device.model else Device(case.device.machine, "printed")
    device.compile()
    device.force.response.hessian_kernel.compile()
    return device


def time_printed_searches(
    case: BenchmarkCase, rounds: int
) -> tuple[dict[str, Times], dict[str, list[float]]]:
    """The printed model has one basin: durations of each method, and the objectives it reached."""
    device = compile_device(case, "printed")
    samples = device.machine.objective.samples
    reached: dict[str, list[float]] = {name: [] for name in SEARCHES}

    def run(name: Any, starts: int | None) -> Callable[[Any], None]:
        return lambda seed: reached[name].append(
            optimisation.search_optimum(device, name, samples, seed, starts).objective
        )

    calls = {"ga": run("ga", None), "ipopt": run("ipopt", 1), "hybrid": run("hybrid", None)}
    for name in ("ipopt", "hybrid"):  # whatever they compile on the way is not counted either
        calls[name](0)
    return time_calls(calls, itertools.count(), rounds, 0), reached


def search_exact(case: BenchmarkCase, rounds: int) -> BasinSearch:
    """The exact model has several basins: time and starts until IPOPT meets what the GA found, for
    each seed.
    """
    device = compile_device(case, "exact")
    return BasinSearch("exact", [_met(device, seed) for seed in range(rounds)])


def _met(device: Device, seed: int) -> SeedTimes:
    sought, begun = build_problem(device, device.machine.objective.samples), time.perf_counter()
    target = optimiser.search_genetically(sought, device.machine.genetic_algorithm, seed)[
        0
    ].objective
    ga_s = time.perf_counter() - begun
    problem, begun = build_problem(device, device.machine.objective.samples), time.perf_counter()
    best, starts = float("inf"), 0
    for minimum in search_from_starts(problem, MOST_STARTS, seed):
        best, starts = min(best, minimum.objective), starts + 1
        if best <= target * (1 + CLOSE):
            break
    ipopt_s = time.perf_counter() - begun
    return SeedTimes(seed, target, ga_s, best, ipopt_s, starts, met=best <= target * (1 + CLOSE))


ECCENTRICITY, TEETH, MODULE, TOLERANCE = 0.2, 30, 2e-3, 1e-6
GEARS_UNIT = (
    f"us per pair of ellipses of eccentricity {ECCENTRICITY} with {TEETH} teeth each: "
    f"outlines, checks, DXF"
)


@dataclass(frozen=True)
class Maker:
    """A way to make the pair: a call, how it was built, and the measures of the last drawing."""

    make: Callable[[Any], None]
    built: str
    measure: Callable[[], DrawnOutline]


def build_makers(case: BenchmarkCase) -> tuple[dict[str, Maker], list[SkippedWay]]:
    """Return the ways that make the pair, and those that do not, with the reason."""
    makers = {"planter": build_planter_maker(case)}
    try:
        return {**makers, "ncgears": build_ncgears_maker()}, []
    except Absent as reason:
        return makers, [SkippedWay("ncgears", str(reason))]


def build_planter_maker(case: BenchmarkCase) -> Maker:
    """Exact pieces, all contacts solved, arcs within a micrometre."""
    device = Device(
        case.device.machine.with_numbers({"design.k6": ECCENTRICITY, "design.m61": 1.0})
    )
    fits: list[ArcFit] = []

    def make(_: Any) -> None:
        curves = pitch_curves.build_stage_pair(device.stages[1], device.of_stage(1, device.design))
        order = ToothOrder(module=MODULE, keep="module")
        teeth = cutting.cut_teeth(curves, order, "ellipses", ("inner gear", "outer gear"))
        fits[:] = [fit_arcs(gear.outline(), TOLERANCE) for gear in teeth.gears]
        drawing.format_dxf(DrawingLine("TEETH", fit.arcs) for fit in fits)
        if teeth.gears[0].z != TEETH or np.abs(teeth.contacts.errors).max() > TOLERANCE:
            raise Absent("the pair does not mesh")

    def measure_drawing() -> DrawnOutline:
        return DrawnOutline(
            sum(len(fit.arcs.vertices) for fit in fits), max(fit.deviation for fit in fits) * 1e6
        )

    return Maker(make, "exact pieces, contacts solved, biarcs within 1 um", measure_drawing)


def build_ncgears_maker() -> Maker:
    """ncgears, as its documentation calls it. Raises Absent where it is not installed."""
    try:
        ncgears = import_module("ncgears")
    except ModuleNotFoundError:
        raise Absent("ncgears is not installed") from None
    folder = tempfile.TemporaryDirectory()
    file = Path(folder.name) / "pair.dxf"
    outlines: list[Any] = []

    def make(_: Any) -> None:
        gears = ncgears.generate_from_centrode(
            f"1/(1-{ECCENTRICITY}*cos(phi))",
            teeth=TEETH,
            module=MODULE * 1e3,
            output_directory=folder.name,
        )
        gears.export_dxf(file)
        outlines[:] = [gears.drive_outline, gears.placed_driven_outline]

    def measure_drawing() -> DrawnOutline:
        space = read(io.StringIO(file.read_text(encoding="utf-8"))).modelspace()
        lines = [line for line in space if isinstance(line, LWPolyline)]
        rings = [shapely.LinearRing(np.array(line.get_points("xy"))) for line in lines]
        off = [
            shapely.distance(shapely.points(dense), ring).max()
            for dense, ring in zip(outlines, rings, strict=True)
        ]
        return DrawnOutline(sum(len(ring.coords) - 1 for ring in rings), float(max(off)) * 1e3)

    return Maker(make, "generate_from_centrode and export_dxf with their defaults", measure_drawing)


Builder = Callable[[BenchmarkCase, str], Contender]
Built = Mapping[str, str]

BUILDERS: dict[str, Builder] = {
    "numpy": build_numpy_contender,
    "lambdify": build_sympy_contender,
    "jax": build_jax_contender,
    "casadi-vm": build_virtual_machine,
    "casadi-c": build_c_contender,
    "lanes": casadi_backends.build_kernel_contender,
}
VARIANTS: dict[str, Builder] = {
    "numpy, steps in one array": build_stacked_contender,
    "casadi-c, -ffast-math": build_fast_c_contender,
}
"""Other settings of the peers, timed beside them where they do the work."""
CHECKED = 5
"""Designs at which the ways must agree."""
UNITS = {
    "cycle": "us per turn: objective",
    "cycle+gradient": "us per turn: objective and gradient",
    "hessian": "us per turn: Hessian of the objective",
    "optimise": "us per optimisation of the printed model",
    "gears": GEARS_UNIT,
    "derive": "us per derivation, all of generated/",
    "cold start": "us per new process",
}


def run_task(name: str, case: BenchmarkCase, settings: BenchmarkSettings) -> TaskTimes:
    """One work. Raises Absent where it cannot be done here, Disagreement where a way is wrong."""
    if name in ("cycle", "cycle+gradient", "hessian"):
        return _turn(name, case, settings)
    if name == "batch":
        return _batch(case, settings)
    if name == "optimise":
        return _optimise(case, settings)
    if name == "gears":
        return _gears(case, settings)
    if name in mechanisms.EXAMPLES:
        return _mechanism(name, settings)
    return _derive(settings) if name == "derive" else _cold_start(settings)


def _turn(name: str, case: BenchmarkCase, settings: BenchmarkSettings) -> TaskTimes:
    """A new design at every call, through what each way calls its public function."""
    contenders, skipped = list_contenders(name, case, settings)
    designs = case.designs()
    off = check_agreement(name, contenders, [next(designs) for _ in range(CHECKED)])
    calls = {way: contender.call for way, contender in contenders.items()}
    times = time_calls(calls, designs, settings.rounds, settings.slot_s)
    return build_task_times(
        name, times, "lanes", {way: c.built for way, c in contenders.items()}, off, skipped
    )


def _batch(case: BenchmarkCase, settings: BenchmarkSettings) -> TaskTimes:
    contenders, skipped = list_contenders("batch", case, settings)
    rng = np.random.default_rng(0)

    def inputs() -> Iterator[Array]:
        while True:
            yield case.draw_designs(rng, settings.designs)

    off = check_agreement("batch", contenders, [next(inputs())])
    times = time_calls(
        {way: c.call for way, c in contenders.items()}, inputs(), settings.batches, 0
    )
    built = {way: c.built for way, c in contenders.items()}
    unit = f"us per {settings.designs} designs: their objectives, {os.cpu_count()} cores"
    return replace(build_task_times("batch", times, "lanes", built, off, skipped), unit=unit)


def _optimise(case: BenchmarkCase, settings: BenchmarkSettings) -> TaskTimes:
    times, reached = time_printed_searches(case, settings.searches)
    work = build_task_times("optimise", times, REFERENCE, SEARCHES)
    ways = [
        replace(w, objectives=ReachedObjectives(min(reached[w.way]), max(reached[w.way])))
        for w in work.ways
    ]
    return replace(
        work, ways=ways, exact=None if settings.quick else search_exact(case, settings.searches)
    )


def _gears(case: BenchmarkCase, settings: BenchmarkSettings) -> TaskTimes:
    ways, skipped = build_makers(case)
    times = time_calls(
        {name: way.make for name, way in ways.items()}, _nothing(), settings.pairs, 0
    )
    work = build_task_times(
        "gears", times, "planter", {name: way.built for name, way in ways.items()}, skipped=skipped
    )
    return replace(work, ways=[replace(row, drawn=ways[row.way].measure()) for row in work.ways])


def _mechanism(name: str, settings: BenchmarkSettings) -> TaskTimes:
    """Measure a user-defined mechanism, and the time from its statement to functions."""
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        begun = time.perf_counter()
        case = mechanisms.MechanismCase(name, Path(folder))
        seconds = time.perf_counter() - begun
        contenders: dict[str, Contender] = {}
        skipped: list[SkippedWay] = []
        for way, builder in mechanisms.BUILDERS.items():
            try:
                if way not in settings.ways:
                    raise Absent("not asked for (--way)")
                contenders[way] = builder(case)
            except Absent as reason:
                skipped.append(SkippedWay(way, str(reason)))
        designs = case.designs()
        off = check_agreement(name, contenders, [next(designs) for _ in range(CHECKED)])
        calls = {way: contender.call for way, contender in contenders.items()}
        times = time_calls(calls, designs, settings.rounds, settings.slot_s)
        built = {way: c.built for way, c in contenders.items()}
    unit = (
        f"us per turn of {mechanisms.ANGLES} angles: mean square of the torque and gradient; "
        f"derived in {seconds:.2f} s"
    )
    return replace(build_task_times(name, times, "lanes", built, off, skipped), unit=unit)


def _derive(settings: BenchmarkSettings) -> TaskTimes:
    with prepare_derivation() as start:
        times = time_calls({"derive": start}, _nothing(), settings.derivations, 0)
    return build_task_times(
        "derive", times, "derive", {"derive": "python -m derive, in a copy of the checkout"}
    )


def _cold_start(settings: BenchmarkSettings) -> TaskTimes:
    with cold_starts() as (starts, built):
        times = time_calls(starts, _nothing(), settings.processes, 0)
    return build_task_times("cold start", times, "lanes", built)


def _nothing() -> Iterator[None]:
    while True:
        yield None


def list_contenders(
    name: str, case: BenchmarkCase, settings: BenchmarkSettings
) -> tuple[dict[str, Contender], list[SkippedWay]]:
    """Return the ways of a work, CasADi's virtual machine first, and those left out, with the
    reason.
    """
    contenders: dict[str, Contender] = {}
    skipped: list[SkippedWay] = []
    variants = {} if settings.quick or settings.ways != WAYS else VARIANTS
    for way, builder in {**BUILDERS, **variants}.items():
        try:
            if way not in settings.ways and way not in variants:
                raise Absent("not asked for (--way)")
            contenders[way] = (
                _thrifty(case, name) if way == "jax" and settings.quick else builder(case, name)
            )
        except Absent as reason:
            if way not in variants:
                skipped.append(SkippedWay(way, str(reason)))
    return dict(sorted(contenders.items(), key=lambda item: item[0] != "casadi-vm")), skipped


def _thrifty(case: BenchmarkCase, name: str) -> Contender:
    """JAX in one form alone, since each takes it seconds to compile."""
    return build_jax_contender(case, name, thorough=False)


def build_task_times(
    name: str,
    times: Mapping[str, Times],
    over: str,
    built: Built,
    off: Mapping[str, float] | None = None,
    skipped: list[SkippedWay] | None = None,
) -> TaskTimes:
    """A work as the interface gives it: ratios over the way `over`, or over the first where that is
    not there.
    """
    reference = over if over in times else next(iter(times))
    rows = [
        WayTimes(
            way,
            taken.median_us,
            taken.median_us / times[reference].median_us,
            taken.quartiles(),
            built[way],
            off[way] if off else None,
        )
        for way, taken in times.items()
    ]
    order = (*WAYS, *times)
    rows.sort(key=lambda row: order.index(row.way))
    ways, variants = ([r for r in rows if (r.way in VARIANTS) is other] for other in (False, True))
    return TaskTimes(name, UNITS.get(name, ""), reference, ways, variants, skipped or [])


def run_benchmark(chosen: BenchmarkSettings, progress: Listener | None = None) -> Benchmark:
    """Return the chosen works that can be done here, as the interface gives them.

    Raises planter.bench.measurement.Disagreement if a way disagrees with the others.
    """
    begun, machine = time.perf_counter(), measurement.describe_machine()
    case = BenchmarkCase()
    results, reason = list[TaskTimes](), "--quick" if chosen.quick else "not asked for (--work)"
    skipped = [SkippedTask(name, reason) for name in WORKS if name not in chosen.works]
    phase = ProgressPhase("bench", "work", len(chosen.works), progress)
    for name in chosen.works:
        try:
            results.append(run_task(name, case, chosen))
        except Absent as missing:
            skipped.append(SkippedTask(name, str(missing)))
        phase.advance(name)
    width: int | None = None
    arithmetic: ArithmeticPeak | None = None
    try:
        peak = Peak()
        medians = {work.name: {way.way: way.median_us for way in work.ways} for work in results}
        width, arithmetic = peak.vector_width, peak.table(case, medians)
    except CompilerError as missing:
        skipped.append(SkippedTask("arithmetic", str(missing)))
    return Benchmark(
        work=results,
        machine=machine,
        versions=measurement.list_versions(),
        skipped=skipped,
        vector_width=width,
        arithmetic=arithmetic,
        device=case.device.machine.name,
        samples=case.turns.samples,
        seconds=time.perf_counter() - begun,
    )
