"""Built-in files to start from."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.cli.results import Example, Examples
from planter.files import examples
from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def example(
    name: Annotated[str | None, typer.Argument(help="a built-in machine or data file", show_default=False)] = None,
    as_json: JsonOption = False,
) -> None:
    """List built-in machines and data files, or print one."""
    console = Console(as_json)
    with console.outcome():
        if name is None:
            known = examples.names()
            console.result(Examples(known), lambda: print("\n".join(known)))
        else:
            text = examples.example(name)
            console.result(Example(name, text), lambda: print(text, end=""))
