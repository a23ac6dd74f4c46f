"""The command `planter diff`."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.report.console import Console
from planter.report.options import (
    HoldOption,
    JsonOption,
    ModelName,
    ModelOption,
    OutOption,
    SetOption,
    SpeedOption,
    parse_changes,
)
from planter.report.writing import writes_files

app = typer.Typer()


@app.command(name="diff")
@writes_files("summary.json", "curves.csv", "report.html")
def compare_machines(
    machines: Annotated[
        list[str],
        typer.Argument(
            metavar="A B [C ...]",
            help="two or more machines of one kind: files, or names of built-in ones",
            show_default=False,
        ),
    ],
    model: ModelOption = ModelName.exact,
    quantity: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="also compare this curve (repeatable)", show_default=False
        ),
    ] = None,
    hold: HoldOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compare designs of one kind of machine side by side.

    Values, results, requirements and curves have their differences from A.

    The objective of A and the limits of all files are evaluated for every machine. `--set` and
    `--speed-rpm` apply to all of them. For example: planter diff wang2017 out/optimum.toml --out
    compared
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli.difference.comparison import ComparisonOptions, compare_machines
        from planter.cli.difference.presentation import present_comparison

        options = ComparisonOptions(
            parse_changes(set_), speed_rpm, model.value, hold or (), quantity or ()
        )
        present_comparison(compare_machines(machines, options)).show(console, out)
