"""Pages of commands with their help, of the schemas of their results, and of the topics of `planter help`."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import resources
from typing import Any

import typer

from planter.cli import help
from planter.cli.app import application
from planter.records import schema


def leaves(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """All commands by their words, those of groups among them."""
    if hasattr(command, "commands"):
        for name, inner in sorted(command.commands.items()):
            yield from leaves(inner, (*words, name))
    else:
        yield " ".join(words), command


def texts() -> Iterator[tuple[str, str]]:
    """Every command with its help."""
    for words, command in leaves(typer.main.get_command(application())):
        context = typer.Context(command, info_name=f"planter {words}", terminal_width=100, max_content_width=100)
        yield words, command.get_help(context)


def page() -> str:
    """The page of commands."""
    parts = [f"## `planter {words}`\n\n```text\n{text.strip()}\n```\n" for words, text in texts()]
    return "# Commands\n\nWhat `--help` says of each; `planter help` has pages on what they share.\n\n" + "\n".join(
        parts
    )


def schemas() -> str:
    """The page of schemas."""
    parts = (
        f"## `planter {name} --json`\n\n```json\n{schema.text(name, kind).strip()}\n```\n"
        for name, kind in sorted(schema.results().items())
    )
    return "# Schemas of results\n\nJSON Schema 2020-12, as `planter schema` prints it.\n\n" + "\n".join(parts)


def topics() -> str:
    """The page of topics."""
    folder = resources.files("planter.cli").joinpath("topics")
    told = {name: folder.joinpath(f"{name}.md").read_text(encoding="utf-8").strip() for name in help.topics()}
    parts = (f"## {name}\n\n```text\n{text}\n```\n" for name, text in told.items())
    return "# Topics\n\nWhat `planter help TOPIC` prints.\n\n" + "\n".join(parts)
