"""The cycle of a machine: every quantity, works, laws, contacts that lift off, and the checks of
`planter simulate --check`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import scipy

from planter.engine.machine import HasMachine, Machine, Quantity, check_samples, to_machine
from planter.engine.summary import CycleSummary, QuantityPeak
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.kernels import Array, Flags
from planter.measured.sensor_curve import SensorSignal, measure_cycle
from planter.measured.sensor_view import find_sensor_view
from planter.mechanism.extension import MachineExtension, find_extension
from planter.mechanism.model import MechanismCycle, Model, Periodicity, compare_cycles
from planter.mechanism.optimisation import evaluate_limits
from planter.mechanism.results import (
    MachineValidation,
    MechanismCycleResult,
    MechanismLawResult,
    MechanismWarning,
    QuantityStatistics,
)
from planter.numerics import extrema
from planter.numerics.arrays import to_degrees
from planter.numerics.extrema import ExtremePoint
from planter.progress import name_step

if TYPE_CHECKING:
    pass

ANGLE_TOLERANCE = 1e-10
"""Accuracy of the angle at which a contact force changes its sign [rad]."""


@name_step("computing the cycle")
def compute_cycle(model: Model, samples: int | None = None) -> MechanismCycle:
    """Return a cycle of a machine in `samples` equal steps, as many as its file says unless they
    are given.

    Extremes are true ones, means and works [J] integrals over the cycle. What does not end the
    cycle as it began has neither mean nor work; of what has a pole extremes and mean are those of
    the samples. A warning says so. Raises ComputationError as the model does.
    """
    machine, angles = model.machine, model.list_angles(samples)
    values = model(angles)
    columns = {q.key: values[q.name] / q.factor for q in machine.results}
    repeats = compare_cycles(model, angles, values)
    limits = evaluate_limits(machine, repeats.changes) if machine.limits else None
    extension = find_extension(machine)
    designer, warnings = _summarise(extension, repeats.changes)
    peaks = {peak.name: peak for peak in designer.peaks} if designer else {}
    quantities = {
        q.key: read_peak(q, peaks[q.name])
        if q.name in peaks
        else compute_statistics(q, columns[q.key], angles, repeats)
        for q in machine.results
    }
    seconds = machine.turn / abs(model.speed) if model.speed else np.inf
    result = MechanismCycleResult(
        machine=machine.name,
        samples=len(angles),
        quantities=quantities,
        work=_compute_works(model, quantities, seconds),
        laws=list(_check_laws(machine, values)),
        warnings=[
            *repeats.list_warnings(float(np.degrees(machine.turn)), extension.advancing),
            *list_lift_offs(model, angles, values, not repeats.changes, peaks),
            *warnings,
        ],
        repeats_after_turns=repeats.turns,
        not_repeating=repeats.changes,
        holds=limits,
        met=None if limits is None else all(limit.met for limit in limits),
        designer=designer,
    )
    shapes = model.evaluate("elements", angles) | model.evaluate("meshes", angles)
    places = model.places(angles)
    return MechanismCycle(
        machine, np.degrees(angles), columns, repeats.end, places, seconds, result, shapes=shapes
    )


def read_peak(quantity: Quantity, peak: QuantityPeak) -> QuantityStatistics:
    """Return true extremes and means of a quantity over a cycle, in the key's unit."""
    return QuantityStatistics(
        unit=peak.unit,
        min=peak.min,
        max=peak.max,
        mean=peak.mean,
        rms=peak.rms,
        min_deg=peak.min_phi_deg,
        max_deg=peak.max_phi_deg,
        axes=quantity.axes,
    )


def compute_statistics(
    quantity: Quantity, values: Array, angles: Array, repeats: Periodicity
) -> QuantityStatistics:
    """Return extremes, mean and root mean square of samples (n,) in the key's unit, of a cycle at
    angles (n,) [rad].
    """
    low, high = (
        to_degrees(float(angles[extrema.index_first_extremum(angles, values, sign)]))
        for sign in (-1, 1)
    )
    is_averaged = quantity.key not in repeats.changes
    mean, square = _average(values, repeats.end[quantity.key]) if is_averaged else (None, None)
    return QuantityStatistics(
        unit=units.display_unit(quantity.key),
        min=float(values.min()),
        max=float(values.max()),
        mean=mean,
        rms=None if square is None else float(np.sqrt(square)),
        min_deg=low,
        max_deg=high,
        axes=quantity.axes,
    )


def _average(values: Array, end: float) -> tuple[float, float]:
    """Return mean and mean square of values (n,) by the trapezoidal rule with the value at the end
    of the cycle.

    Only an angle that gains whole turns has another value at the end; otherwise the rule is the
    mean of the samples.
    """
    gains = abs(end - values[0]) > 1.0
    last = (end - values[0], end**2 - values[0] ** 2) if gains else (0.0, 0.0)
    count = len(values)
    return float(values.mean() + last[0] / (2 * count)), float(
        (values**2).mean() + last[1] / (2 * count)
    )


