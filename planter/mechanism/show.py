"""User-defined mechanisms as subjects of the studio: `KIND`, found by name."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
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
    from planter.engine.machine import Machine, Quantity
    from planter.mechanism.dynamics import MotionStep
    from planter.mechanism.file import MechanismFile
    from planter.mechanism.model import MechanismCycle
    from planter.mechanism.motion import MechanismMotion
    from planter.mechanism.motion_response import Motions
    from planter.mechanism.results import QuantityHistory, QuantityStatistics

    Extreme = QuantityStatistics | QuantityHistory
    from planter.report.scene import Scene
    from planter.report.subject import Portable

MOMENTS = 361
"""Times of a free motion that are drawn."""
MOST_READINGS = 12
"""Results whose largest and least values are displayed."""
VALUES = "values"
"""Section of the file that has the numbers of the mechanism."""
EXPORTS = (Export("report", "page, figures and table of a turn", ("simulate",)),)


class MechanismView:
    """A mechanism that an angle drives."""

    handles: Sequence[tuple[str, str]] = ()
    models: Sequence[str] = ("exact",)
    span_words = ""
    """What follows a quantity in a measure over all that is shown."""
    exports: Sequence[Export] = EXPORTS

    def __init__(self, file: MechanismFile) -> None:
        self.file, self.name = file, file.name
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
        """The mechanism without its sensor, for pages without a server."""
        return type(self)(self.file.model_copy(update={SECTION: None}))

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Return its bodies over a cycle."""
        from planter.mechanism.drawing import build_cycle_scene, select_frames
        from planter.report.scene import Curve

        cycle = self._compute_cycle(values)
        scene = build_cycle_scene(self.name, cycle)
        if cycle.measured is not None:
            values_shown = cycle.measured.signal[select_frames(len(cycle.angles_deg))]
            measured = Curve(cycle.measured.name, cycle.measured.result.unit, values_shown)
            scene = replace(scene, curves=[measured, *scene.curves])
        return [scene]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Return largest and least values of what the sensor sees, and of the first results that
        change.
        """
        from planter.measured.sensor_presentation import list_signal_readings

        signal = list_signal_readings(self._compute_cycle(values).measured)
        return [*signal, *self._list_extremes(values)]

    def _list_extremes(self, values: Values) -> Iterator[Reading]:
        from planter.engine.wording import name_quantity

        extremes = self._find_extremes(values)
        for quantity in self._list_moving(values)[:MOST_READINGS]:
            name, extreme = name_quantity(quantity), extremes[quantity.key]
            yield Reading(f"{name}, largest", extreme.unit, extreme.max)
            yield Reading(f"{name}, least", extreme.unit, extreme.min)

    def _list_moving(self, values: Values) -> list[Quantity]:
        """Return the results that change, as curves are ordered."""
        from planter.mechanism.drawing import find_motors, sort_curves

        extremes = self._find_extremes(values)
        moving = [key for key, extreme in extremes.items() if extreme.max > extreme.min]
        results = {quantity.key: quantity for quantity in self._machine.results}
        keys = sort_curves(moving, find_motors(self._machine))
        return [results[key] for key in keys if key in results]

    def _find_extremes(self, values: Values) -> Mapping[str, Extreme]:
        """Return least and greatest values of results by key."""
        return self._compute_cycle(values).result.quantities

    @cached_property
    def _machine(self) -> Machine:
        from planter.mechanism.machines import build_machine

        return build_machine(self.file)

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

        return [
            GoalQuantity(f"{quantity.name}{self.span_words}", name_quantity(quantity))
            for quantity in self._list_moving(values)
        ]

    def describe_sum(self, sum_text: str | None) -> str:
        """Return a sum of measures, or that of the file, in words with units."""
        from planter.mechanism.optimisation import StatedGoal

        return StatedGoal.read(self._machine, sum_text).describe()

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


class MotionView(MechanismView):
    """A mechanism that moves freely, over the time that its file says."""

    exports = (Export("report", "page, figures and table of the motion", ("simulate",)),)

    def __init__(self, file: MechanismFile) -> None:
        super().__init__(file)
        self.until = file.until
        self.span_words = f" over 0..{self.until:g} s"
        self._latest_motion: tuple[dict[str, float], MechanismMotion] | None = None

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Return its bodies over the time."""
        from planter.mechanism.drawing import build_motion_scene

        return [build_motion_scene(self.name, self._compute_motion(values), self.file)]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Return largest and least values of the first results that change."""
        return list(self._list_extremes(values))

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """Return the limits of the file over its motion."""
        from planter.mechanism.optimisation import list_limit_checks

        result = self._compute_motion(values).result
        return list_limit_checks(self._machine, result.holds or ())

    def portable(self, model: str) -> Portable:
        """Raise InputError: a page without a server computes cycles."""
        raise InputError(
            f"{self.name} moves freely: a page without a server has no integrator, "
            f"`planter studio FILE` has"
        )

    @cached_property
    def _motions(self) -> Motions:
        from planter.mechanism.motion_response import Motions

        return Motions(self.file, self.until)

    @cached_property
    def _machine(self) -> Machine:
        from planter.mechanism.machines import build_free_machine

        return build_free_machine(self.file, self.until, self._motions)

    def _find_extremes(self, values: Values) -> Mapping[str, Extreme]:
        return self._compute_motion(values).result.quantities

    def _compute_motion(self, values: Values) -> MechanismMotion:
        from planter.mechanism.machines import build_free_machine
        from planter.mechanism.motion import compute_motion
        from planter.mechanism.motion_response import TOLERANCE
        from planter.mechanism.optimisation import judge_motion

        if self._latest_motion is None or self._latest_motion[0] != dict(values):
            file = self._with_values(values)
            steps: list[MotionStep] = []
            dynamics = self._motions.dynamics.with_data(file.data())
            motion = compute_motion(dynamics, self.until, MOMENTS, TOLERANCE, steps=steps)
            if file.measure_limits:
                self._motions.record(file.data(), steps)
                motion = judge_motion(motion, build_free_machine(file, motions=self._motions))
            self._latest_motion = dict(values), motion
        return self._latest_motion[1]


def build_scene(thing: object) -> Scene | None:
    """Return the motion of a cycle, None of anything else."""
    from planter.mechanism.drawing import build_cycle_scene
    from planter.mechanism.model import MechanismCycle

    return (
        build_cycle_scene(thing.machine.name, thing) if isinstance(thing, MechanismCycle) else None
    )


def open_view(source: str, changes: Values) -> MechanismView:
    """Return the mechanism in a file. Raises InputError if it moves freely without an end."""
    from planter.mechanism.file import load

    file = load(source, changes)
    return MechanismView(file) if file.is_driven else MotionView(file)
