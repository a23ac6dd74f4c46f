"""The dictionary of symbols, keys and columns."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def explain(
    name: Annotated[
        str | None,
        typer.Argument(help="a symbol, key or column, as F_B1x, mass.sun_kg, range_N, tip_x_mm", show_default=False),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say what a symbol, a file's key, a result's key or a column means: unit, source, verdict, figures."""
    console = Console(as_json)
    with console.outcome():
        from planter.explain import dictionary, tables

        if name is None:
            known = dictionary.names()
            console.result(known, lambda: tables.names(known))
            return
        found = dictionary.explained(name)
        console.result(found, lambda: tables.explained(found))
