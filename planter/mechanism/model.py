"""A machine along its angle: all quantities by name, loops closed, points of its bodies, and
whether its cycle repeats.

Means and works are those of any cycle only if the machine ends a cycle in the state in which it
began it. Every quantity is compared with itself a cycle later, at every sample, so that a
coincidence at one angle does not count. Angles are compared modulo 2 pi.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.response import DesignPoint, MachineResponse
from planter.engine.rows import COMPARED, FLOOR, SHARE
from planter.errors import ComputationError
from planter.files import units
from planter.files.record import build_frame
from planter.kernels import Array, Kernel
from planter.measured.sensor_curve import SensorSignal
from planter.mechanism.results import MechanismCycleResult, MechanismWarning
from planter.numerics.arrays import TURN

if TYPE_CHECKING:
    from pandas import DataFrame

SIDE_STEP = 1e-9
"""Distance of the one-sided values from an angle [rad]: above the rounding of angles, below any
visible change.
"""
MOST_TURNS = 60
"""Largest number of cycles after which a repetition is looked for."""
MOST_NAMED = 4
"""Quantities that a warning names; `not_repeating` has all."""


class Model:
    """A machine along its angle: all quantities by name, at its values or at others ``data`` (v,); SI
    and radians.

    >>> import numpy as np
    >>> from planter import load_machine
    >>> machine = Model(load_machine("wang2017"))
    >>> machine.speed == 40 * 2 * np.pi / 60
    True
    >>> np.degrees(machine.list_angles(4))
    array([  0.,  90., 180., 270.])
    >>> machine(np.radians([0.0, 90.0]))["x_tip"].round(4)
    array([-0.1177, -0.1796])
    >>> machine.results(np.radians([0.0, 90.0]))["tip_x_mm"].round(1)
    array([-117.7, -179.6])
    """

    def __init__(self, machine: Machine, data: Array | None = None) -> None:
        self.machine = machine if data is None else machine.with_data(data)
        fixed = replace(
            self.machine, moved=(), lower=np.empty(0), upper=np.empty(0)
        )  # no slopes in the design
        self._response, self._kernels = MachineResponse(fixed), dict[str, Kernel]()

    @property
    def speed(self) -> float:
        """The speed of the drive [rad/s]."""
        return float(self.machine.data[self.machine.speed])

    def list_angles(self, samples: int | None = None) -> Array:
        """Return the angles (n,) [rad] of a cycle in equal steps, as many as the file says unless
        `samples` does.
        """
        return self.machine.list_angles(samples)

    def __call__(self, angles: Array) -> dict[str, Array]:
        """Return all quantities (n,) by name at angles (n,) [rad].

        Raises ComputationError where loops do not close, or where forces are not determined.
        """
        angles = np.asarray(angles, dtype=float)
        values = self._response.values(self._point, angles)
        self._response.check(values, angles)
        return {q.name: row for q, row in zip(self.machine.quantities, values, strict=True)}

    def results(self, angles: Array) -> dict[str, Array]:
        """Return the results (n,) at angles (n,) [rad] by key, each in the unit that its key ends
        in.

        Raises ComputationError as a call does.
        """
        values = self(angles)
        return {q.key: values[q.name] / q.factor for q in self.machine.results}

    def places(self, angles: Array) -> dict[str, Array]:
        """Return coordinates (n,) [m] of the points of all bodies at angles (n,) [rad], by name.

        Components are along the axes of the world. Names are ``x_BODY__POINT`` and its like. The
        result is empty for a machine whose statement has no bodies.
        """
        return self.evaluate("places", angles)

    def evaluate(self, name: str, angles: Array) -> dict[str, Array]:
        """Return the values (n,) [SI] of a further function of the machine at angles (n,) [rad] by
        name.

        Functions are "places", "followers", "meshes" and "elements"; the result is empty for one that the
        machine lacks. Raises ComputationError if loops do not close.
        """
        stage = self.machine.stages.get(name)
        if stage is None:
            return {}
        kernel = self._kernels.setdefault(name, Kernel(stage.function, lanes=["phi", "q"]))
        q = self._response.coordinates(self.machine.data, angles)
        rows = kernel(phi=angles, d=self.machine.data, h=self._point.h, q=q)["y"]
        return {quantity.name: row for quantity, row in zip(stage.quantities, rows, strict=True)}

    @cached_property
    def _point(self) -> DesignPoint:
        return self._response.at_data(self.machine.data)


@dataclass(frozen=True)
class MechanismCycle:
    """A cycle: samples of all results in display units (n,) by key, and its result.

    `ends` are the results at the end of the cycle by key; `places` (n,) [m] the coordinates of the
    bodies' points; a cycle takes `seconds`. `measured` is what the sensor sees, if the file has
    [measurement].
    """

    machine: Machine
    angles_deg: Array
    columns: dict[str, Array]
    ends: dict[str, float]
    places: dict[str, Array]
    seconds: float
    result: MechanismCycleResult
    measured: SensorSignal | None = None
    shapes: Mapping[str, Array] = field(default_factory=dict)
    """Values (n,) [SI] of the functions `elements` and `meshes`, for drawings."""

    @property
    def repeats(self) -> bool:
        """Whether it ends in the state in which it began."""
        return not self.result.not_repeating

    def table(self) -> dict[str, Array]:
        """Return the angle, all results, and what the sensor sees, as columns (n,) [in the units of
        the keys].
        """
        angle = {f"{self.machine.angle}_deg": self.angles_deg}
        return angle | self.columns | ({} if self.measured is None else self.measured.column)

    def to_frame(self) -> DataFrame:
        """Return the columns as a table of pandas.

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        return build_frame(self.table())

    def show(self) -> Any:
        """Return a notebook widget that animates the machine.

        Raises InputError if anywidget is missing.
        """
        from planter.report.animation import show_object

        return show_object(self if self.machine.subject is None else self.machine.subject)

    def _repr_html_(self) -> str:
        return self.result._repr_html_()


