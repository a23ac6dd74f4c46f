"""Description of one machine: its values with bounds, its quantities, its functions, and the
symbols of its drawings.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from planter import paths, plugins
from planter.cli.explain import dictionary
from planter.cli.explain.results import (
    DrawnSheet,
    Explained,
    ExplainedFunction,
    ExplainedMachine,
    Meaning,
)
from planter.engine.machine import Description, describe_source
from planter.files import units
from planter.files.kinds import find_kind, load_part
from planter.report.sheet import Sheet


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
