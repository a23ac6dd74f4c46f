"""Sweeps and tolerances of mechanisms of one's own: `ROOM`, as `planter.tolerance.room` has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.mechanism import file
from planter.tolerance.room import MachineRoom

if TYPE_CHECKING:
    from planter.engine.measures import Limit, Measure
    from planter.mechanism.file import MechanismFile


class Room(MachineRoom):
    """Mechanisms that an angle drives."""

    def frozen(self, machine: MechanismFile) -> dict[str, Any]:
        """Return its table, and where its functions are."""
        return {"table": machine.table(), "source": machine.source, "folder": str(machine.place)}

    def thaw(self, frozen: Mapping[str, Any]) -> MechanismFile:
        """Return the file of a table."""
        return file.made(frozen["table"], frozen["source"], Path(frozen["folder"]))

    def read_goal(self, machine: MechanismFile) -> tuple[Sequence[Measure], Sequence[Limit], int] | None:
        """Return the sum of the file's [objective], its limits, and the samples of one or of the other."""
        from planter.mechanism.optimisation import StatedGoal

        if machine.objective is None:
            return None
        goal = StatedGoal.read(self.build(machine))
        goal.require_averages()
        return goal.least, goal.limits, goal.machine.least_samples


ROOM = Room(__package__)
