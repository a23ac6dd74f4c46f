"""The command itself: name, version, help, and the commands of all packages."""

from __future__ import annotations

from typing import Annotated

import typer

from planter import plugins
from planter.terminal.options import join_applications
from planter.version import __version__


def _version(requested: bool) -> None:
    if requested:
        print(f"planter {__version__}")
        raise typer.Exit


def common(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    """Simulate, check and optimise the mechanisms of planting machines: forces, gears, cams, motion."""
    if context.invoked_subcommand is None:
        print(context.get_help())


def build_application() -> typer.Typer:
    """All commands under one name."""
    app = typer.Typer(
        name="planter",
        help=common.__doc__,
        invoke_without_command=True,
        add_completion=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(common)
    commands = join_applications(*(module.app for module in plugins.load_modules("commands")))
    app.registered_commands += sorted(commands.registered_commands, key=_name)
    app.registered_groups += commands.registered_groups
    return app


def _name(command: typer.models.CommandInfo) -> str:
    return command.name or (command.callback.__name__ if command.callback else "")
