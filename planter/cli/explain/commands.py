"""The dictionary of symbols and keys."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.report.console import Console
from planter.report.options import JsonOption, OutOption, SetOption, parse_changes, refuse_unused
from planter.report.writing import writes_files

app = typer.Typer()


@app.command()
@writes_files("summary.json", "symbols.csv", "report.html")
def explain(
    name: Annotated[
        str | None,
        typer.Argument(
            help="a symbol or key, as F_B1x, mass.sun_kg, range_N, tip_x_mm; or a machine",
            show_default=False,
        ),
    ] = None,
    key: Annotated[
        str | None,
        typer.Argument(help="with a machine: a symbol or key of it alone", show_default=False),
    ] = None,
    out: OutOption = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Explain a symbol or a key: meaning, unit, source.

    Of a machine, every value with its bounds, every quantity, and the functions; `--out` writes
    its drawings with the symbols on them: `planter explain wang2017 --out drawn`.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.cli.explain import dictionary, machine, presentation
        from planter.files.kinds import find_kind

        if name is None:
            refuse_unused("without a NAME", "--out", "--set")
            names = dictionary.list_names()
            console.result(names, lambda: presentation.show_names(names))
        elif key is not None:
            refuse_unused("with a KEY", "--out")
            explained = machine.explain_machine(name, parse_changes(set_))
            meanings = machine.find_meanings(explained, key)
            console.result(meanings, lambda: presentation.show_meanings(meanings))
        elif find_kind(name) or out is not None or set_:
            sheets = machine.draw_sheets(name, parse_changes(set_))
            explained = machine.explain_machine(name, parse_changes(set_), sheets)
            presentation.present_machine(explained, sheets, out is not None).show(console, out)
        else:
            explanation = dictionary.explain_name(name)
            console.result(explanation, lambda: presentation.show_meanings(explanation))
