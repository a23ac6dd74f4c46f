"""Sweeps and tolerances of pick-ups: `ROOM`, as `planter.tolerance.room` has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from planter.tolerance.machine_room import FileRoom

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.pickup.file import Pickup


class Room(FileRoom):
    """Pick-ups."""

    def takes(self, source: str) -> bool:
        """Return whether a source is a pick-up's file, points of its tip's path, or the name of a built-in one."""
        from planter.pickup import machines

        return machines.takes(source)

    def load(self, source: str, changes: Mapping[str, float]) -> Pickup:
        """Return the file, some numbers set."""
        from planter.pickup import file

        return file.load(source, changes)

    def build(self, machine: Pickup) -> Machine:
        """Return the machine of a file."""
        from planter.pickup import machines, model

        return machines.build_machine(machine, model.build(machine))


ROOM = Room()
