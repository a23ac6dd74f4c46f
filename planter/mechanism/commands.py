"""Commands for mechanisms of one's own."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption, changes

app = typer.Typer()


@app.command()
def turn(
    mechanism: Annotated[
        str, typer.Argument(help="a mechanism's file (TOML), or its name: NAME.toml here or in generated/")
    ],
    samples: Annotated[
        int | None, typer.Option(min=4, max=100_000, help="samples of the turn, else those of the file")
    ] = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """A turn of a mechanism of your own, which `planter derive FILE.py` derived: every quantity, works, laws."""
    console = Console(as_json)
    with console.outcome():
        from planter.mechanism import file, model, tables
        from planter.mechanism import turn as turns

        machine = file.load(mechanism, changes(set_))
        found = turns.turn(model.Model(machine), samples)
        if out is not None:
            from planter.mechanism import report

            report.write(out, found, machine, console.progress)
        console.result(found.table(), lambda: tables.show(console, found))
