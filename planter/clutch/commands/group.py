"""The commands of the clutch stand below `planter clutch`."""

from __future__ import annotations

from typing import Annotated

import typer

HELP = "Compute the Reuleaux-pentagon clutch and its field test."
clutch = typer.Typer(help=HELP, invoke_without_command=True, rich_markup_mode=None)
app = typer.Typer()
app.add_typer(clutch, name="clutch")

ClutchArgument = Annotated[
    str, typer.Argument(metavar="CLUTCH", help="a clutch file, or the name of a built-in one", show_default=False)
]


@clutch.callback()
def common(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())
