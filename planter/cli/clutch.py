"""Commands of the clutch, below `planter clutch`."""

from __future__ import annotations

import typer

from planter.cli.app import app

HELP = "The Reuleaux-pentagon clutch: shape, engagement, field test."
clutch = typer.Typer(help=HELP, invoke_without_command=True, rich_markup_mode=None)
app.add_typer(clutch, name="clutch")


@clutch.callback()
def common(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())
