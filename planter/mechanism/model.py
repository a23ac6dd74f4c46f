"""A machine along its angle: all quantities by name, loops closed, points of its bodies, and whether its cycle repeats.

Means and works are those of any cycle only if the machine ends a cycle in the state in which it began it. Every
quantity is compared with itself a cycle later, at every sample, so that a coincidence at one angle does not count.
Angles are compared modulo 2 pi.
"""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.response import DesignPoint, Response
from planter.errors import ComputationError
from planter.files import units
from planter.kernels import Array, Kernel
from planter.mechanism.results import Warned
from planter.numerics.arrays import TURN


class Model:
    """A machine along its angle: all quantities by name, at its values or at others ``data`` (v,); SI and radians.

    >>> import numpy as np
    >>> from planter import load_mechanism
    >>> machine = Model(load_mechanism("wang2017"))
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
        still = replace(self.machine, moved=(), lower=np.empty(0), upper=np.empty(0))  # slopes are not asked for
        self._response, self._kernels = Response(still), dict[str, Kernel]()

    @property
    def speed(self) -> float:
        """The speed of the drive [rad/s]."""
        return float(self.machine.data[self.machine.speed])

    def list_angles(self, samples: int | None = None) -> Array:
        """Return the angles (n,) [rad] of a cycle in equal steps, as many as the file says unless `samples` does."""
        count = self.machine.samples if samples is None else samples
        return self.machine.turn * np.arange(count) / count

    def __call__(self, angles: Array) -> dict[str, Array]:
        """Return all quantities (n,) by name at angles (n,) [rad].

        Raises ComputationError where loops do not close, or where forces are not determined.
        """
        angles = np.asarray(angles, dtype=float)
        values = self._response.values(self._point, angles)
        self._response.check(values, angles)
        return {q.name: row for q, row in zip(self.machine.quantities, values, strict=True)}

    def results(self, angles: Array) -> dict[str, Array]:
        """Return the results (n,) at angles (n,) [rad] by key, each in the unit that its key ends in.

        Raises ComputationError as a call does.
        """
        values = self(angles)
        return {q.key: values[q.name] / q.factor for q in self.machine.results}

    def places(self, angles: Array) -> dict[str, Array]:
        """Return where the points of all bodies are (n,) [m] at angles (n,) [rad], by name.

        Components are along the axes of the world. Names are ``x_BODY__POINT`` and its like. Machines without bodies of
        their own statement have none.
        """
        return self.evaluate("places", angles)

    def evaluate(self, name: str, angles: Array) -> dict[str, Array]:
        """Return the values (n,) [SI] of a further function of the machine at angles (n,) [rad] by name.

        Functions are "places", "followers" and "meshes"; the result is empty for one that the machine lacks. Raises
        ComputationError if loops do not close.
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


SHARE, FLOOR = 1e-7, 1e-12
"""A quantity repeats if it changes by less than this share of the largest value in its unit, or this much in SI."""
ASIDE = 1e-9
"""How far beside an angle its sides are looked at [rad]: more than rounding of angles, less than a change shows."""
MOST_TURNS = 60
"""Turns after which a repetition is looked for."""
COMPARED = 24
"""Samples at which a repetition after several turns is looked for."""
MOST_NAMED = 4
"""Quantities that a warning names; all stand in `not_repeating`."""


@dataclass(frozen=True)
class Periodicity:
    """How a mechanism's results at a turn's samples differ from those a turn later.

    `end` holds the results at the end of the turn by key, in its unit; `changes` the largest difference [shown unit] by
    the key of each quantity that does not repeat; `turns` is after how many turns all of them do, None if after none of
    the first MOST_TURNS. Where the next turn cannot be computed `obstacle` says why, and differences are None.
    """

    end: dict[str, float]
    changes: dict[str, float | None]
    turns: int | None
    obstacle: str = ""

    def warnings(self, angle_deg: float) -> list[Warned]:
        """Return one sentence if the turn, which ends at an angle, does not end as it began."""
        if not self.changes:
            return []
        again = (
            f"it repeats after {self.turns} turns" if self.turns else f"it does not repeat within {MOST_TURNS} turns"
        )
        message = (
            f"the turn does not end in the state in which it began: {self.obstacle or self._listed}; means, root mean "
            "squares and works of what does not repeat are not given, and its extremes are those of this turn alone"
            + ("" if self.obstacle else f"; {again}")
        )
        return [Warned(name="does_not_repeat", angle_deg=angle_deg, message=message)]

    @property
    def _listed(self) -> str:
        """The first quantities that do not repeat, with what they change by."""
        changes = [(key, change) for key, change in self.changes.items() if change is not None]
        listed = ", ".join(f"{describe_change(key, change)}" for key, change in changes[:MOST_NAMED])
        more = len(changes) - MOST_NAMED
        return f"{listed} and {more} more" if more > 0 else listed


