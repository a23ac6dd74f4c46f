"""The toothed gears of a pick-up: the non-circular sun and intermediate gear, incomplete where the arm dwells."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.files import examples
from planter.gearing.teeth.incomplete.locking import IntermittentPair, build_intermittent_pair
from planter.gears import intermittent as made_known
from planter.gears.options import Keep
from planter.gears.request import GearOptions, Teeth
from planter.gears.results import GearsFound
from planter.pickup import gears
from planter.pickup.file import Pickup, is_points, load
from planter.pickup.locking import rolling
from planter.pickup.model import Train, build
from planter.progress import Listener
from planter.report import files

NAMES = ("sun", "intermediate gear")


def takes(source: str) -> bool:
    """Whether a source is a pick-up, or the points of its path."""
    return is_points(source) or examples.resembles(source, "pickup")


def make(source: str, wanted: GearOptions, out: Path | None = None, progress: Listener | None = None) -> GearsFound:
    """The gears of a pick-up.

    Raises InputError for what no pick-up takes and for a law without teeth beside a dwell, GeometryError as
    `intermittent` does.
    """
    machine = load(source, wanted.changes)
    _check(machine, wanted)
    train = build(machine)
    gears.check(machine, train)
    own: dict[str, Any] = {key: value for key, value in _own(machine).items() if key not in wanted.explicit}
    teeth = replace(wanted.teeth, **own)
    found = cut(machine, train, teeth, wanted)
    return made_known.make_intermittent_pair(
        found, machine.name, teeth, wanted.part_settings, files.provenance(machine), out, progress
    )


def _check(machine: Pickup, wanted: GearOptions) -> None:
    """Raise InputError for what is wanted that no pick-up takes."""
    refused = {
        "--speed-rpm is not allowed: no pick-up's gears depend on its speed": wanted.speed_rpm is not None,
        "a pick-up has one non-circular pair: it takes --module M or --teeth Z": (
            len(wanted.counts) > 1 or wanted.modules_mm[0] != wanted.modules_mm[1]
        ),
    }  # fmt: skip
    for told, given in refused.items():
        if given:
            raise InputError(f"{machine.source}: {told}")


def _own(machine: Pickup) -> dict[str, float]:
    """What the file says of the rack: different addenda are of one rack, shifted."""
    stage = machine.noncircular_stage
    mean, shift = (stage.ha1 + stage.ha2) / 2, (stage.ha1 - stage.ha2) / 2
    return {"pressure_angle": stage.alpha0_deg, "addendum": mean, "shift": shift}


def cut(machine: Pickup, train: Train, teeth: Teeth, wanted: GearOptions) -> IntermittentPair:
    """The non-circular pair with the module given or in the file, or with so many teeth on its arc as are given."""
    if train.law.dwell is None:
        raise InputError(f"{machine.source}: the arm does not dwell, but incomplete gears need a dwell")
    if train.driven != train.toothed:
        raise InputError(
            f"{machine.source}: the arm is driven by other means than teeth beside the dwell, where no pitch curve "
            f"leads to the locking arcs: the law's slope must jump there"
        )
    return build_intermittent_pair(rolling(train), _module(machine, train, wanted), teeth.order(None, None, None),
                        machine.source, NAMES)  # fmt: skip


def _module(machine: Pickup, train: Train, wanted: GearOptions) -> float:
    """Module [m]. Raises InputError where the one that is given and the number of teeth disagree."""
    given, counts, arc = wanted.modules_mm[0], wanted.counts, train.arc
    if not counts:
        return float(train.teeth[0]) if given is None else given * 1e-3
    if wanted.keep is Keep.module:
        raise InputError(f"{machine.source}: --keep module does not go with --teeth: the size follows from the bars")
    if given is not None and abs(arc / (np.pi * given * 1e-3) - counts[0]) > 0.5:
        raise InputError(
            f"{machine.source}: teeth = {counts[0]} and module = {given:g} mm disagree: the toothed arc is "
            f"{arc * 1e3:.6g} mm long, which makes {round(arc / (np.pi * given * 1e-3))} teeth of that module"
        )
    return arc / (np.pi * counts[0])
