"""The command itself: name, version, help. The modules beside this one add their commands to it."""

from __future__ import annotations

from typing import Annotated

import typer

from planter import __version__

app = typer.Typer(
    name="planter",
    help="Planting-machine mechanisms, from the printed equation to the optimum.",
    invoke_without_command=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"planter {__version__}")
        raise typer.Exit


@app.callback()
def common(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    """Planting-machine mechanisms, from the printed equation to the optimum."""
    if context.invoked_subcommand is None:
        print(context.get_help())
