"""The command itself: name, version, help, and the commands of all packages."""

from __future__ import annotations

import copy
from itertools import chain
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from planter import menu, plugins
from planter.report.options import join_applications, record_options
from planter.version import __version__

SETTINGS = {"help_option_names": ["-h", "--help"]}
MORE = "More"
"""Title of the commands that no section has."""


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


def show_group_help(context: typer.Context) -> None:
    """Print the help of a group if no command follows."""
    if context.invoked_subcommand is None:
        print(context.get_help())


class Menu(TyperGroup):
    """The commands in sections; earlier names of commands lead to the present ones."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of a name, None if there is none; short names are those in a group."""
        if cmd_name not in menu.SHORT:
            return super().get_command(ctx, cmd_name)
        group, name = menu.current_words([cmd_name])
        return self.commands[group].get_command(ctx, name)  # type: ignore[attr-defined]

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name, the command and the remaining words of a call."""
        return super().resolve_command(ctx, menu.current_words(args))

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, a section for each purpose; the last names the others."""
        width = max(map(len, chain(*menu.SECTIONS.values())))
        limit = formatter.width - 6 - width
        for title, names in self.list_sections().items():
            texts = {name: self.commands[name].get_short_help_str(limit) for name in names}
            if title == MORE:
                texts = {"help commands": f"Describe all, also {', '.join(names)}."}
            rows = [(f"{name:{width}}", text) for name, text in texts.items()]
            with formatter.section(title):
                formatter.write_dl(rows)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names in the order of the sections, then the short ones."""
        return [*chain(*self.list_sections().values()), *menu.SHORT]

    def list_sections(self) -> dict[str, list[str]]:
        """Return names by section; the last one has those that no section of the menu names."""
        sections: dict[str, list[str]] = {}
        unlisted = set(self.commands)
        for title, names in {**menu.SECTIONS, MORE: menu.MORE}.items():
            sections[title] = [name for name in names if name in self.commands]
            unlisted -= {*names}
        sections[MORE] += sorted(unlisted)
        return sections


def build_application() -> typer.Typer:
    """All commands under one name."""
    app = typer.Typer(
        name="planter",
        cls=Menu,
        help=show_help.__doc__,
        invoke_without_command=True,
        add_completion=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings=SETTINGS,
    )
    app.callback()(show_help)
    parts = join_applications(*(module.app for module in plugins.load_modules("commands")))
    groups = {name: _build_group(entry.help) for name, entry in menu.GROUPS.items()}
    places = {name: groups[group] for group, e in menu.GROUPS.items() for name in e.commands}
    for command in sorted(map(_record, parts.registered_commands), key=_name):
        places.get(_name(command), app).registered_commands.append(command)
    for group in parts.registered_groups:
        inner = copy.copy(group.typer_instance)
        assert inner is not None
        inner.registered_commands = list(map(_record, inner.registered_commands))
        group = copy.copy(group)
        group.typer_instance = inner
        places.get(str(group.name), app).registered_groups.append(group)
    for name, built in groups.items():
        app.add_typer(built, name=name)
    return app


def _build_group(text: str) -> typer.Typer:
    """Return a group without commands."""
    group = typer.Typer(help=text, invoke_without_command=True, rich_markup_mode=None)
    group.callback()(show_group_help)
    return group


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
