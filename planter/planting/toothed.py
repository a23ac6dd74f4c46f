"""The toothed gears of a planting device, as `planter gears` wants them."""

from __future__ import annotations

from pathlib import Path

from planter.files import examples
from planter.gears.request import GearOptions
from planter.gears.results import GearsFound
from planter.progress import Listener


def takes(source: str) -> bool:
    """Whether a source is a planting device."""
    return examples.resembles(source, "planting")


def make(source: str, wanted: GearOptions, out: Path | None = None, progress: Listener | None = None) -> GearsFound:
    """The gears of both stages. Raises as `gears.gears` and `gears.gear_set.make_gear_set` do."""
    from planter.gears import gear_set
    from planter.planting import file, gears
    from planter.planting.model import Device

    speed = {} if wanted.speed_rpm is None else {"operation.speed_rpm": wanted.speed_rpm}
    device = Device(file.load(source, {**wanted.changes, **speed}), "exact")
    found = gears.gears(device, wanted.teeth, wanted.modules_mm, wanted.counts, wanted.keep)
    return gear_set.make_gear_set(found, wanted.teeth, wanted.part_settings, out, progress)
