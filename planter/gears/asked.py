"""What the options of gears come to in SI."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.files import csv_rows
from planter.gearing.teeth.order import Order
from planter.gears.options import Keep, Process
from planter.gears.parts import Parts
from planter.workshop.bores import Bore, Keyway, standard


@dataclass(frozen=True)
class Teeth:
    """The options of teeth as they are given: mm, deg, modules."""

    pressure_angle: float = 20.0
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    tip_radius: float = 1.0
    backlash_mm: float = 0.0
    centre_error_mm: float = 0.0
    process: Process = Process.hob
    allow_undercut: bool = False

    def order(self, teeth: int | None, module_mm: float | None, keep: Keep | None) -> Order:
        """What is ordered for a pair."""
        own: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        play = own.pop("backlash_mm") * 1e-3
        own.pop("centre_error_mm")
        own["pressure_angle"] = float(np.radians(self.pressure_angle))
        own["process"] = self.process.value
        module = None if module_mm is None else module_mm * 1e-3
        return Order(teeth=teeth, module=module, keep=keep.value if keep else None, play=play, **own)


def counts(given: str | None, most: int = 2) -> tuple[int, ...]:
    """The whole numbers of `--teeth`. Raises InputError for other text."""
    if given is None:
        return ()
    parts = [part.strip() for part in given.split(",")]
    if not all(part.isdecimal() for part in parts) or len(parts) > most:
        raise InputError(f"--teeth {given} is not allowed: it must be {' or '.join(('Z', 'Z1,Z2')[:most])}")
    return tuple(map(int, parts))


def modules(both: float | None, first: float | None, second: float | None) -> tuple[float | None, float | None]:
    """The modules [mm] of both stages. Raises InputError where both stages' module is given beside one of them."""
    if both is not None and (first is not None or second is not None):
        raise InputError("--module is that of both stages: it does not go with --module1 or --module2")
    return (both, both) if both is not None else (first, second)


def parts(
    tolerance_um: float, bore_mm: float | None, keyway_mm: str | None, width_mm: float, step: bool, stl: bool
) -> Parts:
    """What files are made of. Raises InputError for a keyway that cannot be."""
    bore = None
    if bore_mm is not None:
        bore = Bore(bore_mm * 1e-3, _keyway(bore_mm, keyway_mm))
    elif keyway_mm is not None:
        raise InputError(f"--keyway-mm {keyway_mm} is not allowed without --bore-mm")
    return Parts(tolerance_um * 1e-6, bore, width_mm * 1e-3, step, stl)


def _keyway(bore_mm: float, given: str | None) -> Keyway | None:
    if given == "none":
        return None
    if given is None:
        return Keyway(*standard(bore_mm * 1e-3))
    values = [csv_rows.number(part) for part in given.split(",")]
    if len(values) != 2 or not all(value is not None and 0 < value < bore_mm for value in values):
        raise InputError(
            f"--keyway-mm {given} is not allowed: it must be WIDTH,DEPTH above 0 and below the bore, or none"
        )
    width, depth = (value * 1e-3 for value in values if value is not None)
    return Keyway(width, depth)
