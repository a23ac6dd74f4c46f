"""Benchmarks: the same work by each way to evaluate a turn, in one run, interleaved, after all have agreed."""

from __future__ import annotations

import json
import time
from pathlib import Path

from planter.bench.results import Arithmetic, Benchmark, LeftOut
from planter.bench.settings import Settings, settings
from planter.progress import Listener, Phase

__all__ = ["Settings", "run", "settings", "write"]


def run(wanted: Settings, progress: Listener | None = None) -> Benchmark:
    """All works that are wanted and can be done here, as the interface gives them.

    Raises planter.bench.clock.Disagreement where a way finds something else than the others.
    """
    from planter.bench import rate, surroundings, works
    from planter.bench.case import Absent, Case
    from planter.bench.settings import WORKS
    from planter.kernels.toolchain import NoCompiler

    begun, machine = time.perf_counter(), surroundings.machine()
    case = Case()
    found, reason = [], "--quick" if wanted.quick else "not asked for (--work)"
    skipped = [LeftOut(name, reason) for name in WORKS if name not in wanted.works]
    phase = Phase("bench", "work", len(wanted.works), progress)
    for name in wanted.works:
        try:
            found.append(works.run(name, case, wanted))
        except Absent as missing:
            skipped.append(LeftOut(name, str(missing)))
        phase.next(name)
    width: int | None = None
    arithmetic: Arithmetic | None = None
    try:
        peak = rate.Peak()
        medians = {work.name: {way.way: way.median_us for way in work.ways} for work in found}
        width, arithmetic = peak.vector_width, peak.table(case, medians)
    except NoCompiler as missing:
        skipped.append(LeftOut("arithmetic", str(missing)))
    return Benchmark(
        work=found, machine=machine, versions=surroundings.versions(), skipped=skipped, vector_width=width,
        arithmetic=arithmetic, device=case.device.machine.name, samples=case.turns.samples,
        seconds=time.perf_counter() - begun,
    )  # fmt: skip


def write(folder: str | Path, result: Benchmark) -> None:
    """bench.json, and bench.md: the tables of docs/performance.md. Raises InputError for a folder it cannot write."""
    from planter.bench import page
    from planter.report import files
    from planter.report.folder import renewing

    with renewing(folder):
        place = files.output_folder(folder)
        files.write_text(place / "bench.json", json.dumps(result.table(), indent=2, allow_nan=False) + "\n")
        files.write_text(place / "bench.md", page.markdown(result))