@dataclass(frozen=True)
class Periodicity:
    """The differences of a mechanism's results between a cycle and the next one.

    `end` holds the results at the end of the cycle by key, in its unit; `changes` the largest
    difference [display unit] by the key of each quantity that does not repeat; all quantities
    repeat after `turns` cycles, None if they do not within MOST_TURNS. If the next cycle cannot be
    computed, `obstacle` says why, and differences are None.
    """

    end: dict[str, float]
    changes: dict[str, float | None]
    turns: int | None
    obstacle: str = ""

    def list_warnings(
        self, phi_deg: float, expected: Collection[str] = ()
    ) -> list[MechanismWarning]:
        """Return one warning if the cycle, which ends at an angle, does not end as it began.

        Quantities whose keys are `expected` to change need none.
        """
        if not self.changes.keys() - set(expected):
            return []
        after = (
            f"repeats after {self.turns} turns"
            if self.turns
            else f"does not repeat within {MOST_TURNS} turns"
        )
        changes = self.obstacle or self._describe_changes()
        message = (
            f"the turn does not end in the state in which it began: {changes}; means, root mean "
            f"squares and works of "
            "what does not repeat are not given, and its extremes are those of this "
            f"turn alone{'' if self.obstacle else f'; it {after}'}"
        )
        return [MechanismWarning(name="does_not_repeat", phi_deg=phi_deg, message=message)]

    def _describe_changes(self) -> str:
        """Return the first quantities that do not repeat, with their changes."""
        changes = [(key, change) for key, change in self.changes.items() if change is not None]
        text = ", ".join(format_change(key, change) for key, change in changes[:MOST_NAMED])
        more = len(changes) - MOST_NAMED
        return f"{text} and {more} more" if more > 0 else text


def format_change(key: str, change: float) -> str:
    """Return the change of a quantity in a cycle as text."""
    return (
        f"{key.removesuffix(units.unit_suffix(key))} differs by {change:.4g} "
        f"{units.display_unit(key)}"
    ).rstrip()


