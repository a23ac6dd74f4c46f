"""A machine as a unit for co-simulation: its drive's speed is the input, angle, motions and forces
are outputs.

The templates are `fmu.c` in the folder of this file, and those of `c99`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.engine.machine import Machine, Value
from planter.errors import InputError
from planter.exports import c99, co_simulation, quantities
from planter.exports.c99 import quote_strings, read_template
from planter.exports.co_simulation import MAIN, UnitModel, Variable, Version
from planter.exports.quantities import SideQuantity
from planter.exports.results import MissingLibrary, UnitWritten
from planter.files import units
from planter.kernels.compiler import CompilerError
from planter.report.files import output_folder, write_bytes
from planter.report.folder import check_files
from planter.version import __version__

if TYPE_CHECKING:
    from planter.report.console import Console

DEGREES: dict[str, Any] = {"display_unit": "deg", "factor": units.unit_factor("phi_deg")}
RESERVED = ("speed", "phi_start", "phi", "time")
"""Names of the unit's own variables, and the time, which FMI knows."""


def build_model(machine: Machine) -> UnitModel:
    """Return what the unit says of itself."""
    speed = abs(float(machine.data[machine.speed]))
    return UnitModel(
        name=quantities.build_name(machine),
        title=machine.name,
        meaning=f"{quantities.build_headline(machine)}. The drive's speed is prescribed: motions "
        f"and forces are those "
        "of a constant speed of its value, and loads do not change it; over a step it is constant. "
        f"Assumes: {'; '.join(machine.assumptions)}.",
        tool=f"planter {__version__}",
        variables=tuple(_list_variables(machine)),
        period=machine.turn / speed if speed else 1.0,
        steps=machine.samples,
    )


def build_sources(machine: Machine) -> dict[str, str]:
    """Return the C files of the unit by name, but for those of every unit."""
    name = quantities.build_name(machine)
    settable = [variable for variable in _list_variables(machine) if variable.causality != "output"]
    order = [*machine.moved, *quantities.list_fixed(machine)]
    values = {
        **c99.describe_machine(machine),
        "name": name,
        "NAME": name.upper(),
        "speed": order.index(machine.speed),
        "starts": ", ".join(repr(variable.start) for variable in settable),
        "names": quote_strings(f"{variable.name} is not finite" for variable in settable),
    }
    plain = machine if machine.objective == () else replace(machine, objective=())
    texts = {
        file: text
        for file, text in c99.build_source_files(plain).items()
        if not file.endswith("_main.c")
    }
    return texts | {MAIN: read_template("fmu.c").substitute(values)}


def _list_variables(machine: Machine) -> Iterator[Variable]:
    """Yield the variables in the order of `fmu.c`."""
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


def write_unit(machine: Machine, file: Path, fmi: str = "2.0") -> UnitWritten:
    """Write the unit, by a version of FMI. Raises as `pack_unit`."""
    version, model = co_simulation.VERSIONS[fmi], build_model(machine)
    return pack_unit(version, model, build_sources(machine), file, fmi)


def pack_unit(
    version: Version, model: UnitModel, sources: Mapping[str, str], file: Path, fmi: str
) -> UnitWritten:
    """Write a unit of C sources by name, with the libraries that can be built here.

    Raises InputError for a file whose name does not end in .fmu, or that cannot be written.
    """
    if file.suffix != ".fmu":
        raise InputError(f"--out {file}: the name of a unit's file ends in .fmu")
    check_files(file.parent, [file.name])
    token, texts = co_simulation.complete_sources(version, model, sources)
    built: dict[str, tuple[str, bytes]] = {}
    left_out = []
    for platform in co_simulation.PLATFORMS:
        try:
            built[platform] = co_simulation.build_library(platform, texts, model.name)
        except CompilerError as reason:
            left_out.append(MissingLibrary(platform, str(reason)))
    target = output_folder(file.parent) / file.name
    write_bytes(target, co_simulation.pack_unit(version, model, texts, token, built))
    causes = Counter(variable.causality for variable in model.variables)
    return UnitWritten(
        [str(target)],
        fmi,
        token,
        causes["input"],
        causes["parameter"],
        causes["output"],
        list(built),
        left_out,
    )


def print_unit(console: Console, result: UnitWritten) -> None:
    """Print what a unit for co-simulation holds, and what it does not."""
    rows = [
        ("file", ", ".join(result.files)),
        ("inputs", result.inputs),
        ("parameters", result.parameters),
        ("outputs", result.outputs),
        ("libraries", ", ".join(result.platforms) or None),
    ]
    console.table("Unit for co-simulation", ("", f"FMI {result.fmi}"), rows)
    for library in result.left_out:
        print(f"no library for {library.platform}: {library.reason}")
