"""The cycle of a machine: every quantity, works, laws, contacts that lift off, and warnings for the designer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.engine.machine import Machine, check_samples
from planter.engine.machine import Quantity as Described
from planter.engine.summary import Summary, summarise
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.kernels import Array
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import Model, Periodicity, periodicity
from planter.mechanism.optimisation import evaluate_limits
from planter.mechanism.results import AngleValues, Law, MachineValidation, Quantity, Warned
from planter.mechanism.results import Turn as Result
from planter.numerics import extrema
from planter.numerics.arrays import Flags, to_degrees
from planter.numerics.extrema import index_first_extremum


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
            *warnings(model, angles, found, not repeats.changes),
        ],
        repeats_after_turns=repeats.turns,
        not_repeating=repeats.changes,
        holds=holds,
        met=None if holds is None else all(hold.met for hold in holds),
    )
    return Turn(machine, np.degrees(angles), columns, repeats.end, model.places(angles), _seconds(model), result)


def describe_quantity(quantity: Described, values: Array, angles: Array, repeats: Periodicity) -> Quantity:
    """Return extremes, mean and root mean square of samples (n,) in the key's unit, of a cycle at angles (n,) [rad]."""
    low, high = (to_degrees(float(angles[index_first_extremum(angles, values, sign)])) for sign in (-1, 1))
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


CLOSE = 1e-10
"""How close the angle of a change is looked for [rad]."""


def warnings(model: Model, angles: Array, found: dict[str, Array], repeats: bool = True) -> list[Warned]:
    """A warning for every stretch of a turn in which a contact would have to pull.

    `angles` (n,) [rad] go once round in equal steps, `found` are the results there; `repeats` says whether the turn
    ends as it began. A stretch between two samples is found where the force has a hollow there.
    """
    pushing = [quantity.name for quantity in model.machine.quantities if quantity.is_push]
    return [warned for name in pushing for warned in _warned(model, name, angles, found[name], repeats)]


def _warned(model: Model, name: str, angles: Array, values: Array, repeats: bool) -> Iterator[Warned]:
    lowest = extrema.find_minimum(lambda at: model(at)[name], angles, closed=repeats)
    if lowest.value >= 0:
        return
    what = f"{name} ({model.machine.find_quantity(name).meaning}) falls to {lowest.value:.4g} N"
    places = np.append(angles, lowest.place % model.machine.turn)
    order = np.argsort(places)
    places, pulls = places[order], np.append(values, lowest.value)[order] < 0
    if pulls.all():
        yield _told(f"{what}: the contact would have to pull all over the turn", 0.0)
        return
    for low, high in _stretches(model, name, places, pulls, repeats):
        yield _told(
            f"{what}: the contact would have to pull from {low:.6g} to {high:.6g} deg, so it lifts off there and "
            "nothing told beyond holds",
            low,
        )


def _stretches(model: Model, name: str, places: Array, pulls: Flags, repeats: bool) -> Iterator[tuple[float, float]]:
    """Where stretches of places that pull begin and end [deg]; one may pass the end of a turn that repeats."""
    before = np.roll(pulls, 1)
    before[0] &= repeats
    for begin in np.flatnonzero(pulls & ~before).tolist():
        length = int(np.argmin(np.append(pulls[begin:], pulls[:begin] if repeats else False)))
        low = 0.0 if begin == 0 and not repeats else np.degrees(_change(model, name, places, begin))
        ends = begin + length == len(places) and not repeats
        yield low, np.degrees(model.machine.turn if ends else _change(model, name, places, begin + length))


def _change(model: Model, name: str, places: Array, k: int) -> float:
    """Return the angle in a cycle at which the force changes sign between a place and the one before it, all round."""
    from scipy.optimize import brentq

    turn, high, low = model.machine.turn, float(places[k % len(places)]), float(places[(k - 1) % len(places)])
    found = brentq(lambda at: float(model(np.array([at]))[name][0]), low - turn * (low > high), high, xtol=CLOSE)
    return float(found) % turn


def _told(message: str, angle: float) -> Warned:
    return Warned(name="contact_would_pull", angle_deg=float(angle), message=message)


def simulate(machine: Machine, samples: int | None = None, at_deg: Sequence[float] = ()) -> Turn:
    """Return the cycle of a machine in `samples` equal steps, the file's own without, and results at angles [deg].

    Raises InputError for a number of samples out of range, or an angle that is not finite; ComputationError as the
    model does.
    """
    check_samples(samples)
    check_angles(at_deg)
    model = Model(machine)
    cycle = turn(model, samples)
    designer, warnings = _summarise(model, cycle)
    at = [
        AngleValues(float(angle), {key: float(values[0]) for key, values in model.results(np.radians([angle])).items()})
        for angle in at_deg
    ]
    warnings = [*cycle.result.warnings, *warnings]
    return replace(cycle, result=replace(cycle.result, at=at or None, designer=designer, warnings=warnings))


def check_angles(at_deg: Sequence[float]) -> None:
    """Raise InputError for an angle that is not finite."""
    if bad := [angle for angle in at_deg if not np.isfinite(angle)]:
        raise InputError(f"--at = {bad[0]} is not allowed: it must be a finite angle in deg")


def _summarise(model: Model, cycle: Turn) -> tuple[Summary | None, list[Warned]]:
    """Return the designer's summary, or a warning where a quantity has a pole between samples."""
    try:
        return summarise(model.machine, cycle.result.not_repeating), []
    except ComputationError as error:
        message = f"there is no summary for the designer: {error.message}"
        return None, [Warned(name="no_summary", angle_deg=0.0, message=message)]


def validate(machine: Machine) -> MachineValidation:
    """Return what a designer should know of a machine whose file has passed every check: limits and warnings.

    Raises ComputationError if its loops do not close at some angle of the cycle.
    """
    cycle = turn(Model(machine)).result
    return MachineValidation(
        machine=machine.name, valid=True, design=list(machine.design_names), holds=cycle.holds, met=cycle.met,
        warnings=[*_warn_of_bounds(machine), *cycle.warnings],
    )  # fmt: skip


def validate_motion(mechanism: MechanismFile) -> MachineValidation:
    """Return what a designer should know of a mechanism that moves by itself, at its start.

    Raises ComputationError if no start near the stated one satisfies its constraints.
    """
    dynamics = Dynamics(mechanism)
    start = dynamics.start()
    names = [dynamics.names[index] for index in dynamics.changed(start)]
    message = "the stated start breaks the constraints: the motion begins at the nearest one that satisfies them"
    return MachineValidation(
        machine=mechanism.name, valid=True, design=[],
        warnings=[Warned(name=name, message=message) for name in names],
    )  # fmt: skip


def _warn_of_bounds(machine: Machine) -> Iterator[Warned]:
    """Yield a warning for each value of the design that lies outside its bounds."""
    for index, lower, upper in zip(machine.moved, machine.lower, machine.upper, strict=True):
        value, number = machine.values[index], machine.data[index]
        if not lower <= number <= upper:
            ends = f"[{lower / value.factor:g}, {upper / value.factor:g}]"
            message = f"{value.path} = {number / value.factor:g} lies outside its bounds {ends}"
            yield Warned(name="design", message=message)
