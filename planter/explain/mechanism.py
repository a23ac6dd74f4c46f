"""What is said of a mechanism of one's own: its values with bounds, its quantities, its functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planter import rooms
from planter.engine.description import Description, describe
from planter.engine.machine import Quantity, find_machine_room
from planter.errors import InputError
from planter.explain.results import Explained, ExplainedFunction, ExplainedMechanism, Meaning
from planter.files import paths, units
from planter.view.sheet import Sheet


def takes(source: str) -> bool:
    """Return whether a room has the machine of a source."""
    return find_machine_room(source) is not None


def explain_mechanism(source: str, changes: Mapping[str, float]) -> ExplainedMechanism:
    """Return what is said of the mechanism of a file. Raises InputError as its room does."""
    description = describe(source, changes)
    return ExplainedMechanism(
        machine=description.name,
        title=description.title,
        source=description.source,
        assumptions=list(description.assumptions),
        values=list(_values(description)),
        quantities=[_quantity(description, quantity) for quantity in description.quantities],
        functions=[
            ExplainedFunction(one.name, list(one.inputs), one.outputs, one.operations) for one in description.functions
        ],
        files=[],
    )


def draw_sheet(source: str, changes: Mapping[str, float]) -> Sheet | None:
    """Return the drawing with the symbols that can be seen on it; None where a room has none of the source."""
    for module in rooms.brought("sheets"):
        if module.takes(source):
            sheet: Sheet | None = module.draw(source, changes)
            return sheet
    return None


def find_meanings(mechanism: ExplainedMechanism, key: str) -> Explained:
    """Return every meaning of a symbol, key or function in a mechanism; of a file's key its last part is enough.

    Raises InputError, with names that are close, for a name without one.
    """
    every = [*mechanism.values, *mechanism.quantities, *(_function(mechanism, one) for one in mechanism.functions)]
    meanings = [one for one in every if key in (one.name, one.key, paths.last_part(one.key or ""))]
    if not meanings:
        known = sorted({name for one in every for name in (one.name, one.key) if name})
        near = paths.close(key, known)
        hint = f"did you mean {' or '.join(near)}?" if near else "without KEY all are listed"
        raise InputError(f"KEY = {key} is not allowed: {mechanism.machine} has no such value or quantity, {hint}")
    return Explained(key, meanings)


def _values(description: Description) -> Iterator[Meaning]:
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
            else f"from {bounds[0]:g} to {bounds[1]:g} {units.unit(value.path)}".rstrip(),
            value=float(f"{number / value.factor:.15g}"),
            origin=description.origins.get(value.path),
        )


def _quantity(description: Description, quantity: Quantity) -> Meaning:
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


def _function(mechanism: ExplainedMechanism, one: ExplainedFunction) -> Meaning:
    count = "" if one.operations is None else f", {one.operations} operations"
    meaning = f"function of {', '.join(one.inputs)}: {one.outputs} results{count}"
    return Meaning(one.name, "function", mechanism.machine, "", meaning, mechanism.source)
