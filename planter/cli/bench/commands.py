"""How long each way to evaluate a cycle takes."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from planter.cli.bench.results import QUICK_WORKS, WORKS
from planter.report.console import Console
from planter.report.options import JsonOption, OutOption
from planter.report.writing import writes_files

app = typer.Typer()


@app.command()
@writes_files("bench.json", "bench.md")
def bench(
    quick: Annotated[
        bool, typer.Option("--quick", help="under 45 s: cycle, cycle+gradient, optimise")
    ] = False,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Time all ways to evaluate a cycle, once they agree."""
    console = Console(as_json)
    with console.outcome():
        from planter.cli.bench import tasks
        from planter.report.bundle import write_bundle

        result = tasks.run_benchmark(QUICK_WORKS if quick else WORKS, console.progress)
        tables = tasks.tabulate_benchmark(result)
        if out is not None:
            content = json.dumps(result.table(), indent=2, allow_nan=False) + "\n"
            markdown = tasks.format_markdown(tables)
            write_bundle(out, {"bench.json": content, "bench.md": markdown}, {})

        def print_tables() -> None:
            for title, (head, rows) in tables.items():
                console.table(title, head, rows)

        console.result(result, print_tables)