def _compute_works(
    model: Model, quantities: Mapping[str, QuantityStatistics], seconds: float
) -> dict[str, float | None]:
    """Return the work [J] of each power over the time of a cycle, None if the power has no mean."""
    if model.speed == 0:
        return {}
    works: dict[str, float | None] = {}
    for q in model.machine.results:
        if q.unit == "W":
            mean = quantities[q.key].mean
            works[f"{q.name.removeprefix('P_')}_J"] = (
                None if mean is None else seconds * q.factor * mean
            )
    return works


def _check_laws(machine: Machine, values: Mapping[str, Array]) -> Iterator[MechanismLawResult]:
    """Yield the laws of mechanics with their violations, then that friction has a single state.

    The scale of a law is the largest quantity in its unit, or what the largest forces give:
    rounding is relative to it.
    """
    scales: dict[str, float] = defaultdict(float)
    for q in machine.quantities:
        if q.role == "result":
            scales[q.unit] = max(scales[q.unit], float(np.abs(values[q.name]).max()))
    for unit, way in (
        ("N m", "m"),
        ("W", "m/s"),
    ):  # a moment or power may vanish whose forces do not
        scales[unit] = max(scales[unit], scales["N"] * scales[way])
    for q in machine.quantities:
        if q.role == "law":
            scale = scales[q.unit] or 1.0
            yield MechanismLawResult(q.meaning, float(np.abs(values[q.name]).max()), q.unit, scale)
    for q in machine.quantities:
        if q.role == "states":
            yield MechanismLawResult(
                f"{q.meaning}, beyond one", float(values[q.name].max()) - 1, "1", 1.0
            )


def list_lift_offs(
    model: Model,
    angles: Array,
    values: Mapping[str, Array],
    repeats: bool = True,
    peaks: Mapping[str, QuantityPeak] | None = None,
) -> list[MechanismWarning]:
    """Return a warning for every interval of a cycle in which a contact would have to pull.

    `angles` (n,) [rad] are equal steps of a cycle, `values` the quantities there; `repeats` says
    whether the cycle ends as it began. An interval between two samples is found if the force has a
    minimum there; `peaks` are the true extremes that are already known.
    """
    warnings = []
    for quantity in model.machine.quantities:
        if not quantity.is_push:
            continue
        name, peak = quantity.name, (peaks or {}).get(quantity.name)
        if peak is None:
            lowest = extrema.find_minimum(partial(_evaluate, model, name), angles, closed=repeats)
        else:
            lowest = ExtremePoint(np.radians(peak.min_phi_deg), peak.min * quantity.factor)
        intervals = _describe_lift_off(model, name, angles, values[name], repeats, lowest)
        warnings += [
            MechanismWarning(name="contact_would_pull", phi_deg=float(angle), message=message)
            for angle, message in intervals
        ]
    return warnings


def _evaluate(model: Model, name: str, angles: Array) -> Array:
    """Return a quantity (n,) at angles (n,) [rad]."""
    return model(angles)[name]


def _describe_lift_off(
    model: Model,
    name: str,
    angles: Array,
    values: Array,
    repeats: bool,
    lowest: ExtremePoint,
) -> Iterator[tuple[float, str]]:
    """Yield the angle [deg] at which each interval of a negative contact force begins, and a
    message.
    """
    if lowest.value >= 0:
        return
    force = f"{name} ({model.machine.find_quantity(name).meaning}) falls to {lowest.value:.4g} N"
    places = np.append(angles, lowest.place % model.machine.turn)
    order = np.argsort(places)
    places, pulls = places[order], np.append(values, lowest.value)[order] < 0
    if pulls.all():
        yield 0.0, f"{force}: the contact would have to pull during the whole cycle"
        return
    for low, high in _find_intervals(model, name, places, pulls, repeats):
        interval = f"from {low:.6g} to {high:.6g} deg"
        yield (
            low,
            f"{force}: the contact would have to pull {interval}: it lifts off there, and no "
            f"later result holds",
        )


def _find_intervals(
    model: Model, name: str, places: Array, pulls: Flags, repeats: bool
) -> Iterator[tuple[float, float]]:
    """Yield begin and end [deg] of intervals that pull; one may pass the end of a cycle that
    repeats.
    """
    before = np.roll(pulls, 1)
    before[0] &= repeats
    for begin in np.flatnonzero(pulls & ~before).tolist():
        length = int(np.argmin(np.append(pulls[begin:], pulls[:begin] if repeats else False)))
        low = (
            0.0
            if begin == 0 and not repeats
            else np.degrees(_find_sign_change(model, name, places, begin))
        )
        ends = begin + length == len(places) and not repeats
        yield (
            low,
            np.degrees(
                model.machine.turn
                if ends
                else _find_sign_change(model, name, places, begin + length)
            ),
        )


