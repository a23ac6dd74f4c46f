"""User-defined mechanisms as subjects of the studio: `KIND`, found by name."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from planter.errors import InputError
from planter.measured.section import SECTION
from planter.measured.sensor_view import describe_sensor_inputs, find_sensor_view
from planter.report.subject import (
    STARTS,
    Control,
    DetailTable,
    Export,
    GoalQuantity,
    Reading,
    RequirementCheck,
    Sought,
    Values,
    list_controls,
    write_numbers,
)

if TYPE_CHECKING:
    from planter.mechanism.file import MechanismFile
    from planter.mechanism.model import MechanismCycle
    from planter.report.scene import Scene
    from planter.report.subject import Portable

MOST_READINGS = 12
"""Results whose largest and least values are displayed."""
VALUES = "values"
"""Section of the file that has the numbers of the mechanism."""
EXPORTS = (Export("report", "page, figures and table of a turn", ("simulate",)),)


class MechanismView:
    """A mechanism that an angle drives."""

    handles: Sequence[tuple[str, str]] = ()
    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, file: MechanismFile, draws_shapes: bool = True) -> None:
        self.file, self.name, self.draws_shapes = file, file.name, draws_shapes
        self._latest: tuple[dict[str, float], MechanismCycle] | None = None

    @cached_property
    def controls(self) -> Sequence[Control]:
        """Its values, within their bounds if the file has any."""
        meanings = {entry["shown"]: entry["meaning"] for entry in self.file.entries}
        bounds = {f"{VALUES}.{key}": pair for key, pair in self.file.bounds.items()}
        if self.file.measurement is not None:
            meanings |= describe_sensor_inputs(find_sensor_view(self._compute_cycle({}).machine))
        return list_controls(self.file, meanings, meanings, bounds)

    @property
    def rigid(self) -> MechanismView:
        """The mechanism without its sensor, and without springs, guides, cams and pitch curves, for
        pages without a server, whose programs compute neither.
        """
        return MechanismView(self.file.model_copy(update={SECTION: None}), draws_shapes=False)

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Return its bodies over a cycle."""
        from planter.mechanism.drawing import PlotAxis, build_scene, select_frames
        from planter.report.scene import Curve

        cycle = self._compute_cycle(values)
        axis = PlotAxis.from_cycle(cycle)
        scene = build_scene(
            self.name,
            axis,
            cycle.seconds,
            cycle.columns,
            cycle.places,
            cycle.machine,
            cycle.shapes if self.draws_shapes else {},
        )
        if cycle.measured is not None:
            values_shown = cycle.measured.signal[select_frames(len(cycle.angles_deg))]
            measured = Curve(cycle.measured.name, cycle.measured.result.unit, values_shown)
            scene = replace(scene, curves=[measured, *scene.curves])
        return [scene]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Return largest and least values of what the sensor sees, and of the first results that
        change.
        """
        from planter.engine.wording import name_quantity
        from planter.measured.sensor_presentation import list_signal_readings

        cycle = self._compute_cycle(values)
        extremes, results = (
            cycle.result.quantities,
            {quantity.key: quantity for quantity in cycle.machine.results},
        )
        keys = self._list_moving(values)[:MOST_READINGS]
        return [
            *list_signal_readings(cycle.measured),
            *(
                Reading(f"{name_quantity(results[key])}, {kind}", extremes[key].unit, value)
                for key in keys
                for kind, value in (("largest", extremes[key].max), ("least", extremes[key].min))
            ),
        ]

    def _list_moving(self, values: Values) -> list[str]:
        """Return the keys of results that change over the cycle, as curves are ordered."""
        from planter.mechanism.drawing import sort_curves

        cycle = self._compute_cycle(values)
        extremes = cycle.result.quantities
        moving = [key for key, extreme in extremes.items() if extreme.max > extreme.min]
        return sort_curves(moving, cycle.machine)

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """Return the limits of the file over the cycle."""
        from planter.mechanism.optimisation import list_limit_checks

        cycle = self._compute_cycle(values)
        return list_limit_checks(cycle.machine, cycle.result.holds or ())

    def details(self, values: Values, model: str) -> Sequence[DetailTable]:
        """Return nothing: the report of the cycle has details."""
        return []

    def text(self, values: Values) -> str:
        """Return the mechanism's file with these values and the folder of its functions."""
        return self.with_locks(values, ())

    @property
    def search(self) -> Sequence[str]:
        """Words of the search within the bounds of the file, if it has any."""
        return ("optimise",) if self.lockable else ()

    starts = STARTS

    def describe_goal(self) -> str:
        """Return the sum of measures of the file's objective, if it has one."""
        return "" if self.file.objective is None else self.describe_sum(None)

    def list_goal_quantities(self, values: Values) -> Sequence[GoalQuantity]:
        """Return the results that change over the cycle, loads before motions."""
        from planter.engine.wording import name_quantity

        results = {
            quantity.key: quantity for quantity in self._compute_cycle(values).machine.results
        }
        return [
            GoalQuantity(results[key].name, name_quantity(results[key]))
            for key in self._list_moving(values)
        ]

    def describe_sum(self, sum_text: str | None) -> str:
        """Return a sum of measures, or that of the file, in words with units."""
        from planter.mechanism.machines import build_machine
        from planter.mechanism.optimisation import StatedGoal

        return StatedGoal.read(build_machine(self.file), sum_text).describe()

    @property
    def lockable(self) -> Sequence[str]:
        """Values with bounds."""
        return [f"{VALUES}.{name}" for name in self.file.bounds]

    def with_locks(self, values: Values, locked: Collection[str]) -> str:
        """Return the file as `text` does, without the bounds of locked values."""
        bounds = {
            name: pair
            for name, pair in self.file.bounds.items()
            if f"{VALUES}.{name}" not in locked
        }
        changes = {"folder": str(self.file.place), "bounds": bounds}
        return write_numbers(self.file, self._with_values(values).model_copy(update=changes))

    @property
    def words(self) -> Mapping[str, str]:
        """No keys: messages have the names of the page."""
        return {}

    def sought(self, answer: Mapping[str, Any]) -> Sought:
        """Return the optimum of the file's objective."""
        return Sought.from_answer(answer, VALUES)

    def portable(self, model: str) -> Portable:
        """Return the program of the cycle for a page."""
        from planter.mechanism.drawing import MechanismCycleProgram

        return MechanismCycleProgram(self.file).build_portable()

    def handed(self, values: Values) -> str:
        """Return the file without the folder of its functions."""
        return write_numbers(self.file, self._with_values(values))

    def _with_values(self, values: Values) -> MechanismFile:
        return self.file.with_numbers(values)

    def _compute_cycle(self, values: Values) -> MechanismCycle:
        from planter.mechanism.cycle import compute_cycle, measure_sensor
        from planter.mechanism.machines import build_machine
        from planter.mechanism.model import Model

        if self._latest is None or self._latest[0] != dict(values):
            cycle = compute_cycle(Model(build_machine(self._with_values(values))))
            self._latest = dict(values), replace(cycle, measured=measure_sensor(cycle)[0])
        return self._latest[1]


def build_scene(thing: object) -> Scene | None:
    """Return the motion of a cycle, None of anything else."""
    from planter.mechanism.drawing import PlotAxis, build_scene
    from planter.mechanism.model import MechanismCycle

    if not isinstance(thing, MechanismCycle):
        return None
    axis, machine = PlotAxis.from_cycle(thing), thing.machine
    return build_scene(
        machine.name, axis, thing.seconds, thing.columns, thing.places, machine, thing.shapes
    )


def open_view(source: str, changes: Values) -> MechanismView:
    """Return the mechanism in a file.

    Raises InputError if no angle drives it: what is shown is a cycle, which ends as it begins.
    """
    from planter.mechanism.file import load

    file = load(source, changes)
    if not file.is_driven:
        raise InputError(
            f"{source}: no angle drives {file.name}, and a cycle is shown, which ends as it "
            f"begins; `planter simulate {file.name} --until S --out DIR` shows its motion"
        )
    return MechanismView(file)
