"""The works behind a result."""

from __future__ import annotations

from textwrap import fill
from typing import Annotated

import typer

from planter.cite.results import Citable, Citations, Cited
from planter.terminal.console import Console
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def cite(
    name: Annotated[
        list[str] | None,
        typer.Argument(help="a command, as `optimise` or `clutch engage`, or a work, as wang2017", show_default=False),
    ] = None,
    bibtex: Annotated[bool, typer.Option("--bibtex", help="entries for BibTeX instead of lines")] = False,
    as_json: JsonOption = False,
) -> None:
    """List the works to cite for a command's result. For example: planter cite optimise --bibtex"""
    console = Console(as_json)
    with console.outcome():
        from planter.cite import references

        if not name:
            known = references.references()
            listed = Citable(
                sorted(known.works), {command: known.commands[command] for command in sorted(known.commands)}
            )
            console.result(listed, lambda: _index(listed))
            return
        asked = " ".join(name)
        found = Citations(asked, references.cited(asked))
        console.result(found, lambda: print("\n\n".join(one.bibtex if bibtex else _told(one) for one in found.works)))


def _told(one: Cited) -> str:
    return fill(f"{one.key} ({one.behind}): {one.text}", 80, subsequent_indent="  ", break_on_hyphens=False)


def _index(listed: Citable) -> None:
    print("works: " + ", ".join(listed.works))
    for command, keys in listed.commands.items():
        print(f"{command}: {', '.join(keys)}")
