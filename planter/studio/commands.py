"""`planter studio`: the page on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.errors import InputError
from planter.terminal.console import Console

app = typer.Typer()


@app.command()
def studio(
    machine: Annotated[
        str | None, typer.Argument(help="a machine's file, or the name of a built-in one", show_default=False)
    ] = None,
    folder: Annotated[Path, typer.Option(help="folder whose files can be opened; none beyond it is read")] = Path(),
    port: Annotated[int, typer.Option(min=0, max=65535, help="port on this machine; 0 takes a free one")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open the page in the browser")] = True,
) -> None:
    """A page on this machine: a hand on a slider changes a machine, and everything follows at once."""
    console = Console(as_json=False)
    with console.outcome():
        try:
            from planter.studio import server
        except ImportError as error:
            raise InputError(
                f"planter studio needs {error.name}, which is not installed: pip install 'planter[studio]'"
            ) from None
        server.serve(machine, folder, port, browser)
