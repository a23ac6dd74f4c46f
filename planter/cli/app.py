"""The command itself: name, version, help, and the commands of all packages."""

from __future__ import annotations

import copy
from typing import Annotated

import typer

from planter import plugins
from planter.report.options import join_applications, record_options
from planter.version import __version__


def _version(requested: bool) -> None:
    if requested:
        print(f"planter {__version__}")
        raise typer.Exit


def show_help(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version")
    ] = False,
) -> None:
    """Simulate, check and optimise the mechanisms of planting machines: forces, gears, cams,
    motion.
    """
    if context.invoked_subcommand is None:
        print(context.get_help())


def build_application() -> typer.Typer:
    """All commands under one name."""
    app = typer.Typer(
        name="planter",
        help=show_help.__doc__,
        invoke_without_command=True,
        add_completion=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(show_help)
    commands = join_applications(*(module.app for module in plugins.load_modules("commands")))
    app.registered_commands += sorted(map(_record, commands.registered_commands), key=_name)
    for group in commands.registered_groups:
        inner = copy.copy(group.typer_instance)
        assert inner is not None
        inner.registered_commands = list(map(_record, inner.registered_commands))
        group = copy.copy(group)
        group.typer_instance = inner
        app.registered_groups.append(group)
    return app


def _record(command: typer.models.CommandInfo) -> typer.models.CommandInfo:
    """Return a command that knows which of its options are given."""
    assert command.callback is not None
    recorded = copy.copy(command)
    recorded.callback = record_options(command.callback)
    recorded.name = _name(command)
    return recorded


def _name(command: typer.models.CommandInfo) -> str:
    """Return the name of a command, which is that of its function unless it has one."""
    return command.name or (command.callback.__name__ if command.callback else "")
