"""The command that looks after the compiled functions."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def doctor(
    build: Annotated[bool, typer.Option("--build", help="compile the functions of the built-in machine first")] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what is installed, and what would make it faster."""
    console = Console(as_json)
    with console.outcome():
        from planter.doctor import examination, tables

        examined = examination.examine(build)
        console.result(examined, lambda: tables.tables(console, examined))
