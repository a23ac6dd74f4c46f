"""The toothed gears of a pick-up: the non-circular sun and intermediate gear, incomplete where the arm dwells."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import examples
from planter.gearing.teeth.incomplete.locking import Intermittent, intermittent
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.gears import intermittent as made_known
from planter.gears.options import Keep, Teeth
from planter.gears.results import GearsFound
from planter.gears.room import Wanted
from planter.kernels import Array
from planter.pickup import gears
from planter.pickup.file import Pickup, is_points, load
from planter.pickup.model import Train, build
from planter.progress import Listener
from planter.report import files

NAMES = ("sun", "intermediate gear")


def takes(source: str) -> bool:
    """Whether a source is a pick-up, or the points of its path."""
    return is_points(source) or examples.resembles(source, "pickup")


def make(source: str, wanted: Wanted, out: Path | None = None, progress: Listener | None = None) -> GearsFound:
    """The gears of a pick-up.

    Raises InputError for what no pick-up takes and for a law without teeth beside a dwell, GeometryError as
    `intermittent` does.
    """
    machine = load(source, wanted.changes)
    _check(machine, wanted)
    train = build(machine)
    gears.check(machine, train)
    found = cut(machine, train, wanted.teeth, wanted.modules_mm[0], wanted.counts[0] if wanted.counts else None)
    return made_known.make(found, machine.name, wanted.teeth, wanted.made, files.provenance(machine), out, progress)


def _check(machine: Pickup, wanted: Wanted) -> None:
    """Raise InputError for what is wanted that no pick-up takes."""
    refused = {
        "--speed-rpm is not allowed: no pick-up's gears depend on its speed": wanted.speed_rpm is not None,
        "--centre-error-mm is not allowed: a pick-up's gears are tried at their own distance": (
            wanted.teeth.centre_error_mm > 0
        ),
        "--keep module is not allowed: the size of a pick-up's gears follows from its bars": (
            wanted.keep is Keep.module
        ),
        "a pick-up has one non-circular pair: it takes --module M or --teeth Z": (
            len(wanted.counts) > 1 or wanted.modules_mm[0] != wanted.modules_mm[1]
        ),
    }  # fmt: skip
    for told, given in refused.items():
        if given:
            raise InputError(f"{machine.source}: {told}")


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
