"""A device as a unit for co-simulation: its carrier's speed goes in, angle, motions and forces come out.

The templates stand beside this file: `fmu.c`, and what `c99` fills.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.files import ranges, units
from planter.interchange.fmi import archive, libraries
from planter.interchange.fmi.model import MAIN, Model
from planter.interchange.variables import Variable
from planter.kernels.toolchain import NoCompiler
from planter.planting.export import c99
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.quantities import quantities
from planter.planting.results.exported import LeftOut, UnitWritten
from planter.report.files import output_folder, write_bytes
from planter.report.folder import check
from planter.version import __version__

SPEED = "operation.speed_rpm"
"""What of the machine's data is the input."""
PLACES = {0: "", 1: "side1.", 2: "side2."}
"""What stands before the name of a quantity of both sides, of side 1, of side 2."""


def model(device: Device) -> Model:
    """What the unit says of itself."""
    speed = device.constants[_speed(device)]
    return Model(
        name=c99.name(device),
        title=device.machine.name,
        meaning=f"{c99.headline(device)}. The carrier's speed is prescribed: motions and forces are those of a "
        "constant speed of its value, and nothing acts back on it; over a step it is held. "
        f"Assumes: {'; '.join(device.sidecar['assumptions'])}.",
        tool=f"planter {__version__}",
        variables=tuple(_variables(device)),
        period=float(2 * np.pi / speed),
        steps=device.machine.objective.samples,
    )


def sources(device: Device) -> dict[str, str]:
    """The C files of the unit by name, but for those of every unit."""
    given = [variable for variable in _variables(device) if variable.causality != "output"]
    values = {
        **c99.description(device), "name": c99.name(device), "NAME": c99.name(device).upper(), "speed": _speed(device),
        "starts": ", ".join(repr(variable.start) for variable in given),
        "names": ", ".join(f'"{variable.name} is not finite"' for variable in given),
    }  # fmt: skip
    own = {file: text for file, text in c99.source_files(device).items() if not file.endswith("_main.c")}
    return own | {MAIN: Template(c99.template("fmu.c")).substitute(values)}


def _speed(device: Device) -> int:
    """Place of the carrier's speed in the machine's data."""
    return [entry["shown"] for entry in device.sidecar["vectors"]["machine"]].index(SPEED)


def _variables(device: Device) -> Iterator[Variable]:
    """In the order of `fmu.c`."""
    speed = float(device.constants[_speed(device)])
    yield Variable(
        "speed", "rad/s", "speed of the carrier, prescribed, held over a step", "input", speed, 0.0,
        shown="r/min", factor=units.factor(SPEED),
    )  # fmt: skip
    yield Variable("phi_start", "rad", "angle of the carrier at the start", "parameter", 0.0, shown="deg",
                   factor=units.factor("phi_deg"), fixed=True)  # fmt: skip
    yield from _design(device)
    yield from _data(device)
    yield Variable("phi", "rad", "angle of the carrier", "output", shown="deg", factor=units.factor("phi_deg"))
    for q in quantities(device.sidecar):
        name = f"{PLACES[q.side]}{q.name.removesuffix('_2') if q.side == 2 else q.name}"
        yield Variable(name, q.unit, q.meaning, "output", **_shown(q.shown, q.unit))


def _design(device: Device) -> Iterator[Variable]:
    """The design, within its bounds; a design of the file's own that is outside of them stays allowed."""
    limits = zip(device.design, device.lower, device.upper, strict=True)
    for name, entry, (own, low, high) in zip(device.names, device.entries, limits, strict=True):
        yield Variable(
            f"design.{name.removesuffix(units.suffix(name))}", entry["unit"], f"{entry['meaning']}, design.{name}",
            "parameter", float(own), float(min(own, low)), float(max(own, high)), **_shown(name, entry["unit"]),
        )  # fmt: skip


def _data(device: Device) -> Iterator[Variable]:
    """The machine's data but its speed."""
    for entry, value in zip(device.sidecar["vectors"]["machine"], device.constants, strict=True):
        key = entry["shown"]
        if key != SPEED:
            low, high = (limit if limit is None else limit * units.factor(key) for limit in ranges.of(Machine, key))
            yield Variable(
                f"machine.{entry['name']}", entry["unit"], f"{entry['meaning']}, {key}", "parameter", float(value), low,
                high, **_shown(key, entry["unit"]),
            )  # fmt: skip


def _shown(key: str, unit: str) -> dict[str, Any]:
    """The unit of a key, where it is not SI's."""
    factor = units.factor(key)
    return {} if factor == 1.0 or units.unit(key) == unit else {"shown": units.unit(key), "factor": factor}


def write(device: Device, file: Path, fmi: str = "2.0") -> UnitWritten:
    """Writes the unit, by a version of FMI, with the libraries that can be built here.

    Raises InputError for a file whose name does not end in .fmu, or that cannot be written.
    """
    if file.suffix != ".fmu":
        raise InputError(f"--out {file} is not allowed: the name of a unit's file ends in .fmu")
    check(file.parent, [file.name])
    version, own = archive.VERSIONS[fmi], model(device)
    token, texts = archive.sources(version, own, sources(device))
    built: dict[str, tuple[str, bytes]] = {}
    left_out = []
    for platform in libraries.PLATFORMS:
        try:
            built[platform] = libraries.build(platform, texts, own.name)
        except NoCompiler as reason:
            left_out.append(LeftOut(platform, str(reason)))
    target = output_folder(file.parent) / file.name
    write_bytes(target, archive.archive(version, own, texts, token, built))
    causes = Counter(variable.causality for variable in own.variables)
    return UnitWritten(
        [str(target)], fmi, token, causes["input"], causes["parameter"], causes["output"], list(built), left_out
    )
