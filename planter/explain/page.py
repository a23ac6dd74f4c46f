"""The files of a machine that is explained: its drawings beside the tables of their symbols."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from planter.explain.machine import Drawn
from planter.explain.results import DrawnSymbol, ExplainedMachine, ExplainedMechanism
from planter.files import csv_rows
from planter.report import bundle, files
from planter.report.html import FigureSvg, Items, Section, Table, Text, page
from planter.view.labelling import figure
from planter.view.sheet import Sheet

HEADER = ("symbol", "unit", "meaning", "key in the file", "column")
MECHANISM_FIELDS = ("name", "kind", "unit", "meaning", "source", "key", "value", "allowed", "origin")
FIELDS = ("name", "unit", "meaning", "key", "column", "sheet", "left_out")


def write(drawn: Drawn, out: Path) -> ExplainedMachine:
    """Writes `report.html`, `symbols.csv`, `summary.json` and every drawing; says what was written.

    Raises InputError, naming the path, for a folder that cannot be written.
    """
    labelled = drawn.labelled
    figures = bundle.drawn({sheet.name: figure(sheet) for sheet in labelled.sheets})
    names = ["report.html", "symbols.csv", "summary.json"]
    found = drawn.explained([*names, *(f"figures/{name}.{kind}" for name in figures for kind in ("svg", "png"))])
    sections = [Section(sheet.title, [FigureSvg(figures[sheet.name].svg, sheet.title),
                                      table([one for one in found.symbols if one.name in sheet.names])])
                for sheet in labelled.sheets]  # fmt: skip
    sections.append(Section("On no drawing", [_rest(found.symbols)]))
    title = f"{labelled.name}: symbols, keys and columns"
    rows = ([getattr(one, field) or "" for field in FIELDS] for one in found.symbols)
    texts = (page(title, sections), csv_rows.written((), FIELDS, rows), files.summary_text(found.table()))
    bundle.write(out, dict(zip(names, texts, strict=True)), figures)
    return found


def write_mechanism(found: ExplainedMechanism, sheet: Sheet | None, out: Path) -> ExplainedMechanism:
    """Write `report.html`, `symbols.csv`, `summary.json` and the drawing of a mechanism; return it with their names.

    Raises InputError, naming the path, for a folder that cannot be written.
    """
    files.output_folder(out)
    names = ["report.html", "symbols.csv", "summary.json"]
    figures = {} if sheet is None else bundle.drawn({sheet.name: figure(sheet)})
    found = replace(found, files=[*names, *(f"figures/{name}.{kind}" for name in figures for kind in ("svg", "png"))])
    values = [[one.name, one.unit, one.meaning, one.key, one.value, one.allowed, one.origin] for one in found.values]
    quantities = [[one.name, one.unit, one.meaning, one.key, one.kind, one.source] for one in found.quantities]
    functions = [[one.name, ", ".join(one.inputs), one.outputs, one.operations] for one in found.functions]
    drawing = [Section("Drawing", [FigureSvg(figures[sheet.name].svg, sheet.title)])] if sheet is not None else []
    sections = [
        *drawing,
        Section("Statement", [Text(f"{found.title}, from {found.source}. It assumes:"), Items(found.assumptions)]),
        Section("Values", [Table(("symbol", "unit", "meaning", "key", "value there", "bounds", "origin"), values)]),
        Section("Quantities", [Table(("symbol", "unit", "meaning", "key", "kind", "source"), quantities)]),
        Section("Functions", [Table(("function", "inputs", "results", "operations"), functions)]),
    ]
    every = [*found.values, *found.quantities]
    rows = [[_cell(getattr(one, field)) for field in MECHANISM_FIELDS] for one in every]
    texts = (
        page(f"{found.machine}: values, quantities and functions", sections),
        csv_rows.written((), MECHANISM_FIELDS, rows),
        files.summary_text(found.table()),
    )
    bundle.write(out, dict(zip(names, texts, strict=True)), figures)
    return found


def _cell(value: object) -> str | float:
    return "" if value is None else value if isinstance(value, float) else str(value)


def table(symbols: list[DrawnSymbol]) -> Table:
    """What symbols mean, and under which key and column they are shown."""
    return Table(HEADER, [[one.name, one.unit, one.meaning, one.key, one.column] for one in symbols])


def _rest(symbols: list[DrawnSymbol]) -> Table:
    return Table(("symbol", "unit", "meaning", "why"),
                 [[one.name, one.unit, one.meaning, one.left_out] for one in symbols if one.sheet is None])  # fmt: skip
