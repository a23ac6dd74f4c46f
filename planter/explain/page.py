"""Files of an explained machine: its drawings with the tables of their symbols."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from planter.explain.machine import LabelledMachine
from planter.explain.results import DrawnSymbol, ExplainedMachine, ExplainedMechanism
from planter.files import csv_rows
from planter.report import bundle, files
from planter.report.html import FigureSvg, Items, Section, Table, Text, page
from planter.view.sheet import Sheet, figure

HEADER = ("symbol", "unit", "meaning", "key in the file", "column")
MECHANISM_FIELDS = ("name", "kind", "unit", "meaning", "source", "key", "value", "allowed", "origin")
FIELDS = ("name", "unit", "meaning", "key", "column", "sheet", "left_out")


def write_machine(machine: LabelledMachine, out: Path) -> ExplainedMachine:
    """Write `report.html`, `symbols.csv`, `summary.json` and every drawing; return the result with their names.

    Raises InputError, naming the path, if the folder cannot be written.
    """
    labelled = machine.labelled
    figures = bundle.drawn({sheet.name: figure(sheet) for sheet in labelled.sheets})
    names = ["report.html", "symbols.csv", "summary.json"]
    explained = machine.explained([*names, *(f"figures/{name}.{kind}" for name in figures for kind in ("svg", "png"))])
    sections = [
        Section(
            sheet.title,
            [
                FigureSvg(figures[sheet.name].svg, sheet.title),
                tabulate_symbols([symbol for symbol in explained.symbols if symbol.name in sheet.names]),
            ],
        )
        for sheet in labelled.sheets
    ]
    sections.append(Section("On no drawing", [_tabulate_undrawn(explained.symbols)]))
    title = f"{labelled.name}: symbols, keys and columns"
    rows = ([getattr(symbol, field) or "" for field in FIELDS] for symbol in explained.symbols)
    texts = (page(title, sections), csv_rows.written((), FIELDS, rows), files.summary_text(explained.table()))
    bundle.write(out, dict(zip(names, texts, strict=True)), figures)
    return explained


def write_mechanism(mechanism: ExplainedMechanism, sheet: Sheet | None, out: Path) -> ExplainedMechanism:
    """Write `report.html`, `symbols.csv`, `summary.json` and the drawing of a mechanism; return it with their names.

    Raises InputError, naming the path, if the folder cannot be written.
    """
    files.output_folder(out)
    names = ["report.html", "symbols.csv", "summary.json"]
    figures = {} if sheet is None else bundle.drawn({sheet.name: figure(sheet)})
    mechanism = replace(
        mechanism, files=[*names, *(f"figures/{name}.{kind}" for name in figures for kind in ("svg", "png"))]
    )
    values = [
        [item.name, item.unit, item.meaning, item.key, item.value, item.allowed, item.origin]
        for item in mechanism.values
    ]
    quantities = [
        [item.name, item.unit, item.meaning, item.key, item.kind, item.source] for item in mechanism.quantities
    ]
    functions = [[item.name, ", ".join(item.inputs), item.outputs, item.operations] for item in mechanism.functions]
    drawing = [Section("Drawing", [FigureSvg(figures[sheet.name].svg, sheet.title)])] if sheet is not None else []
    sections = [
        *drawing,
        Section(
            "Statement",
            [Text(f"{mechanism.title}, from {mechanism.source}. Assumptions:"), Items(mechanism.assumptions)],
        ),
        Section("Values", [Table(("symbol", "unit", "meaning", "key", "value there", "bounds", "origin"), values)]),
        Section("Quantities", [Table(("symbol", "unit", "meaning", "key", "kind", "source"), quantities)]),
        Section("Functions", [Table(("function", "inputs", "results", "operations"), functions)]),
    ]
    items = [*mechanism.values, *mechanism.quantities]
    rows = [[_format_cell(getattr(item, field)) for field in MECHANISM_FIELDS] for item in items]
    texts = (
        page(f"{mechanism.machine}: values, quantities and functions", sections),
        csv_rows.written((), MECHANISM_FIELDS, rows),
        files.summary_text(mechanism.table()),
    )
    bundle.write(out, dict(zip(names, texts, strict=True)), figures)
    return mechanism


def _format_cell(value: object) -> str | float:
    return "" if value is None else value if isinstance(value, float) else str(value)


def tabulate_symbols(symbols: list[DrawnSymbol]) -> Table:
    """Return a table of symbols with their meanings, keys and columns."""
    return Table(HEADER, [[symbol.name, symbol.unit, symbol.meaning, symbol.key, symbol.column] for symbol in symbols])


def _tabulate_undrawn(symbols: list[DrawnSymbol]) -> Table:
    return Table(
        ("symbol", "unit", "meaning", "why"),
        [[symbol.name, symbol.unit, symbol.meaning, symbol.left_out] for symbol in symbols if symbol.sheet is None],
    )