def describe_change(key: str, change: float) -> str:
    """What a quantity changes by in a turn, in words."""
    return f"{key.removesuffix(units.suffix(key))} differs by {change:.4g} {units.unit(key)}".rstrip()


def periodicity(model: Model, angles: Array, results: dict[str, Array], search: bool = True) -> Periodicity:
    """Compare results (n,) by name at angles (n,) [rad] from zero on, in equal steps, with those of the next turn.

    Without `search` it is not looked for after how many turns all repeats.
    """
    quantities = model.machine.results
    try:
        later = model(angles + model.machine.turn)
    except ComputationError as error:
        reason = f"the next one cannot be computed ({error.message})"
        return Periodicity({}, {q.key: None for q in quantities}, None, reason)
    changes: dict[str, float | None] = {
        q.key: change / q.factor for q, change in _find_changes(model, angles, results, later).items()
    }
    end = {q.key: float(later[q.name][0] / q.factor) for q in quantities}
    turns = 1 if not changes else _find_repetition(model, angles, results) if search else None
    return Periodicity(end, changes, turns)


def require_repeating(machine: Machine, names: Collection[str], samples: int | None = None) -> None:
    """Raise ComputationError if a quantity does not repeat after a turn, which then gives no mean or closed curve."""
    if not names:
        return
    model = Model(machine)
    angles = model.list_angles(samples)
    repeats = periodicity(model, angles, model(angles), search=False)
    for key in (machine.find_quantity(part).key for name in names for part in machine.list_parts(name)):
        if key in repeats.changes:
            change = repeats.changes[key]
            reason = repeats.obstacle if change is None else describe_change(key, change)
            raise ComputationError(
                f"{machine.name}: a turn does not end in the state in which it began ({reason}), so that it gives "
                "neither a mean nor a closed curve"
            )


def _find_changes(
    model: Model, angles: Array, results: dict[str, Array], later: dict[str, Array]
) -> dict[Quantity, float]:
    """Return the results that are others later, beyond rounding of the largest value in their unit, with by how much.

    At an angle where a result jumps rounding decides on which side it is taken: there the nearer side counts.
    """
    sizes: dict[str, float] = {}
    for q in model.machine.results:
        sizes[q.unit] = max(sizes.get(q.unit, 0.0), float(np.abs(results[q.name]).max()))
    limits = {unit: max(SHARE * (1.0 if unit == "rad" else size), FLOOR) for unit, size in sizes.items()}
    sides = [results]

    def change(q: Quantity) -> float:
        nearest = np.min([_differences(q.unit, later[q.name], side[q.name]) for side in sides], axis=0)
        return float(nearest.max())

    if any(change(q) > limits[q.unit] for q in model.machine.results):
        with suppress(ComputationError):  # which may begin or end there
            sides += [model(angles - ASIDE), model(angles + ASIDE)]
    changes = {q: change(q) for q in model.machine.results}
    return {q: size for q, size in changes.items() if size > limits[q.unit]}


def _differences(unit: str, later: Array, before: Array) -> Array:
    """Return the sizes (n,) of changes, of angles beyond whole turns."""
    change = later - before
    sizes: Array = np.abs(change - TURN * np.round(change / TURN) if unit == "rad" else change)
    return sizes


def _find_repetition(model: Model, angles: Array, results: dict[str, Array]) -> int | None:
    """Return the least number of turns after which all results are what they were, None if there is none."""
    chosen = np.unique(np.linspace(0, len(angles) - 1, min(COMPARED, len(angles))).astype(np.int64))
    some, before = angles[chosen], {name: values[chosen] for name, values in results.items()}
    for turns in range(2, MOST_TURNS + 1):
        try:
            later = model(some + model.machine.turn * turns)
        except ComputationError:
            continue
        if not _find_changes(model, some, before, later):
            return turns
    return None
