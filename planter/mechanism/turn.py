"""`planter turn`: every quantity of a machine over a turn, the works, and the laws that it must obey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.engine.machine import Machine
from planter.engine.machine import Quantity as Described
from planter.files import units
from planter.kernels import Array
from planter.mechanism import lifting
from planter.mechanism.model import Model
from planter.mechanism.optimisation import evaluate_limits
from planter.mechanism.periodicity import Periodicity, periodicity
from planter.mechanism.results import Law, Quantity
from planter.mechanism.results import Turn as Result
from planter.numerics.angles import turn_deg
from planter.numerics.extremes import first_extreme


@dataclass(frozen=True)
class Turn:
    """A turn: samples of all results in shown units (n,) by key, and what is read from them.

    `ends` are the results at the end of the turn by key; `places` (n,) [m] are those of the bodies' points; a turn
    takes `seconds`.
    """

    machine: Machine
    angles_deg: Array
    columns: dict[str, Array]
    ends: dict[str, float]
    places: dict[str, Array]
    seconds: float
    result: Result

    @property
    def repeats(self) -> bool:
        """Whether it ends in the state in which it began."""
        return not self.result.not_repeating


def turn(model: Model, samples: int | None = None) -> Turn:
    """Return a cycle of a machine in `samples` equal steps, the file's own without.

    Means are those of the samples, by the trapezoidal rule where an angle gains whole turns; works [J] integrate what
    is told in W over the time of a turn. What does not end the turn as it began has neither, and a warning says so.
    Raises ComputationError as the model does.
    """
    machine, angles = model.machine, model.list_angles(samples)
    found = model(angles)
    columns = {q.key: found[q.name] / q.factor for q in machine.results}
    repeats = periodicity(model, angles, found)
    holds = evaluate_limits(machine, repeats.changes) if machine.limits else None
    result = Result(
        machine=machine.name,
        samples=len(angles),
        quantities={q.key: describe_quantity(q, columns[q.key], angles, repeats) for q in machine.results},
        work=_works(model, found, repeats),
        laws=_laws(model, found),
        warnings=[
            *repeats.warnings(float(np.degrees(machine.turn))),
            *lifting.warnings(model, angles, found, not repeats.changes),
        ],
        repeats_after_turns=repeats.turns,
        not_repeating=repeats.changes,
        holds=holds,
        met=None if holds is None else all(hold.met for hold in holds),
    )
    return Turn(machine, np.degrees(angles), columns, repeats.end, model.places(angles), _seconds(model), result)


def describe_quantity(quantity: Described, values: Array, angles: Array, repeats: Periodicity) -> Quantity:
    """Return extremes, mean and root mean square of samples (n,) in the key's unit, of a cycle at angles (n,) [rad]."""
    low, high = (turn_deg(float(angles[first_extreme(angles, values, sign)])) for sign in (-1, 1))
    is_averaged = quantity.key not in repeats.changes
    mean, square = _means(values, repeats.end[quantity.key]) if is_averaged else (None, None)
    return Quantity(
        unit=units.unit(quantity.key),
        min=float(values.min()),
        max=float(values.max()),
        mean=mean,
        rms=None if square is None else float(np.sqrt(square)),
        min_deg=low,
        max_deg=high,
        axes=quantity.axes,
    )


def _means(values: Array, end: float) -> tuple[float, float]:
    """Mean and mean square of values (n,) by the trapezoidal rule with the value at the end of the turn.

    Only an angle that gains whole turns ends elsewhere than it began; otherwise the rule is the mean of the samples.
    """
    gains = abs(end - values[0]) > 1.0
    last = (end - values[0], end**2 - values[0] ** 2) if gains else (0.0, 0.0)
    count = len(values)
    return float(values.mean() + last[0] / (2 * count)), float((values**2).mean() + last[1] / (2 * count))


def _seconds(model: Model) -> float:
    return model.machine.turn / abs(model.speed) if model.speed else np.inf


def _works(model: Model, found: dict[str, Array], repeats: Periodicity) -> dict[str, float | None]:
    """Return the work [J] of each power over the time of a cycle, None where it does not repeat."""
    if model.speed == 0:
        return {}
    return {
        f"{q.name.removeprefix('P_')}_J": None
        if q.key in repeats.changes
        else _seconds(model) * float(found[q.name].mean())
        for q in model.machine.results
        if q.unit == "W"
    }


def _laws(model: Model, found: dict[str, Array]) -> list[Law]:
    """Return the laws of mechanics with their violations, and that friction has one state alone."""
    laws = [
        Law(q.meaning, float(np.abs(found[q.name]).max()), q.unit) for q in model.machine.quantities if q.role == "law"
    ]
    many = [q for q in model.machine.quantities if q.role == "states"]
    return laws + [Law(f"{q.meaning}, beyond one", float(found[q.name].max()) - 1, "1") for q in many]
