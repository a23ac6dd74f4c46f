"""Benchmarks: the same work by each way to evaluate a turn, in one run, interleaved, after all have agreed."""

from __future__ import annotations

import json
import time
from pathlib import Path

from planter.bench.results import Arithmetic, Benchmark, LeftOut
from planter.bench.settings import Settings, settings
from planter.progress import Listener, ProgressPhase

__all__ = ["Settings", "run", "settings", "write"]


def run(chosen: Settings, progress: Listener | None = None) -> Benchmark:
    """Return the chosen works that can be done here, as the interface gives them.

    Raises planter.bench.clock.Disagreement if a way disagrees with the others.
    """
    from planter.bench import rate, surroundings, works
    from planter.bench.case import Absent, Case
    from planter.bench.settings import WORKS
    from planter.kernels.toolchain import NoCompiler

    begun, machine = time.perf_counter(), surroundings.machine()
    case = Case()
    results, reason = [], "--quick" if chosen.quick else "not asked for (--work)"
    skipped = [LeftOut(name, reason) for name in WORKS if name not in chosen.works]
    phase = ProgressPhase("bench", "work", len(chosen.works), progress)
    for name in chosen.works:
        try:
            results.append(works.run(name, case, chosen))
        except Absent as missing:
            skipped.append(LeftOut(name, str(missing)))
        phase.advance(name)
    width: int | None = None
    arithmetic: Arithmetic | None = None
    try:
        peak = rate.Peak()
        medians = {work.name: {way.way: way.median_us for way in work.ways} for work in results}
        width, arithmetic = peak.vector_width, peak.table(case, medians)
    except NoCompiler as missing:
        skipped.append(LeftOut("arithmetic", str(missing)))
    return Benchmark(
        work=results, machine=machine, versions=surroundings.versions(), skipped=skipped, vector_width=width,
        arithmetic=arithmetic, device=case.device.machine.name, samples=case.turns.samples,
        seconds=time.perf_counter() - begun,
    )  # fmt: skip


def write(folder: str | Path, result: Benchmark) -> None:
    """Write bench.json, and bench.md, the tables of docs/performance.md.

    Raises InputError if the folder cannot be written.
    """
    from planter.bench import page
    from planter.report import files
    from planter.report.folder import renewing

    with renewing(folder):
        place = files.output_folder(folder)
        files.write_text(place / "bench.json", json.dumps(result.table(), indent=2, allow_nan=False) + "\n")
        files.write_text(place / "bench.md", page.markdown(result))
