"""The dictionary of symbols, keys and columns."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption, changes

app = typer.Typer()


@app.command()
@writes("summary.json", "symbols.csv", "report.html")
def explain(
    name: Annotated[
        str | None,
        typer.Argument(
            help="a symbol, key or column, as F_B1x, mass.sun_kg, range_N, tip_x_mm; or a machine, whose drawings have "
            "all symbols of its geometry; or your mechanism's file",
            show_default=False,
        ),
    ] = None,
    key: Annotated[
        str | None,
        typer.Argument(help="with a machine: a symbol, key, column or quantity of it alone", show_default=False),
    ] = None,
    out: OutOption = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Explain a symbol, a key or a column: meaning, unit, source.

    Of a machine, every symbol of its geometry; `--out` writes its drawings with tables:
    `planter explain wang2017 --out drawn`. Of your mechanism, every value with its bounds, every quantity, and the
    functions: `planter explain own/slider_crank.toml`.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.explain import dictionary, machine, mechanism, page

        if name is not None and key is None and not machine.takes(name) and mechanism.takes(name):
            from planter.explain import page

            explained = mechanism.explain_mechanism(name, changes(set_))
            if out is not None:
                explained = page.write_mechanism(explained, mechanism.draw_sheet(name, changes(set_)), out)
            console.result(explained, lambda: page.show_mechanism(explained))
            return
        if name is not None and key is not None:
            if machine.takes(name):
                meanings = dictionary.explain_in_room(machine.find_room(name), key)
            else:
                meanings = mechanism.find_meanings(mechanism.explain_mechanism(name, changes(set_)), key)
            console.result(meanings, lambda: page.show_meanings(meanings))
            return
        if name is not None and (out is not None or set_ or machine.takes(name)):
            from planter.explain import page

            drawing = machine.draw_machine(name, changes(set_))
            result = drawing.explained([]) if out is None else page.write_machine(drawing, out)
            console.result(result, lambda: page.show_machine(result))
            return
        if name is None:
            names_list = dictionary.list_names()
            console.result(names_list, lambda: page.show_names(names_list))
            return
        explanation = dictionary.explain_name(name)
        console.result(explanation, lambda: page.show_meanings(explanation))
