"""Description of a user-defined mechanism: its values with bounds, its quantities, its
functions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planter import plugins
from planter.engine.machine import Description, Quantity, Vector, describe_source
from planter.explain import dictionary
from planter.explain.results import Explained, ExplainedFunction, ExplainedMechanism, Meaning
from planter.files import units
from planter.files.kinds import find_kind, load_part
from planter.view.sheet import Sheet


def explain_mechanism(source: str, changes: Mapping[str, float]) -> ExplainedMechanism:
    """Return the description of the mechanism of a file. Raises InputError as its package does."""
    description = describe_source(source, changes)
    return ExplainedMechanism(
        machine=description.name,
        title=description.title,
        source=description.source,
        assumptions=list(description.assumptions),
        values=list(_list_values(description)),
        quantities=[
            *(_describe_quantity(description, quantity) for quantity in description.quantities),
            *(_describe_vector(description, vector) for vector in description.vectors),
        ],
        functions=[
            ExplainedFunction(
                function.name, list(function.inputs), function.outputs, function.operations
            )
            for function in description.functions
        ],
        files=[],
    )


def draw_sheet(source: str, changes: Mapping[str, float]) -> Sheet | None:
    """Return the drawing with its visible symbols, or None if the source has no drawing."""
    module = load_part(source, "sheets")
    sheet: Sheet | None = None if module is None else module.draw(source, changes)
    return sheet


def find_meanings(mechanism: ExplainedMechanism, source: str, key: str) -> Explained:
    """Return every meaning of a symbol, key or function in the mechanism of a source, and of the
    keys of its file.

    Raises InputError as `dictionary.select_meanings`.
    """
    module = find_kind(source)
    package = plugins.name_package(module) if module else ""
    meanings = [
        *mechanism.values,
        *mechanism.quantities,
        *(_describe_function(mechanism, meaning) for meaning in mechanism.functions),
        *(
            m
            for m in dictionary.collect_meanings()
            if m.machine == package and m.kind == "file key"
        ),
    ]
    reason = f"is not a value, quantity, function or key of {mechanism.machine}"
    return dictionary.select_meanings(meanings, key, "KEY", reason, "without KEY all are listed")


def _list_values(description: Description) -> Iterator[Meaning]:
    for value, number in zip(description.values, description.data, strict=True):
        bounds = description.bounds.get(value.path)
        yield Meaning(
            name=value.name,
            kind="value",
            machine=description.name,
            unit=value.unit,
            meaning=value.meaning,
            source=value.source,
            key=value.path,
            allowed=None
            if bounds is None
            else f"from {bounds[0]:g} to {bounds[1]:g} {units.display_unit(value.path)}".rstrip(),
            value=float(f"{number / value.factor:.15g}"),
            origin=description.origins.get(value.path),
        )


def _describe_quantity(description: Description, quantity: Quantity) -> Meaning:
    frame = f", along the axes of {quantity.axes}" if quantity.axes else ""
    push = "; it can only push" if quantity.is_push else ""
    is_result = quantity.role == "result"
    return Meaning(
        name=quantity.name,
        kind="quantity" if is_result else "check",
        machine=description.name,
        unit=quantity.unit,
        meaning=f"{quantity.meaning}{frame}{push}",
        source=quantity.source,
        key=quantity.key if is_result else None,
    )


def _describe_vector(description: Description, vector: Vector) -> Meaning:
    first = next(
        quantity for quantity in description.quantities if quantity.name == vector.components[0]
    )
    return Meaning(
        name=vector.name,
        kind="quantity",
        machine=description.name,
        unit=first.unit,
        meaning=f"size of {', '.join(vector.components)}: {vector.meaning}",
        source=first.source,
        key=units.display_key(vector.name, first.unit),
        components=list(vector.components),
    )


def _describe_function(mechanism: ExplainedMechanism, function: ExplainedFunction) -> Meaning:
    count = "" if function.operations is None else f", {function.operations} operations"
    meaning = f"function of {', '.join(function.inputs)}: {function.outputs} results{count}"
    return Meaning(function.name, "function", mechanism.machine, "", meaning, mechanism.source)
