"""Requests for gears: command-line options in SI units, and the machines whose gears can be cut.

A machine's package brings a module `toothed` with the functions of `GearMachineAdapter`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np

from planter import plugins
from planter.errors import InputError
from planter.files import csv_rows, examples, text
from planter.gear_geometry.cutting import ToothOrder
from planter.gears.options import Keep, Process
from planter.gears.parts import PartSettings
from planter.gears.results import GearsFound
from planter.progress import Listener
from planter.workshop.bores import Bore, Keyway, find_standard_keyway


@dataclass(frozen=True)
class Teeth:
    """The options of teeth in the units of the command line: mm, deg, modules."""

    pressure_angle: float = 20.0
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    tip_radius: float = 1.0
    backlash_mm: float = 0.0
    centre_error_mm: float = 0.0
    process: Process = Process.hob
    allow_undercut: bool = False

    def order(self, teeth: int | None, module_mm: float | None, keep: Keep | None) -> ToothOrder:
        """Return the order for a pair in SI units."""
        options: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        play = options.pop("backlash_mm") * 1e-3
        options.pop("centre_error_mm")
        options["pressure_angle"] = float(np.radians(self.pressure_angle))
        options["process"] = self.process.value
        module = None if module_mm is None else module_mm * 1e-3
        return ToothOrder(teeth=teeth, module=module, keep=keep.value if keep else None, play=play, **options)


def parse_tooth_counts(argument: str | None, limit: int = 2) -> tuple[int, ...]:
    """Return the tooth counts of `--teeth`. Raises InputError if the text is not Z or Z1,Z2."""
    if argument is None:
        return ()
    parse_part_settings = [part.strip() for part in argument.split(",")]
    if not all(part.isdecimal() for part in parse_part_settings) or len(parse_part_settings) > limit:
        raise InputError(f"--teeth {argument}: give {' or '.join(('Z', 'Z1,Z2')[:limit])} with integers")
    return tuple(map(int, parse_part_settings))


def parse_modules(both: float | None, first: float | None, second: float | None) -> tuple[float | None, float | None]:
    """Return the modules [mm] of both stages. Raises InputError for `--module` together with one of a stage."""
    if both is not None and (first is not None or second is not None):
        raise InputError("--module sets both stages: leave out --module1 and --module2")
    return (both, both) if both is not None else (first, second)


def parse_part_settings(
    tolerance_um: float, bore_mm: float | None, keyway_mm: str | None, width_mm: float, step: bool, stl: bool
) -> PartSettings:
    """Return the settings of the files. Raises InputError for an invalid keyway."""
    bore = None
    if bore_mm is not None:
        bore = Bore(bore_mm * 1e-3, _parse_keyway(bore_mm, keyway_mm))
    elif keyway_mm is not None:
        raise InputError(f"--keyway-mm {keyway_mm} needs --bore-mm")
    return PartSettings(tolerance_um * 1e-6, bore, width_mm * 1e-3, step, stl)


def _parse_keyway(bore_mm: float, argument: str | None) -> Keyway | None:
    if argument == "none":
        return None
    if argument is None:
        return Keyway(*find_standard_keyway(bore_mm * 1e-3))
    values = [csv_rows.number(part) for part in argument.split(",")]
    if len(values) != 2 or not all(value is not None and 0 < value < bore_mm for value in values):
        raise InputError(f"--keyway-mm {argument}: give WIDTH,DEPTH, both above 0 and below the bore, or none")
    width, depth = (value * 1e-3 for value in values if value is not None)
    return Keyway(width, depth)


@dataclass(frozen=True)
class GearOptions:
    """Options of the command for a machine's gears, in the units of the command line.

    `explicit` names the options of `teeth` that the user set; a machine's file may set the others. `modules_mm` and
    `counts` belong to stages 1 and 2, `changes` are new values of the machine's file by name. An adapter refuses
    options that do not apply to its machines.
    """

    teeth: Teeth
    part_settings: PartSettings
    explicit: frozenset[str] = frozenset()
    modules_mm: tuple[float | None, float | None] = (None, None)
    counts: tuple[int, ...] = ()
    keep: Keep | None = None
    changes: Mapping[str, float] = field(default_factory=dict)
    speed_rpm: float | None = None


class GearMachineAdapter(Protocol):
    """Protocol of the module `toothed` of a kind of machine."""

    def takes(self, source: str) -> bool:
        """Return whether a file, or a built-in name, describes a machine of this kind, judged by its tables."""

    def make(
        self, source: str, options: GearOptions, out: Path | None = None, progress: Listener | None = None
    ) -> GearsFound:
        """Return the gears of a machine, and write their files if a folder is given.

        Raises InputError for an invalid file or option, GeometryError for gears that cannot be cut.
        """


def find_adapter(source: str) -> GearMachineAdapter:
    """Return the adapter of a machine file or built-in name. Raises InputError if no adapter takes it."""
    adapters = [cast(GearMachineAdapter, module) for module in plugins.load_modules("toothed")]
    for adapter in adapters:
        if adapter.takes(source):
            return adapter
    text.parse_toml(examples.text(source), source)
    names = [name for name in examples.names(suffix=".toml") if any(adapter.takes(name) for adapter in adapters)]
    raise InputError(f"{source}: `planter gears` does not cut gears of this machine; use one like {', '.join(names)}")
