"""`python -m tests.benchmarks.methods` compares the methods of `planter optimise`.

It writes `methods.json` beside this file, a row after each search, and the table of
`docs/performance.md` between its marks. Rows that the record has are kept, unless all are measured
`--anew`; `--page` writes the page of the record that there is. Times are CPU times of whole
commands, with the building of their functions in a worker.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.benchmarks.dynamics import find_versions, format_number, render_table
from tests.support import own
from tests.support.cli import answer
from tests.support.structure import ROOT

RECORD, PAGE = Path(__file__).with_suffix(".json"), ROOT / "docs" / "performance.md"
BEGIN, END = "<!-- methods -->", "<!-- end of methods -->"
METHODS = ("ipopt", "ga", "hybrid", "auto")
STARTS = 4
VERSIONS = ("processor", "casadi", "numpy")
REACHED = 1e-6
"""Relative difference of objectives up to which a method reaches the best of all."""
Record = dict[str, Any]
COLUMNS = {
    "problem": "problem",
    "method": "method",
    "objective": "objective",
    "excess": "above the best",
    "evaluations": "evaluations: objective, gradient, Hessian",
    "agreeing": "starts that agree",
    "cpu_s": "CPU s",
}


@dataclass(frozen=True)
class SearchCase:
    """A problem of the table: its name, and the words of the command that searches."""

    name: str
    words: tuple[str, ...]


def list_cases() -> list[SearchCase]:
    """Return the problems of the table: the paper's bounds, wide ones, and a mechanism."""
    arm = str(own.generated("transplanting_arm") / "transplanting_arm.toml")
    goal = ("--least", "max abs M_in", "--hold", "range y_tip >= 105 mm")
    return [
        SearchCase("wang2017, bounds of the paper", ("wang2017",)),
        SearchCase("transplanting arm, torque at a held stroke", (arm, *goal)),
        SearchCase("wang2017-wide, all requirements", ("wang2017-wide",)),
    ]


def measure_method(case: SearchCase, method: str, starts: int = STARTS) -> Record:
    """Return the row of a method: what it reaches, by how many evaluations and CPU seconds."""
    words = ("--method", method, "--starts", str(starts), "--workers", "1")
    began = _read_clock()
    result = answer("optimise", *case.words, *words)
    certificate, counts = result["certificate"], result["evaluations"]
    return {
        "problem": case.name,
        "method": method,
        "objective": result["objective"],
        "evaluations": [counts[kind] for kind in ("objective", "gradient", "hessian")],
        "starts": certificate["starts"],
        "agreeing_starts": certificate["agreeing_starts"],
        "cpu_s": _read_clock() - began,
    }


def _read_clock() -> float:
    """Return the CPU time [s] of this process and of its workers that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def measure_all(rows: list[Record]) -> Iterator[Record]:
    """Yield the record of all problems and methods, again after each row; `rows` that there are stay."""
    measured = {(row["problem"], row["method"]): row for row in rows}
    for case in list_cases():
        for method in METHODS:
            if (case.name, method) not in measured:
                measured[case.name, method] = measure_method(case, method)
                yield {
                    "versions": {name: find_versions()[name] for name in VERSIONS},
                    "rows": list(measured.values()),
                }


def render_page(record: Record) -> str:
    """Return the part of the page that a record fills."""
    best: dict[str, float] = {}
    for row in record["rows"]:
        best[row["problem"]] = min(row["objective"], best.get(row["problem"], row["objective"]))
    rows = []
    for row in record["rows"]:
        excess = row["objective"] / best[row["problem"]] - 1
        starts = f"{row['agreeing_starts']} of {row['starts']}" if row["starts"] else "-"
        cells = {
            "objective": f"{row['objective']:.6f}",
            "excess": "reached" if excess <= REACHED else f"{100 * excess:.2g} %",
            "evaluations": ", ".join(map(str, row["evaluations"])),
            "agreeing": starts,
            "cpu_s": format_number(row["cpu_s"]),
        }
        rows.append({"problem": row["problem"], "method": row["method"], **cells})
    versions, total = record["versions"], sum(row["cpu_s"] for row in record["rows"])
    measured = {(row["problem"], row["method"]) for row in record["rows"]}
    left_out = [
        f"{case.name} ({method})"
        for case in list_cases()
        for method in METHODS
        if (case.name, method) not in measured
    ]
    named = "; ".join(f"{name}: {versions[name]}" for name in VERSIONS)
    lines = [f"{total:.0f} CPU s in all. {named}."]
    if left_out:
        lines.insert(0, f"Not measured yet: {', '.join(left_out)}.")
    return "\n".join([*render_table(COLUMNS, rows), "", *lines])


def fill_page(text: str, record: Record) -> str:
    """Return the page with the part of a record between its marks."""
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n\n{render_page(record)}\n\n{END}{rest.split(END)[1]}"


def main() -> None:
    """Measure what the record lacks, all if it is asked for `--anew`, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--page", action="store_true", help="write the page of the record alone")
    parser.add_argument("--anew", action="store_true", help="measure all rows again")
    options = parser.parse_args()
    rows: list[Record] = []
    if RECORD.is_file() and not options.anew:
        rows = json.loads(RECORD.read_text(encoding="utf-8"))["rows"]
    if not options.page:
        for record in measure_all(rows):
            RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
            write_page()
    write_page()


def write_page() -> None:
    """Write the page of the record."""
    record = json.loads(RECORD.read_text(encoding="utf-8"))
    PAGE.write_text(fill_page(PAGE.read_text(encoding="utf-8"), record), encoding="utf-8")


if __name__ == "__main__":
    main()
