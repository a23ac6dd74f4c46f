"""The toothed gears of a pick-up: the non-circular sun and intermediate gear, incomplete where the arm dwells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import examples
from planter.gearing.teeth.incomplete.locking import Intermittent, intermittent
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.gears import intermittent as made_known
from planter.gears.options import Keep, Teeth
from planter.gears.parts import Parts
from planter.gears.results import GearsFound
from planter.kernels import Array
from planter.pickup import gears
from planter.pickup.file import Pickup, load
from planter.pickup.model import Train, build
from planter.progress import Listener
from planter.report import files
from planter.terminal.options import changes

NAMES = ("sun", "intermediate gear")
_TABLES = {"carrier", "helical_stage", "noncircular_stage"}


def takes(source: str) -> bool:
    """Whether a source is a pick-up's."""
    return examples.belongs(source, "pickup", _TABLES)


def make(
    source: str, teeth: Teeth, modules_mm: Sequence[float | None], counts: Sequence[int], keep: Keep | None,
    set_: Sequence[str] | None, made: Parts, out: Path | None, progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """The gears of a pick-up, by the options of a command.

    Raises InputError for options that no pick-up takes and for a law without teeth beside a dwell, GeometryError as
    `intermittent` does.
    """
    machine = load(source, changes(set_))
    train = build(machine)
    gears.check(machine, train)
    if keep is Keep.module:
        raise InputError("--keep module is not allowed: the size of a pick-up's gears follows from its bars")
    if len(counts) > 1 or modules_mm[0] != modules_mm[1]:
        raise InputError(f"{source}: a pick-up has one non-circular pair: it takes --module M or --teeth Z")
    found = cut(machine, train, teeth, modules_mm[0], counts[0] if counts else None)
    return made_known.make(found, machine.name, teeth, made, files.provenance(machine), out, progress)


def cut(machine: Pickup, train: Train, teeth: Teeth, module_mm: float | None, count: int | None) -> Intermittent:
    """The non-circular pair with whole teeth: as many as given, or nearest to the module given or in the file."""
    if train.law.dwell is None:
        raise InputError(f"{machine.source}: the arm does not dwell, but incomplete gears need a dwell")
    if train.driven != train.toothed:
        raise InputError(
            f"{machine.source}: the arm is driven by other means than teeth beside the dwell, where no pitch curve "
            f"leads to the locking arcs: the law's slope must jump there"
        )

    def radius(t: Array) -> Array:
        return train.pitch(t)["R1"]

    rolling = Rolling.of(radius, train.toothed, train.law.joints(), train.geometry.a1)
    wanted = train.arc / (np.pi * (float(train.teeth[0]) if module_mm is None else module_mm * 1e-3))
    z = count or round(wanted)
    if count and module_mm and abs(wanted - count) > 0.5:
        raise InputError(
            f"{machine.source}: teeth = {count} and module = {module_mm:g} mm disagree: the toothed arc is "
            f"{train.arc * 1e3:.6g} mm long, which makes {round(wanted)} teeth of that module"
        )
    return intermittent(rolling, z, teeth.order(z, None, None), machine.source, NAMES)
