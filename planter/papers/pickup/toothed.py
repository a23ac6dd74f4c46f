"""The toothed gears of a pick-up: the non-circular sun and intermediate gear, incomplete where the
arm dwells.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.gears.gear_set import GearSet, place_gears
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.intermittent_gears import IntermittentPair, build_intermittent_pair
from planter.gears.request import GearOptions
from planter.papers.pickup import gears
from planter.papers.pickup.file import Pickup, load_pickup
from planter.papers.pickup.gears import build_rolling
from planter.papers.pickup.model import PickupTrain, build_train
from planter.report import files

NAMES = ("sun", "intermediate gear")


def cut_gears(source: str, options: GearOptions) -> GearSet:
    """The gears of a pick-up.

    Raises InputError for what no pick-up takes and for a law without teeth next to a dwell,
    GeometryError as `build_intermittent_pair` does.
    """
    machine = load_pickup(source, options.changes)
    _check(machine, options)
    train = build_train(machine)
    gears.check_gears(machine, train)
    rack = _read_rack(machine)
    order = replace(options.order, **{key: rack[key] for key in rack.keys() - options.explicit})
    pair = _cut_pair(machine, train, order, options)
    middle = pair.rolling.dwell_positions(np.array([0.5]))
    return GearSet(
        machine=machine.name,
        order=order,
        placed=place_gears(pair.gears, middle),
        provenance=files.list_provenance(machine),
        intermittent=pair,
    )


def _check(machine: Pickup, request: GearOptions) -> None:
    """Raise InputError for what is wanted that no pick-up takes."""
    refused = {
        "--speed-rpm: no pick-up's gears depend on its speed": request.speed_rpm is not None,
        "a pick-up has one non-circular pair: it takes --module M or --teeth Z": (
            len(request.counts) > 1 or request.modules_mm[0] != request.modules_mm[1]
        ),
    }
    for message, is_given in refused.items():
        if is_given:
            raise InputError(f"{machine.source}: {message}")


def _read_rack(machine: Pickup) -> dict[str, Any]:
    """Return the rack of the file: different addenda belong to one shifted rack."""
    stage = machine.noncircular_stage
    mean, shift = (stage.ha1 + stage.ha2) / 2, (stage.ha1 - stage.ha2) / 2
    angle = float(np.radians(stage.alpha0_deg))
    return {"pressure_angle": angle, "addendum": mean, "shift": shift}


def _cut_pair(
    machine: Pickup, train: PickupTrain, order: ToothOrder, request: GearOptions
) -> IntermittentPair:
    """The non-circular pair with the module given or in the file, or with the requested number of
    teeth on its arc.
    """
    if train.law.dwell is None:
        raise InputError(
            f"{machine.source}: the arm does not dwell, but incomplete gears need a dwell"
        )
    if train.driven != train.toothed:
        raise InputError(
            f"{machine.source}: the arm is driven by other means than teeth next to the dwell, "
            "where no pitch curve leads to the locking arcs: the law's slope must jump there"
        )
    module = _module(machine, train, request)
    return build_intermittent_pair(build_rolling(train), module, order, machine.source, NAMES)


def _module(machine: Pickup, train: PickupTrain, request: GearOptions) -> float:
    """Module [m].

    Raises InputError where the one that is given and the number of teeth disagree.
    """
    module_mm, counts, arc = request.modules_mm[0], request.counts, train.arc
    if not counts:
        return float(train.teeth[0]) if module_mm is None else module_mm * 1e-3
    if request.keep == "module":
        raise InputError(
            f"{machine.source}: --keep module does not go with --teeth: the size follows from the "
            f"bars"
        )
    if module_mm is not None and abs(arc / (np.pi * module_mm * 1e-3) - counts[0]) > 0.5:
        raise InputError(
            f"{machine.source}: teeth = {counts[0]} and module = {module_mm:g} mm disagree: the "
            f"toothed arc is {arc * 1e3:.6g} mm long, which makes "
            f"{round(arc / (np.pi * module_mm * 1e-3))} teeth of that module"
        )
    return arc / (np.pi * counts[0])
