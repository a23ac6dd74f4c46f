"""Description of one machine: its values with bounds, its quantities, its functions, and the
symbols of its drawings.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from planter import paths, plugins
from planter.cli import dictionary
from planter.cli.results import (
    DrawnSheet,
    Explained,
    ExplainedFunction,
    ExplainedMachine,
    KnownNames,
    Meaning,
)
from planter.engine.machine import Description, describe_source
from planter.files import csv_rows, units
from planter.files.examples import find_kind, load_part
from planter.report.html import Block, Items, KeyFigure, Section, Table, Text
from planter.report.labels import count_things
from planter.report.presentation import WIDTH, PlacedFigure, ResultPresentation
from planter.report.sheet import Sheet, draw_figure


def explain_machine(
    source: str, changes: Mapping[str, float], sheets: Sequence[Sheet] = ()
) -> ExplainedMachine:
    """Return the description of a machine with its drawings. Raises InputError as its package does."""
    description = describe_source(source, changes)
    kind = find_kind(source)
    package = "" if kind is None else plugins.name_package(kind)
    functions = [
        ExplainedFunction(entry.name, list(entry.inputs), entry.outputs, entry.operations)
        for entry in description.functions
    ]
    values, quantities = list(_list_values(description)), list(_list_quantities(description))
    symbols: dict[str, Meaning] = {}
    for meaning in (*values, *quantities, *dictionary.list_meanings(package)):
        key = paths.last_part(meaning.key or "").partition("[")[0]
        symbols.setdefault(meaning.name, meaning)
        symbols.setdefault(key, meaning)
    drawings = []
    for sheet in sheets:
        # Points of a user's mechanism have names without a meaning.
        named = [symbols[name] for name in sorted(sheet.names) if name in symbols]
        drawings.append(DrawnSheet(sheet.name, sheet.title, named))
    return ExplainedMachine(
        machine=description.name,
        kind=package,
        title=description.title,
        source=description.source,
        assumptions=list(description.assumptions),
        values=values,
        quantities=quantities,
        functions=functions,
        sheets=drawings,
        files=[],
    )


def draw_sheets(source: str, changes: Mapping[str, float]) -> list[Sheet]:
    """Return the drawings of a machine with its symbols, nothing if its kind has none."""
    module = load_part(source, "labelled")
    sheets: list[Sheet] = [] if module is None else module.draw(source, changes)
    return sheets


def find_meanings(machine: ExplainedMachine, key: str) -> Explained:
    """Return every meaning of a symbol, key or function in a machine, and of keys of its file.

    Raises InputError as `dictionary.select_meanings`.
    """
    meanings = [*machine.values, *machine.quantities]
    for entry in machine.functions:
        count = "" if entry.operations is None else f", {entry.operations} operations"
        text = f"function of {', '.join(entry.inputs)}: {entry.outputs} results{count}"
        meanings.append(Meaning(entry.name, "function", machine.machine, "", text, machine.source))
    names = {meaning.name for meaning in meanings}
    # Keys of results have names of sections, as `objective`.
    meanings += [
        meaning
        for meaning in dictionary.list_meanings(machine.kind)
        if meaning.name not in names and meaning.kind != "result key"
    ]
    reason = f"is not a symbol or key of {machine.machine}"
    return dictionary.select_meanings(meanings, key, "KEY", reason, "without KEY all are listed")


def _list_values(description: Description) -> Iterator[Meaning]:
    for value, number in zip(description.values, description.data, strict=True):
        bounds = description.bounds.get(value.path)
        unit = units.display_unit(value.path)
        yield Meaning(
            name=value.name,
            kind="value",
            machine=description.name,
            unit=value.unit,
            meaning=value.meaning,
            source=value.source,
            key=value.path,
            allowed=bounds and f"from {bounds[0]:g} to {bounds[1]:g} {unit}".rstrip(),
            value=float(f"{number / value.factor:.15g}"),
            origin=description.origins.get(value.path),
        )


def _list_quantities(description: Description) -> Iterator[Meaning]:
    """Yield the quantities, then the sizes of vectors."""
    quantities = {quantity.name: quantity for quantity in description.quantities}
    for quantity in description.quantities:
        frame = f", along the axes of {quantity.axes}" if quantity.axes else ""
        push = "; it can only push" if quantity.is_push else ""
        is_result = quantity.role == "result"
        yield Meaning(
            name=quantity.name,
            kind="quantity" if is_result else "check",
            machine=description.name,
            unit=quantity.unit,
            meaning=f"{quantity.meaning}{frame}{push}",
            source=quantity.source,
            key=quantity.key if is_result else None,
        )
    for vector in description.vectors:
        first = quantities[vector.components[0]]
        yield Meaning(
            name=vector.name,
            kind="quantity",
            machine=description.name,
            unit=first.unit,
            meaning=f"size of {', '.join(vector.components)}: {vector.meaning}",
            source=first.source,
            key=units.display_key(vector.name, first.unit),
            components=list(vector.components),
        )


FIELDS = ("name", "kind", "unit", "meaning", "source", "key", "value", "allowed", "origin")


def present_machine(
    machine: ExplainedMachine, sheets: Sequence[Sheet], is_written: bool
) -> ResultPresentation:
    """Return the presentation of a machine: drawings, statement, values, quantities, functions."""
    # A value is in the unit of its key, which need not be the SI unit of its symbol.
    values = [replace(item, unit=units.display_unit(item.key or "")) for item in machine.values]
    functions = [
        (item.name, ", ".join(item.inputs), item.outputs, item.operations)
        for item in machine.functions
    ]
    statement: list[Block] = [
        Text(f"{machine.title}, from {machine.source}. Assumptions:"),
        Items(machine.assumptions),
    ]
    rows = [_list_cells(item, FIELDS) for item in (*values, *machine.quantities)]
    head = ("function", "inputs", "results", "operations")
    drawings = [f"figures/{sheet.name}.{kind}" for sheet in sheets for kind in ("svg", "png")]
    files = ["report.html", "symbols.csv", "summary.json", *drawings]
    counts = {
        "value": len(values),
        "quantity": len(machine.quantities),
        "function": len(functions),
    }
    return ResultPresentation(
        title=f"{machine.machine}: values, quantities and functions",
        conclusion=f"{count_things(counts['value'], 'value')}, "
        f"{count_things(counts['quantity'], 'quantity', 'quantities')} "
        f"and {count_things(counts['function'], 'function')}.",
        key_figures=[KeyFigure(str(count), "", name) for name, count in counts.items()],
        record=replace(machine, files=files if is_written else []),
        sections=[
            *(_present_sheet(sheet.title, sheet.name, sheet.symbols) for sheet in machine.sheets),
            Section("Statement", statement),
            Section("Values", [_tabulate(values, VALUE_HEADS, ("unit", "origin"))]),
            Section(
                "Quantities", [_tabulate(machine.quantities, QUANTITY_HEADS, ("kind", "source"))]
            ),
            Section("Functions", [Table(head, functions)]),
        ],
        figures=lambda: {sheet.name: draw_figure(sheet) for sheet in sheets},
        captions={sheet.name: sheet.title for sheet in sheets},
        texts=lambda: {"symbols.csv": csv_rows.format_csv((), FIELDS, rows)},
    )


SYMBOL_HEADS = {"symbol": "name", "unit": "unit", "meaning": "meaning", "key": "key"}
QUANTITY_HEADS = {**SYMBOL_HEADS, "kind": "kind", "source": "source"}
VALUE_HEADS = {**SYMBOL_HEADS, "value": "value", "bounds": "allowed", "origin": "origin"}
"""Heads of tables, with the fields of a meaning below them."""


def _present_sheet(title: str, figure: str, symbols: Iterable[Meaning]) -> Section:
    return Section(title, [PlacedFigure(figure), _tabulate(symbols, SYMBOL_HEADS)])


def _tabulate(
    items: Iterable[Meaning], heads: Mapping[str, str], page_columns: Sequence[str] = ()
) -> Table:
    rows = [[getattr(item, field) for field in heads.values()] for item in items]
    return Table(list(heads), rows, page_columns=page_columns)


def _list_cells(item: Meaning, fields: Iterable[str]) -> list[object]:
    cells = [getattr(item, field) for field in fields]
    return ["" if cell is None else cell for cell in cells]


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
    return [
        *lines,
        *(
            line
            for fact in facts
            for line in textwrap.wrap(fact, WIDTH, initial_indent="  ", subsequent_indent="    ")
        ),
    ]


def format_value(meaning: Meaning) -> str:
    """Return a value with its unit in the file, and its origin."""
    number = f"{meaning.value:g} {units.display_unit(meaning.key or '')}".rstrip()
    return f"{number} ({meaning.origin})" if meaning.origin else number


def show_names(known_names: KnownNames) -> None:
    """Print all names by machine."""
    for machine, names in known_names.names.items():
        print(f"{machine}:")
        print(
            textwrap.fill(
                ", ".join(names),
                WIDTH,
                initial_indent="  ",
                subsequent_indent="  ",
                break_long_words=False,
                break_on_hyphens=False,
            )
        )