def _find_sign_change(model: Model, name: str, places: Array, k: int) -> float:
    """Return the angle in a cycle at which the force changes sign between a place and the one
    before it, cyclically.
    """
    turn, high, low = (
        model.machine.turn,
        float(places[k % len(places)]),
        float(places[(k - 1) % len(places)]),
    )
    start = low - turn * (low > high)
    root = scipy.optimize.brentq(
        lambda at: float(model(np.array([at]))[name][0]), start, high, xtol=ANGLE_TOLERANCE
    )
    return float(root) % turn


def simulate_machine(
    machine: Machine | HasMachine,
    samples: int | None = None,
    at_deg: Sequence[float] = (),
    lift_mm: float | None = None,
) -> MechanismCycle:
    """Return the cycle of a machine with its summary for the designer, and results at single angles
    [deg].

    With `lift_mm`, the module of its teeth, the assumptions of a model that has some are relaxed
    one by one. Raises InputError for a number of samples out of range, an angle that is not finite,
    or a model whose assumptions cannot be relaxed; ComputationError as the model does.
    """
    machine = to_machine(machine)
    check_samples(samples)
    check_angles(at_deg)
    extension, model = find_extension(machine), Model(machine)
    cycle = compute_cycle(model, samples)
    key, rows = f"{machine.angle}_deg", model.results(np.radians(at_deg)) if len(at_deg) else {}
    at = [
        {key: float(angle)} | {name: float(row[index]) for name, row in rows.items()}
        for index, angle in enumerate(at_deg)
    ]
    measured, sensor_warnings = measure_sensor(cycle)
    result = replace(
        cycle.result,
        at=at,
        warnings=[
            *extension.list_warnings(),
            *_list_bound_warnings(machine),
            *cycle.result.warnings,
            *sensor_warnings,
        ],
        measurement=None if measured is None else measured.result,
    )
    cycle = replace(cycle, result=result, measured=measured)
    return replace(cycle, result=extension.extend_cycle(cycle, lift_mm))


def check_angles(at_deg: Sequence[float]) -> None:
    """Raise InputError for an angle that is not finite."""
    if bad := [angle for angle in at_deg if not np.isfinite(angle)]:
        raise InputError.for_value("--at", bad[0], "it must be a finite angle in deg")


def _summarise(
    extension: MachineExtension, changing: Collection[str]
) -> tuple[CycleSummary | None, list[MechanismWarning]]:
    """Return the designer's summary, and a warning for each quantity with a pole, which the summary
    lacks.
    """
    try:
        cycle = extension.open_cycle()
        poles = {name: pole for name in cycle.names if (pole := cycle.find_pole(name)) is not None}
        warnings = [
            _warn_of_samples(f"{name} has a pole, or no value", float(np.degrees(pole)))
            for name, pole in poles.items()
        ]
        return extension.summarise(cycle, changing), warnings
    except ComputationError as error:
        return None, [_warn_of_samples(error.message, 0.0)]


def _warn_of_samples(reason: str, phi_deg: float) -> MechanismWarning:
    message = (
        f"{reason} at {phi_deg:.6g} deg: its extremes and means are those of the samples, "
        f"not true ones"
    )
    return MechanismWarning(name="no_summary", phi_deg=phi_deg, message=message)


def measure_sensor(cycle: MechanismCycle) -> tuple[SensorSignal | None, list[MechanismWarning]]:
    """Return what the sensor of the file sees, if it states that, or a warning if a quantity does
    not repeat.
    """
    view = find_sensor_view(cycle.machine)
    if view is None:
        return None, []
    if changing := [key for key in view.needed if key in cycle.result.not_repeating]:
        message = (
            f"what the sensor sees is missing: {', '.join(changing)} does not end the cycle "
            f"as it began it"
        )
        return None, [MechanismWarning(name="no_measurement", phi_deg=0.0, message=message)]
    return measure_cycle(cycle.machine, np.radians(cycle.angles_deg), cycle.columns), []


def validate_machine(machine: Machine | HasMachine) -> MachineValidation:
    """Return limits and warnings of a machine whose file is valid.

    Raises ComputationError if its loops do not close at some angle of the cycle.
    """
    machine = to_machine(machine)
    extension, cycle = find_extension(machine), compute_cycle(Model(machine)).result
    result = MachineValidation(
        machine=machine.name,
        valid=True,
        design=list(machine.design_names),
        own_numbers=machine.document.own_numbers(),
        holds=cycle.holds,
        met=cycle.met,
        warnings=[
            *extension.list_warnings(),
            *_list_bound_warnings(machine),
            *cycle.warnings,
        ],
    )
    return extension.extend_validation(result)


def _list_bound_warnings(machine: Machine) -> Iterator[MechanismWarning]:
    """Yield a warning for each value of the design that lies outside its bounds."""
    for index, lower, upper in zip(machine.moved, machine.lower, machine.upper, strict=True):
        value, number = machine.values[index], machine.data[index]
        if not lower <= number <= upper:
            ends = f"[{lower / value.factor:g}, {upper / value.factor:g}]"
            message = f"{value.path} = {number / value.factor:g} lies outside its bounds {ends}"
            yield MechanismWarning(name="design", message=message)
