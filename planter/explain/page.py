"""Files and terminal tables of explained names, machines and mechanisms."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from pathlib import Path

from planter.explain.machine import LabelledMachine
from planter.explain.results import DrawnSymbol, Explained, ExplainedMachine, ExplainedMechanism, KnownNames, Meaning
from planter.files import csv_rows, units
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


WIDTH = 80


def show_meanings(explanation: Explained) -> None:
    """Print every meaning."""
    for meaning in explanation.meanings:
        print("\n".join(format_meaning(meaning)) + "\n")


def format_meaning(meaning: Meaning) -> list[str]:
    """Return a meaning as lines."""
    unit = f" [{meaning.unit}]" if meaning.unit and meaning.unit != "1" else ""
    lines = [f"{meaning.name}{unit}, {meaning.kind}, {meaning.machine}"]
    facts = [meaning.meaning, f"source: {meaning.source}"]
    if meaning.key and meaning.key != meaning.name:
        facts.append(f"shown as {meaning.key}")
    if meaning.value is not None:
        facts.append(f"value: {format_value(meaning)}")
    if meaning.allowed:
        facts.append(f"allowed: {meaning.allowed}")
    facts += [f"defined by {e.paper} ({e.equation}): {e.verdict}" for e in meaning.equations or ()]
    if meaning.figures:
        facts.append(f"drawn in {', '.join(meaning.figures)}")
    return [*lines, *(line for fact in facts for line in textwrap.wrap(
        fact, WIDTH, initial_indent="  ", subsequent_indent="    "))]  # fmt: skip


def format_value(meaning: Meaning) -> str:
    """Return a value with its unit in the file, and its origin."""
    number = f"{meaning.value:g} {units.unit(meaning.key or '')}".rstrip()
    return f"{number} ({meaning.origin})" if meaning.origin else number


def show_mechanism(mechanism: ExplainedMechanism) -> None:
    """Print values, quantities and functions of a mechanism."""
    print(textwrap.fill(f"{mechanism.machine}: {mechanism.title}, from {mechanism.source}", WIDTH))
    for assumption in mechanism.assumptions:
        print(textwrap.fill(f"assumes {assumption}", WIDTH, initial_indent="  ", subsequent_indent="    "))
    for title, meanings in (("Values", mechanism.values), ("Quantities", mechanism.quantities)):
        print(f"\n{title}")
        for meaning in meanings:
            unit = f" [{meaning.unit}]" if meaning.unit != "1" else ""
            facts = [f"{meaning.name}{unit}: {meaning.meaning}"]
            if meaning.value is not None:
                facts.append(
                    f"{meaning.key} = {format_value(meaning)}" + (f", {meaning.allowed}" if meaning.allowed else "")
                )
            for number, fact in enumerate(facts):
                indent = "  " if number == 0 else "    "
                print(textwrap.fill(fact, WIDTH, initial_indent=indent, subsequent_indent=f"{indent}  "))
    print("\nFunctions")
    for function in mechanism.functions:
        count = "" if function.operations is None else f", {function.operations} operations"
        print(f"  {function.name}({', '.join(function.inputs)}): {function.outputs} results{count}")


def show_machine(machine: ExplainedMachine) -> None:
    """Print symbols sheet by sheet, then those without a drawing."""
    by_name = {symbol.name: symbol for symbol in machine.symbols}
    for sheet in machine.sheets:
        print(f"{sheet.name}: {sheet.title}")
        _show_symbols([by_name[name] for name in sheet.symbols])
    print("on no drawing")
    _show_symbols([symbol for symbol in machine.symbols if symbol.sheet is None])


def _show_symbols(symbols: list[DrawnSymbol]) -> None:
    for symbol in symbols:
        places = ", ".join(place for place in (symbol.key, symbol.column) if place)
        facts = [symbol.meaning, f"shown as {places}" if places else "", symbol.left_out or ""]
        print(f"  {symbol.name} [{symbol.unit}]")
        for fact in filter(None, facts):
            print(textwrap.fill(fact, WIDTH, initial_indent="    ", subsequent_indent="      "))
    print()


def show_names(known_names: KnownNames) -> None:
    """Print all names by machine."""
    for show_machine, machine_names in known_names.names.items():
        print(f"{show_machine}:")
        print(textwrap.fill(", ".join(machine_names), WIDTH, initial_indent="  ", subsequent_indent="  ",
                            break_long_words=False, break_on_hyphens=False))  # fmt: skip
