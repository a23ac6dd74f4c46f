"""Sweeps and tolerances of clutches: `ROOM`, as `planter.tolerance.room` has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from planter.tolerance.machine_room import FileRoom

if TYPE_CHECKING:
    from planter.clutch.file import Clutch
    from planter.engine.machine import Machine


class Room(FileRoom):
    """Clutches."""

    def takes(self, source: str) -> bool:
        """Return whether a source is a clutch's file, or the name of a built-in one."""
        from planter.clutch import machines

        return machines.takes(source)

    def load(self, source: str, changes: Mapping[str, float]) -> Clutch:
        """Return the file, some numbers set."""
        from planter.clutch import file

        return file.load(source, changes)

    def build(self, machine: Clutch) -> Machine:
        """Return the machine of a file."""
        from planter.clutch import machines

        return machines.build_machine(machine)


ROOM = Room()
