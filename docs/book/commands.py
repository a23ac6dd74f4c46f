"""Pages of commands with their help and a call of each, of the schemas of their results, and of the topics of help."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import typer
from typer.testing import CliRunner

from planter.cli.app import build_application
from planter.cli.guide import list_topics
from planter.files import schema

LINES = 20
"""How much of what a call prints is shown."""
HEAD = """\
# Commands

What `--help` says of each, and a call; where output stands below, the call was run for this page. `planter help` has
pages on what commands share, and the [schemas](schemas.md) say what they return with `--json`.
"""


def leaves(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """All commands by their words, those of groups among them."""
    if hasattr(command, "commands"):
        for name, inner in sorted(command.commands.items()):
            yield from leaves(inner, (*words, name))
    else:
        yield " ".join(words), command


def texts() -> Iterator[tuple[str, str]]:
    """Every command with its help."""
    for words, command in leaves(typer.main.get_command(build_application())):
        context = typer.Context(
            command, info_name=f"planter {words}", terminal_width=100, max_content_width=100
        )
        yield words, command.get_help(context)


def examples() -> tuple[dict[str, str], set[str]]:
    """A call of every command, and the commands whose call is run for the page."""
    found = tomllib.loads(Path(__file__).with_name("examples.toml").read_text(encoding="utf-8"))
    return found["calls"], set(found["shown"])


def printed(call: str) -> str:
    """What a call prints, its first lines. Raises RuntimeError where it fails."""
    found = CliRunner(env={"COLUMNS": "96"}).invoke(build_application(), shlex.split(call)[1:])
    if found.exit_code != 0:
        raise RuntimeError(f"{call}: {found.stderr}")
    lines = [line.rstrip() for line in found.stdout.strip("\n").splitlines()]
    return "\n".join([*lines[:LINES], *(["..."] if len(lines) > LINES else [])])


def page() -> str:
    """The page of commands."""
    calls, shown = examples()
    parts = [HEAD]
    for words, text in texts():
        parts.append(f"## `planter {words}`\n\n```text\n{text.strip()}\n```\n")
        output = f"\n{printed(calls[words])}" if words in shown else ""
        parts.append(f"For example:\n\n```text\n$ {calls[words]}{output}\n```\n")
    return "\n".join(parts)


def schemas() -> str:
    """The page of schemas."""
    parts = (
        f"## `planter {name} --json`\n\n```json\n{schema.format_schema(name, kind).strip()}\n```\n"
        for name, kind in sorted(schema.load_result_types().items())
    )
    return (
        "# Schemas of results\n\nJSON Schema 2020-12, as `planter about schema` prints it.\n\n"
        + "\n".join(parts)
    )


def topics() -> str:
    """The page of topics."""
    folder = resources.files("planter.cli").joinpath("topics")
    told = {
        name: folder.joinpath(f"{name}.md").read_text(encoding="utf-8").strip()
        for name in list_topics()
    }
    parts = (f"## {name}\n\n```text\n{text}\n```\n" for name, text in told.items())
    return "# Topics\n\nWhat `planter help TOPIC` prints.\n\n" + "\n".join(parts)
