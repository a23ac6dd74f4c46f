"""Adapters of machines for sweeps, tolerances and robust designs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from planter.engine.goal import Goal, resolve_limit, resolve_measure
from planter.engine.limits import MeasureLimits
from planter.engine.measures import Limit, Measure, parse_limit, parse_sum
from planter.errors import InputError
from planter.files.document import Document
from planter.rows.sweeps.adapter import SweepAdapter
from planter.rows.tolerance.job import Spread
from planter.rows.tolerance.robust import RobustGoal, Settings


class MachineAdapter(SweepAdapter):
    """Adapter with the robust design of a machine."""

    def build_robust(
        self,
        machine: Any,
        choices: Mapping[str, str],
        spreads: Mapping[str, Spread],
        settings: Settings,
    ) -> RobustGoal | None:
        """Return a sum of measures over machines within tolerances; None without a sum or without
        design variables.

        The sum, its limits and the design variables are those of the file or of the settings.
        Raises InputError if the settings state a search without a sum or without design variables.
        """
        built = self.build(machine).with_ranges(settings.ranges)
        terms, limits, samples = self.read_goal(machine)
        if settings.sum_text is not None:
            terms = [resolve_measure(built, measure) for measure in parse_sum(settings.sum_text)]
        limits = [*limits, *(resolve_limit(built, parse_limit(text)) for text in settings.holds)]
        if not terms or not built.moved:
            if not settings.is_stated:
                return None
            missing = (
                "values to search in: give --vary PATH=LOW:HIGH"
                if terms
                else "sum to minimise: give --least SUM"
            )
            raise InputError(f"{built.source}: the robust design has no {missing}")
        bounds = MeasureLimits(Goal(built, (), limits)) if limits else None
        return RobustGoal(
            replace(built, objective=tuple(terms)), spreads, settings, samples, bounds
        )

    def read_goal(self, machine: Any) -> tuple[Sequence[Measure], Sequence[Limit], int]:
        """Return the sum of measures that a file minimises, its limits, and samples.

        Raises InputError for measures of unknown quantities.
        """
        built = self.build(machine)
        return (
            [resolve_measure(built, measure) for measure in built.objective],
            [resolve_limit(built, limit) for limit in built.limits],
            built.objective_samples,
        )


class FileAdapter(MachineAdapter):
    """Adapter of machines whose files other processes read again, since they may name other files
    or be built in.
    """

    def frozen(self, machine: Any) -> dict[str, Any]:
        """Return the path of the file, its changed numbers, and its table, which must not
        change.
        """
        path, numbers = Path(machine.source), machine.numbers()
        return {
            "source": str(path.resolve()) if path.is_file() else machine.source,
            "changes": {name: numbers[name] for name in machine.changed if name in numbers},
            "table": machine.table(),
        }

    def thaw(self, frozen: Mapping[str, Any]) -> Document:
        """Load the file again. Raises InputError if it has changed."""
        document = self.load(frozen["source"], frozen["changes"])
        if document.table() != frozen["table"]:
            raise InputError(
                f"{frozen['source']}: the file has changed since the command started; run the "
                f"command again"
            )
        return document
