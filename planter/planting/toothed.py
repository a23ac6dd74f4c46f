"""The toothed gears of a planting device, as `planter gears` wants them."""

from __future__ import annotations

from pathlib import Path

from planter.files import examples
from planter.gears.results import GearsFound
from planter.gears.room import Wanted
from planter.progress import Listener


def takes(source: str) -> bool:
    """Whether a source is a planting device."""
    return examples.resembles(source, "planting")


def make(source: str, wanted: Wanted, out: Path | None = None, progress: Listener | None = None) -> GearsFound:
    """The gears of both stages. Raises as `gears.gears` and `gears.command.make` do."""
    from planter.gears import command
    from planter.planting import file, gears
    from planter.planting.model import Device

    speed = {} if wanted.speed_rpm is None else {"operation.speed_rpm": wanted.speed_rpm}
    device = Device(file.load(source, {**wanted.changes, **speed}), "exact")
    found = gears.gears(device, wanted.teeth, wanted.modules_mm, wanted.counts, wanted.keep)
    return command.make(found, wanted.teeth, wanted.made, out, progress)
