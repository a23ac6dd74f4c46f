"""Sweeps and tolerances of linkages and gear trains of poses: `ROOM`, as `planter.tolerance.room` has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from planter.tolerance.machine_room import FileRoom

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.mapping.file import PoseFile


class Room(FileRoom):
    """Linkages and gear trains of poses."""

    def takes(self, source: str) -> bool:
        """Return whether a source is a file of poses, or the name of a built-in one."""
        from planter.mapping import machines

        return machines.takes(source)

    def load(self, source: str, changes: Mapping[str, float]) -> PoseFile:
        """Return the file, some numbers set."""
        from planter.mapping import file

        return file.load_poses(source, changes)

    def build(self, machine: PoseFile) -> Machine:
        """Return the machine of a file."""
        from planter.mapping import machines

        return machines.build_machine(machine)


ROOM = Room()
