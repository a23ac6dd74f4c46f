"""The dictionary of symbols, keys and columns."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.report.writing import writes_files
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption, parse_changes, refuse_unused

app = typer.Typer()


@app.command()
@writes_files("summary.json", "symbols.csv", "report.html")
def explain(
    name: Annotated[
        str | None,
        typer.Argument(
            help="a symbol, key or column, as F_B1x, mass.sun_kg, range_N, tip_x_mm; or a "
            "machine, whose drawings have "
            "all symbols of its geometry; or your mechanism's file",
            show_default=False,
        ),
    ] = None,
    key: Annotated[
        str | None,
        typer.Argument(
            help="with a machine: a symbol, key, column or quantity of it alone", show_default=False
        ),
    ] = None,
    out: OutOption = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Explain a symbol, a key or a column: meaning, unit, source.

    Of a machine, every symbol of its geometry; `--out` writes its drawings with tables:
    `planter explain wang2017 --out drawn`. Of your mechanism, every value with its bounds, every
    quantity, and the functions: `planter explain own/slider_crank.toml`.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.explain import dictionary, machine, mechanism, presentation
        from planter.files.kinds import find_kind

        package = None if name is None else machine.find_package(name)
        if name is None:
            refuse_unused("without a NAME", "--out", "--set")
            names = dictionary.list_names()
            console.result(names, lambda: presentation.show_names(names))
        elif key is not None:
            refuse_unused("with a KEY", "--out")
            if package is not None:
                refuse_unused("on what a symbol means", "--set")
                meanings = dictionary.explain_in_package(package, key)
            else:
                explained = mechanism.explain_mechanism(name, parse_changes(set_))
                meanings = mechanism.find_meanings(explained, name, key)
            console.result(meanings, lambda: presentation.show_meanings(meanings))
        elif package is None and find_kind(name):
            explained = mechanism.explain_mechanism(name, parse_changes(set_))
            sheet = None if out is None else mechanism.draw_sheet(name, parse_changes(set_))
            presentation.present_mechanism(explained, sheet, out is not None).show(console, out)
        elif package or out is not None or set_:
            drawing = machine.draw_machine(name, parse_changes(set_))
            presentation.present_machine(drawing, out is not None).show(console, out)
        else:
            explanation = dictionary.explain_name(name)
            console.result(explanation, lambda: presentation.show_meanings(explanation))
