"""Pages on what all commands share: files, units, JSON, exit codes, environment."""

from __future__ import annotations

from importlib import resources
from typing import Annotated

import typer

from planter.cli.results import Topic, Topics
from planter.errors import InputError
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, listing

app = typer.Typer()
_FOLDER = resources.files(__package__).joinpath("topics")


def topics() -> list[str]:
    """Names of the pages, sorted."""
    return sorted(page.name.removesuffix(".md") for page in _FOLDER.iterdir() if page.name.endswith(".md"))


def text(topic: str) -> str:
    """The page of a topic. Raises InputError for a name that has none."""
    from planter.files import paths

    known = topics()
    if topic not in known:
        near = paths.close(topic, known)
        hint = f"did you mean {near[0]}?" if near else f"it must be one of {', '.join(known)}"
        raise InputError(f"TOPIC = {topic} is not allowed: {hint}")
    return _FOLDER.joinpath(f"{topic}.md").read_text(encoding="utf-8")


@app.command(name="help", cls=listing(topic=topics))
def show(
    topic: Annotated[str | None, typer.Argument(help="what to read about", show_default=False)] = None,
    as_json: JsonOption = False,
) -> None:
    """List the topics that concern all commands, or print one."""
    console = Console(as_json)
    with console.outcome():
        if topic is None:
            known = topics()
            console.result(Topics(known), lambda: print("\n".join(known)))
        else:
            page = text(topic)
            console.result(Topic(topic, page), lambda: print(page, end=""))
