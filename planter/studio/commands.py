"""`planter studio`: the interactive page in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.errors import InputError
from planter.report.completion import complete_machines
from planter.report.console import Console
from planter.report.options import refuse_unused, text_option, writes_files
from planter.text_files import is_file

app = typer.Typer()
DEFAULT = "wang2017"
"""Machine of a static page if none is named."""


@app.command()
@writes_files()
def studio(
    machine: Annotated[
        str | None,
        typer.Argument(
            metavar="MACHINE",
            help="a machine file, or the name of a built-in machine",
            autocompletion=complete_machines,
        ),
    ] = None,
    folder: Annotated[
        Path, typer.Option(help="folder whose files can be opened; no others are read")
    ] = Path(),
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="port on this computer; 0 takes a free one")
    ] = 0,
    static: Annotated[
        Path | None, text_option("write the page to one HTML file that needs no server", "FILE")
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="open the page in the browser")
    ] = True,
) -> None:
    """Open an interactive page in your browser.

    Move a slider, and drawing, curves and results update at once.

    With --static the page is written to one file that runs on its own in any browser (WebAssembly),
    for planting devices and your own mechanisms; writing it needs planter[compiler]. It has
    sliders, the drawing, curves, results and a local optimisation, but no requirements, teeth or
    certified optima.

    For example: planter studio wang2017 --static wang2017.html
    """
    console = Console(as_json=False)
    with console.outcome():
        if static is not None:
            refuse_unused("with --static, which starts no server", "--folder", "--port")
            from planter.studio.static_page import write_page

            print(write_page(machine or DEFAULT, static))
            return
        try:
            from planter.studio import server
        except ImportError as error:
            raise InputError(
                f"planter studio needs {error.name}, which is not installed: pip install "
                f"'planter[studio]'"
            ) from None
        if machine is not None and is_file(Path(machine)):
            refuse_unused("with a FILE, whose own folder is served", "--folder")
        server.serve_studio(machine, folder, port, browser)
