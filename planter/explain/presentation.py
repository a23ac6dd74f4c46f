"""The presentation of `planter explain`: meanings, labelled drawings of machines, and statements of
mechanisms.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import replace

from planter.explain.machine import LabelledMachine
from planter.explain.results import DrawnSymbol, Explained, ExplainedMechanism, KnownNames, Meaning
from planter.files import csv_rows, units
from planter.report.html import Block, Items, KeyFigure, Section, Table, Text
from planter.report.labels import count_things
from planter.report.presentation import WIDTH, PlacedFigure, ResultPresentation
from planter.view.sheet import Sheet, draw_figure

MACHINE_FIELDS = ("name", "unit", "meaning", "key", "column", "sheet", "left_out")
MECHANISM_FIELDS = (
    "name",
    "kind",
    "unit",
    "meaning",
    "source",
    "key",
    "value",
    "allowed",
    "origin",
)


def present_machine(machine: LabelledMachine, is_written: bool) -> ResultPresentation:
    """Return the presentation of a machine: its drawings, each with its symbols; those on no
    drawing follow.
    """
    sheets = machine.labelled.sheets
    explained = machine.explained(_list_files(sheets) if is_written else [])
    symbols = explained.symbols
    undrawn = [
        (symbol.name, symbol.unit, symbol.meaning, symbol.left_out)
        for symbol in symbols
        if not symbol.sheet
    ]
    return _present(
        ResultPresentation(
            title=f"{explained.machine}: symbols, keys and columns",
            conclusion=f"{count_things(len(symbols), 'symbol')}; "
            f"{count_things(len(sheets), 'drawing')}; "
            f"{len(undrawn)} on no drawing.",
            record=explained,
            sections=[
                *(
                    Section(
                        sheet.title,
                        [
                            PlacedFigure(sheet.name),
                            _tabulate_symbols(
                                [symbol for symbol in symbols if symbol.name in sheet.names]
                            ),
                        ],
                    )
                    for sheet in sheets
                ),
                Section("On no drawing", [Table(("symbol", "unit", "meaning", "reason"), undrawn)]),
            ],
        ),
        sheets,
        MACHINE_FIELDS,
        symbols,
    )


def present_mechanism(
    mechanism: ExplainedMechanism, sheet: Sheet | None, is_written: bool
) -> ResultPresentation:
    """Return the presentation of a mechanism: its statement, values, quantities and functions, and
    its drawing.
    """
    sheets = [] if sheet is None else [sheet]
    # A value is in the unit of its key, which need not be the SI unit of its symbol.
    values = [replace(item, unit=units.display_unit(item.key or "")) for item in mechanism.values]
    quantities = mechanism.quantities
    functions = [
        (item.name, ", ".join(item.inputs), item.outputs, item.operations)
        for item in mechanism.functions
    ]
    statement: list[Block] = [
        Text(f"{mechanism.title}, from {mechanism.source}. Assumptions:"),
        Items(mechanism.assumptions),
    ]
    return _present(
        ResultPresentation(
            title=f"{mechanism.machine}: values, quantities and functions",
            conclusion=f"{count_things(len(values), 'value')}, "
            f"{count_things(len(quantities), 'quantity', 'quantities')} "
            f"and {count_things(len(functions), 'function')}.",
            key_figures=[
                KeyFigure(f"{len(values)}", "", "values"),
                KeyFigure(f"{len(quantities)}", "", "quantities"),
                KeyFigure(f"{len(functions)}", "", "functions"),
            ],
            record=replace(mechanism, files=_list_files(sheets) if is_written else []),
            sections=[
                Section("Statement", [*(PlacedFigure(sheet.name) for sheet in sheets), *statement]),
                Section(
                    "Values",
                    [
                        Table(
                            ("symbol", "unit", "meaning", "key", "value", "bounds", "origin"),
                            [
                                (
                                    item.name,
                                    item.unit,
                                    item.meaning,
                                    item.key,
                                    item.value,
                                    item.allowed,
                                    item.origin,
                                )
                                for item in values
                            ],
                            page_columns=("unit", "origin"),
                        )
                    ],
                ),
                Section(
                    "Quantities",
                    [
                        Table(
                            ("symbol", "unit", "meaning", "key", "kind", "source"),
                            [
                                (
                                    item.name,
                                    item.unit,
                                    item.meaning,
                                    item.key,
                                    item.kind,
                                    item.source,
                                )
                                for item in quantities
                            ],
                            page_columns=("key", "kind", "source"),
                        )
                    ],
                ),
                Section(
                    "Functions", [Table(("function", "inputs", "results", "operations"), functions)]
                ),
            ],
        ),
        sheets,
        MECHANISM_FIELDS,
        [*values, *quantities],
    )


def _list_files(sheets: Iterable[Sheet]) -> list[str]:
    drawings = (f"figures/{sheet.name}.{kind}" for sheet in sheets for kind in ("svg", "png"))
    return ["report.html", "symbols.csv", "summary.json", *drawings]


def _present(
    presentation: ResultPresentation,
    sheets: Sequence[Sheet],
    fields: Sequence[str],
    items: Iterable[object],
) -> ResultPresentation:
    """Return a presentation with drawings, and with `fields` of `items` as symbols.csv."""
    rows = [
        ["" if (cell := getattr(item, name)) is None else cell for name in fields] for item in items
    ]
    return replace(
        presentation,
        figures=lambda: {sheet.name: draw_figure(sheet) for sheet in sheets},
        captions={sheet.name: sheet.title for sheet in sheets},
        texts=lambda: {"symbols.csv": csv_rows.format_csv((), fields, rows)},
    )


def _tabulate_symbols(symbols: Iterable[DrawnSymbol]) -> Table:
    rows = [
        (symbol.name, symbol.unit, symbol.meaning, symbol.key or symbol.column)
        for symbol in symbols
    ]
    return Table(("symbol", "unit", "meaning", "key or column"), rows)


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
