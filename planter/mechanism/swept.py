"""Sweeps and tolerances of user-defined mechanisms: the adapter `ADAPTER`, found by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.mechanism import file
from planter.rows.adapter import MachineAdapter

if TYPE_CHECKING:
    from planter.engine.measures import Limit, Measure
    from planter.mechanism.file import MechanismFile


class MechanismSweepAdapter(MachineAdapter):
    """Mechanisms, driven or free."""

    def frozen(self, machine: MechanismFile) -> dict[str, Any]:
        """Return its table, its source and the folder of its functions."""
        return {"table": machine.table(), "source": machine.source, "folder": str(machine.place)}

    def thaw(self, frozen: Mapping[str, Any]) -> MechanismFile:
        """Return the file of a table."""
        return file.build_from_table(frozen["table"], frozen["source"], Path(frozen["folder"]))

    def read_goal(self, machine: MechanismFile) -> tuple[Sequence[Measure], Sequence[Limit], int]:
        """Return the file's objective, its limits, and the number of samples of a cycle."""
        from planter.mechanism.optimisation import StatedGoal

        goal = StatedGoal.read(self.build(machine))
        goal.require_averages()
        return goal.objective, goal.limits, goal.machine.objective_samples


ADAPTER = MechanismSweepAdapter(__package__)
