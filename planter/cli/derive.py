"""A mechanism of one's own: its file is derived by a process of its own, and text comes back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.cli.results import Derived
from planter.files import derivation
from planter.report.folder import NAME
from planter.report.writing import OverwriteOption
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


def _is_derived(path: Path) -> bool:
    return path.is_file() and "__pycache__" not in path.parts and path.name != NAME


@app.command()
def derive(
    source: FileArgument, out: FolderOption = None, target: TargetOption = None, overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Derive the equations of your mechanism. FILE is run as Python: only use files you trust."""
    console = Console(as_json)
    with console.outcome():
        folder = derivation.derived(source, out, target or (), overwrite)
        written = sorted(str(path) for path in folder.rglob("*") if _is_derived(path))
        console.result(Derived(str(folder), written), lambda: print("\n".join(written)))
