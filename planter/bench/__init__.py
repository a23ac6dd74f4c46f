"""Benchmarks: the same work by each way to evaluate a turn, in one run, interleaved, after all have agreed."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from planter.bench.settings import Settings, settings
from planter.progress import Listener, Phase

__all__ = ["Settings", "run", "settings", "write"]


def run(wanted: Settings, progress: Listener | None = None) -> dict[str, Any]:
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
    skipped = [{"work": name, "reason": reason} for name in WORKS if name not in wanted.works]
    phase = Phase("bench", "work", len(wanted.works), progress)
    for name in wanted.works:
        try:
            found.append(works.run(name, case, wanted))
        except Absent as missing:
            skipped.append({"work": name, "reason": str(missing)})
        phase.next(name)
    try:
        peak = rate.Peak()
        medians = {work["name"]: {way["way"]: way["median_us"] for way in work["ways"]} for work in found}
        arithmetic: dict[str, Any] = {"vector_width": peak.vector_width, "arithmetic": peak.table(case, medians)}
    except NoCompiler as missing:
        arithmetic = {"vector_width": None, "arithmetic": None}
        skipped.append({"work": "arithmetic", "reason": str(missing)})
    return {"work": found, "machine": machine, "versions": surroundings.versions(), "skipped": skipped, **arithmetic,
            "device": case.device.machine.name, "samples": case.turns.samples,
            "seconds": time.perf_counter() - begun}  # fmt: skip


def write(folder: str | Path, result: dict[str, Any]) -> None:
    """bench.json, and bench.md: the tables of docs/performance.md. Raises InputError for a folder it cannot write."""
    from planter.bench import page
    from planter.report import files
    from planter.report.folder import renewing

    with renewing(folder):
        place = files.output_folder(folder)
        files.write_text(place / "bench.json", json.dumps(result, indent=2, allow_nan=False) + "\n")
        files.write_text(place / "bench.md", page.markdown(result))
