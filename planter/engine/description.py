"""What is said of a machine: its values, quantities and functions, each with meaning, unit and source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from planter.engine.machine import Machine, Quantity, Value, find_machine_room, load_machine
from planter.kernels import Array


@dataclass(frozen=True)
class FunctionSignature:
    """A function of a machine: what it takes, how many results it has, and of how many operations it is made."""

    name: str
    inputs: tuple[str, ...]
    outputs: int
    operations: int | None = None


@dataclass(frozen=True)
class Description:
    """What is said of a machine; `data` (v,) are its values in SI, `bounds` in the units of their paths.

    `origins` says by path where a value is from.
    """

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    values: tuple[Value, ...]
    data: Array
    bounds: Mapping[str, tuple[float, float]]
    origins: Mapping[str, str]
    quantities: tuple[Quantity, ...]
    functions: tuple[FunctionSignature, ...]


def describe(source: str, changes: Mapping[str, float]) -> Description:
    """Return what is said of the machine of a file or a built-in name. Raises InputError as `load_machine`.

    A room whose machines are not all driven by an angle describes them by its own `describe(source, changes)`.
    """
    module = find_machine_room(source)
    own = getattr(module, "describe", None)
    description: Description = own(source, changes) if own else describe_machine(load_machine(source, changes))
    return description


def describe_machine(machine: Machine) -> Description:
    """Return what a machine that an angle drives says of itself."""
    functions = {"prologue": machine.prologue, "lane": machine.lane, "totals": machine.totals, "events": machine.events}
    if machine.loops is not None:
        functions |= {"assembly": machine.loops.assembly, "closure": machine.loops.gaps}
    ends = zip(machine.moved, machine.lower / machine.scale, machine.upper / machine.scale, strict=True)
    return Description(
        name=machine.name,
        title=machine.name,
        source=machine.source,
        assumptions=machine.assumptions,
        values=machine.values,
        data=machine.data,
        bounds={machine.values[index].path: (float(low), float(high)) for index, low, high in ends},
        origins={},
        quantities=machine.quantities,
        functions=tuple(
            FunctionSignature(name, tuple(function.name_in()), function.numel_out(0))
            for name, function in functions.items()
            if function is not None
        ),
    )
