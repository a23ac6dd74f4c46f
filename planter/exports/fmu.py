"""Units (FMI) of machines and of mechanisms that move freely, and what makes them differ.

Of a machine the drive's speed is the input; angle, motions and forces are outputs. A mechanism that
moves freely has states, which another program or the unit itself integrates. The templates are
`driven.c`, `free.c`, and those of `c99` and `dynamics`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.engine.machine import Machine, Value
from planter.errors import InputError
from planter.exports import c99, dynamics, fmi, quantities
from planter.exports.c99 import join_numbers, quote_strings, read_template
from planter.exports.fmi import MAIN, Causality, UnitModel, Variable
from planter.exports.quantities import SideQuantity
from planter.exports.results import MissingLibrary, UnitWritten
from planter.files import units
from planter.kernels.compiler import CompilerError
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.report.files import output_folder, write_bytes
from planter.report.folder import check_files
from planter.version import __version__

if TYPE_CHECKING:
    from planter.report.console import Console

DEGREES: dict[str, Any] = {"display_unit": "deg", "factor": units.unit_factor("phi_deg")}
RESERVED = ("speed", "phi_start", "phi", "time")
"""Names of the unit's own variables, and the time, which FMI knows."""
RATE_UNITS = {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2", "1": "1/s"}
"""Units of rates by those of states."""
FREE_PERIOD, FREE_STEPS = 1.0, 500
"""Proposed end of a free motion [s], and its steps."""

# --- driven machines -----------------------------------------------------------------------------


def build_driven_unit(machine: Machine) -> tuple[UnitModel, dict[str, str]]:
    """Return what the unit says of itself, and its C files by name but for those of every unit."""
    variables = tuple(_list_machine_variables(machine))
    order = [*machine.moved, *quantities.list_fixed(machine)]
    speed = abs(float(machine.data[machine.speed]))
    model = UnitModel(
        name=quantities.build_name(machine),
        title=machine.name,
        meaning=f"{quantities.build_headline(machine)}. The drive's speed is prescribed: motions "
        "and forces are those of a constant speed of its value, and loads do not change it; over a "
        f"step it is constant. Assumes: {'; '.join(machine.assumptions)}.",
        variables=variables,
        period=machine.turn / speed if speed else 1.0,
        steps=machine.samples,
    )
    headline = c99.describe_machine(machine)["headline"]
    plain = replace(machine, objective=()) if machine.objective else machine
    sources = c99.build_source_files(plain)
    fields = {"speed": order.index(machine.speed)}
    return model, _complete_texts("driven.c", model, headline, sources, fields)


def _complete_texts(
    template: str,
    model: UnitModel,
    headline: str,
    sources: Mapping[str, str],
    fields: Mapping[str, Any],
) -> dict[str, str]:
    """Return the sources of a model, without its program, and `MAIN` from a template."""
    starts = {x.name: x.start for x in model.variables if x.start is not None}
    values = {
        "headline": headline,
        "version": __version__,
        "name": model.name,
        "NAME": model.name.upper(),
        "starts": join_numbers(list(starts.values())),
        "names": quote_strings(f"{name} is not finite" for name in starts),
        **fields,
    }
    texts = {file: text for file, text in sources.items() if not file.endswith("_main.c")}
    return texts | {MAIN: read_template(template).substitute(values)}


def _list_machine_variables(machine: Machine) -> Iterator[Variable]:
    """Yield the variables in the order of `driven.c`."""
    value, speed = machine.values[machine.speed], float(machine.data[machine.speed])
    yield Variable(
        "speed",
        "rad/s",
        f"{value.meaning}, prescribed, held over a step",
        "input",
        speed,
        0.0 if speed >= 0 else None,
        **_display(value.path, "rad/s"),
    )
    yield Variable(
        "phi_start",
        "rad",
        "angle of the drive at the start",
        "parameter",
        0.0,
        fixed=True,
        **DEGREES,
    )
    bounds = zip(machine.lower, machine.upper, strict=True)
    for index, (low, high) in zip(machine.moved, bounds, strict=True):
        if index != machine.speed:
            number = float(machine.data[index])
            key = machine.values[index].key
            name = f"design.{key.removesuffix(units.unit_suffix(key))}"
            yield _build_parameter(
                machine, index, name, min(number, float(low)), max(number, float(high))
            )
    for index in quantities.list_fixed(machine):
        if index != machine.speed:
            fixed = machine.values[index]
            lower, upper = (
                None if limit is None else limit * fixed.factor for limit in fixed.limits
            )
            yield _build_parameter(machine, index, f"machine.{fixed.name}", lower, upper)
    yield Variable("phi", "rad", "angle of the drive", "output", **DEGREES)
    for entry in quantities.list_quantities(machine):
        q = entry.quantity
        yield Variable(
            build_output_name(entry), q.unit, q.meaning, "output", **_display(entry.key, q.unit)
        )


def _build_parameter(
    machine: Machine, index: int, name: str, low: float | None, high: float | None
) -> Variable:
    value: Value = machine.values[index]
    return Variable(
        name,
        value.unit,
        f"{value.meaning}, {value.path}",
        "parameter",
        float(machine.data[index]),
        low,
        high,
        **_display(value.path, value.unit),
    )


def build_output_name(entry: SideQuantity) -> str:
    """Return the name of an output: of several sides each stands before the quantity.

    A quantity with the name of one of the unit's own variables has `_quantity` behind it.
    """
    name = entry.quantity.name
    if entry.side and entry.sides > 1:
        return f"side{entry.side}.{name}"
    return f"{name}_quantity" if name in RESERVED else name


def _display(key: str, unit: str) -> dict[str, Any]:
    """Return the unit of a key, if it is not SI's."""
    factor = units.unit_factor(key)
    return (
        {}
        if factor == 1.0 or units.display_unit(key) == unit
        else {"display_unit": units.display_unit(key), "factor": factor}
    )


# --- free motion ---------------------------------------------------------------------------------


def build_free_unit(model: DynamicsModel) -> tuple[UnitModel, dict[str, str]]:
    """Return what the unit says of itself, and its C files by name but for those of every unit."""
    unit = UnitModel(
        name=dynamics.build_name(model),
        title=model.name,
        meaning=f"The free motion of {model.name}: states are coordinates and their rates.",
        variables=tuple(_list_free_variables(model)),
        period=FREE_PERIOD,
        steps=FREE_STEPS,
        states=len(model.states),
        events=model.events,
    )
    sources, fields = dynamics.build_c_files(model), {"events": model.events}
    return unit, _complete_texts("free.c", unit, model.name, sources, fields)


def _list_free_variables(model: DynamicsModel) -> Iterator[Variable]:
    """Yield the variables in the order of `free.c`."""
    yield from _convert(model.states, "output")
    yield from _convert(model.inputs, "input")
    yield from _convert(model.parameters, "parameter")
    for state in model.states:
        unit, meaning = RATE_UNITS[state.unit], f"rate of {state.name}"
        yield Variable(f"der({state.name})", unit, meaning, "local")
    for variable in _convert(model.outputs, "output"):
        yield replace(variable, start=None)


def _convert(variables: Iterable[DynamicsVariable], causality: Causality) -> Iterator[Variable]:
    for x in variables:
        low, high = (None if np.isinf(end) else end for end in (x.low, x.high))
        yield Variable(x.name, x.unit, x.meaning, causality, x.value, low, high)


# --- files ---------------------------------------------------------------------------------------


def write_unit(subject: Machine | DynamicsModel, file: Path, number: str = "2.0") -> UnitWritten:
    """Write a unit by a version of FMI, with the libraries that can be built here.

    Raises InputError for a file whose name does not end in .fmu, or that cannot be written.
    """
    if file.suffix != ".fmu":
        raise InputError(f"--out {file}: the name of a unit's file ends in .fmu")
    check_files(file.parent, [file.name])
    model, sources = (
        build_driven_unit(subject) if isinstance(subject, Machine) else build_free_unit(subject)
    )
    version = fmi.VERSIONS[number]
    token, texts = fmi.complete_sources(version, model, sources)
    built: dict[str, tuple[str, bytes]] = {}
    left_out = []
    for platform in fmi.PLATFORMS:
        try:
            built[platform] = fmi.build_library(platform, texts, model.name)
        except CompilerError as reason:
            left_out.append(MissingLibrary(platform, str(reason)))
    target = output_folder(file.parent) / file.name
    write_bytes(target, fmi.pack_unit(version, model, texts, token, built))
    causes = Counter(variable.causality for variable in model.variables)
    return UnitWritten(
        files=[str(target)],
        fmi=number,
        token=token,
        inputs=causes["input"],
        parameters=causes["parameter"],
        outputs=causes["output"],
        platforms=list(built),
        left_out=left_out,
    )


def print_unit(console: Console, result: UnitWritten) -> None:
    """Print what a unit holds, and what it does not."""
    rows = [
        ("file", ", ".join(result.files)),
        ("inputs", result.inputs),
        ("parameters", result.parameters),
        ("outputs", result.outputs),
        ("libraries", ", ".join(result.platforms) or None),
    ]
    console.table("Unit", ("", f"FMI {result.fmi}"), rows)
    for library in result.left_out:
        print(f"no library for {library.platform}: {library.reason}")
