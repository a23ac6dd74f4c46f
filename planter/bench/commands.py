"""How long each way to evaluate a turn takes."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.bench.results import WAYS, WORKS, choose_settings
from planter.report.writing import writes_files
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption

app = typer.Typer()


@app.command()
@writes_files("bench.json", "bench.md")
def bench(
    quick: Annotated[
        bool, typer.Option("--quick", help="under 45 s: cycle, cycle+gradient, optimise")
    ] = False,
    work: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help=f"only this task (repeatable): {', '.join(WORKS)}",
            show_default=False,
        ),
    ] = None,
    way: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help=f"only this way (repeatable): {', '.join(WAYS)}",
            show_default=False,
        ),
    ] = None,
    rounds: Annotated[
        int | None, typer.Option(help="repetitions of every task", show_default=False)
    ] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Time all ways to evaluate a cycle, once they agree."""
    console = Console(as_json)
    with console.outcome():
        from planter.bench import tasks
        from planter.bench.presentation import present_benchmark, write_benchmark

        result = tasks.run_benchmark(choose_settings(quick, work, way, rounds), console.progress)
        if out is not None:
            write_benchmark(out, result)
        present_benchmark(result).show(console)
