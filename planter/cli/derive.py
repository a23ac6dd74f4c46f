"""A mechanism of one's own: its file is derived by a process of its own, and text comes back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.cli.results import Derived
from planter.files import derivation
from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


FileArgument = Annotated[
    Path, typer.Argument(metavar="FILE", help="a Python file, or a folder of such files", show_default=False)
]
FolderOption = Annotated[
    Path | None, typer.Option("--out", help="folder to write to [default: generated, beside FILE]", show_default=False)
]
TargetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--target",
        metavar="NAME",
        help="also write this language (repeatable): matlab (function files for MATLAB and Octave), latex (the "
        "derivation as a document with numbered equations), or one that an installed package offers",
        show_default=False,
    ),
]


@app.command()
def derive(
    source: FileArgument, out: FolderOption = None, target: TargetOption = None, as_json: JsonOption = False
) -> None:
    """Derive a mechanism of your own and write its functions. FILE is run as Python: hand in none that you mistrust."""
    console = Console(as_json)
    with console.outcome():
        folder = derivation.derived(source, out, target or ())
        written = sorted(str(path) for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
        console.result(Derived(str(folder), written), lambda: print("\n".join(written)))
