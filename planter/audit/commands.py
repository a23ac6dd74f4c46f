"""The papers on trial."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer

from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, listing

app = typer.Typer()


def _papers() -> Iterable[str]:
    from planter.audit import numbers

    return numbers.papers()


@app.command(cls=listing(paper=_papers))
def audit(
    paper: Annotated[
        str | None, typer.Argument(help="one of the papers, by its short name", show_default=False)
    ] = None,
    front: Annotated[
        bool, typer.Option("--front", help="also what range and variance the derived model can give at all")
    ] = False,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Verdicts on the printed equations, laws and numbers of the papers."""
    console = Console(as_json)
    with console.outcome():
        from planter.audit import fronts, page, tables, verdicts

        result = verdicts.audit(paper)
        if front:
            result["front"] = fronts.sought(paper, console.progress)
        if out is not None:
            page.write(out, result)
        console.result(result, lambda: tables.show(console, result))