def compare_cycles(
    model: Model, angles: Array, results: Mapping[str, Array], search: bool = True
) -> Periodicity:
    """Compare results (n,) by name at angles (n,) [rad] from zero on, in equal steps, with those of
    the next cycle.

    `search` looks for the number of cycles after which all results repeat.
    """
    quantities = model.machine.results
    try:
        later = model(angles + model.machine.turn)
    except ComputationError as error:
        reason = f"the next one cannot be computed ({error.message})"
        return Periodicity({}, {q.key: None for q in quantities}, None, reason)
    differences = _find_changes(model, angles, results, later)
    changes: dict[str, float | None] = {
        q.key: change / q.factor for q, change in differences.items()
    }
    end = {q.key: float(later[q.name][0] / q.factor) for q in quantities}
    turns = 1 if not changes else _find_repetition(model, angles, results) if search else None
    return Periodicity(end, changes, turns)


def require_repeating(machine: Machine, names: Collection[str], samples: int | None = None) -> None:
    """Raise ComputationError if a quantity does not repeat after a cycle, so that it has no mean or
    closed curve.
    """
    if not names:
        return
    model = Model(machine)
    angles = model.list_angles(samples)
    repeats = compare_cycles(model, angles, model(angles), search=False)
    for key in (
        machine.find_quantity(part).key for name in names for part in machine.list_parts(name)
    ):
        if key in repeats.changes:
            change = repeats.changes[key]
            reason = repeats.obstacle if change is None else format_change(key, change)
            raise ComputationError(
                f"{machine.name}: a turn does not end in the state in which it began ({reason}), "
                f"so that it gives "
                "neither a mean nor a closed curve"
            )


def _find_changes(
    model: Model, angles: Array, results: Mapping[str, Array], later: Mapping[str, Array]
) -> dict[Quantity, float]:
    """Return results that differ a cycle later, beyond rounding of the largest value in their unit,
    with the change.

    At an angle where a result jumps, rounding decides on which side it is evaluated: there the
    nearer side counts.
    """
    sizes: dict[str, float] = {}
    for q in model.machine.results:
        sizes[q.unit] = max(sizes.get(q.unit, 0.0), float(np.abs(results[q.name]).max()))
    limits = {
        unit: max(SHARE * (1.0 if unit == "rad" else size), FLOOR) for unit, size in sizes.items()
    }
    sides = [results]

    def find_change(q: Quantity) -> float:
        nearest = np.min(
            [_measure_differences(q.unit, later[q.name], side[q.name]) for side in sides], axis=0
        )
        return float(nearest.max())

    if any(find_change(q) > limits[q.unit] for q in model.machine.results):
        with suppress(ComputationError):  # a side angle may lie beyond the range of a loop or a law
            sides += [model(angles - SIDE_STEP), model(angles + SIDE_STEP)]
    changes = {q: find_change(q) for q in model.machine.results}
    return {q: size for q, size in changes.items() if size > limits[q.unit]}


def _measure_differences(unit: str, later: Array, before: Array) -> Array:
    """Return the sizes (n,) of changes; those of angles without whole turns."""
    change = later - before
    sizes: Array = np.abs(change - TURN * np.round(change / TURN) if unit == "rad" else change)
    return sizes


def _find_repetition(model: Model, angles: Array, results: Mapping[str, Array]) -> int | None:
    """Return the number of cycles after which all results repeat for the first time, or None."""
    chosen = np.unique(np.linspace(0, len(angles) - 1, min(COMPARED, len(angles))).astype(np.int64))
    compared, before = angles[chosen], {name: values[chosen] for name, values in results.items()}
    for turns in range(2, MOST_TURNS + 1):
        try:
            later = model(compared + model.machine.turn * turns)
        except ComputationError:
            continue
        if not _find_changes(model, compared, before, later):
            return turns
    return None
