"""The JSON schemas of the commands' results."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.cli.results import Listed
from planter.errors import InputError
from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def schema(
    command: Annotated[
        list[str] | None, typer.Argument(help="a command, as `clutch geometry`", show_default=False)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the commands with a JSON schema, or print one schema."""
    console = Console(as_json)
    with console.outcome():
        from planter.files import paths
        from planter.records import schema as schemas

        known, name = schemas.results(), " ".join(command or ())
        if not name:
            listed = sorted(known)
            console.result(Listed(listed), lambda: print("\n".join(listed)))
            return
        if name not in known:
            close = paths.close(name, known)
            hint = f"did you mean {close[0]}?" if close else f"it must be one of {', '.join(sorted(known))}"
            raise InputError(f"COMMAND = {name} is not allowed: {hint}")
        console.result(dict(schemas.schema(name, known[name])), lambda: print(schemas.text(name, known[name]), end=""))
