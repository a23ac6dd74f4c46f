"""Published numbers of papers as measures of a mechanism's quantities: over a cycle, or over the
time of a free motion.

Extremes are true ones, unless the question states a number of samples; those of what a sensor sees
are the largest of `MEAN_SAMPLES` values.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import scipy

from planter import paths
from planter.audit.registry import Inputs, Value, formula
from planter.audit.user_paper import MEASURE, MeasureQuestion
from planter.engine import goal
from planter.engine.goal import find_display_unit, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import AVERAGES, Kind, Measure, parse_measure
from planter.errors import InputError, PlanterError
from planter.files.spelling import find_spelled, list_spellings
from planter.files.units import Unit, display_key, parse_unit
from planter.kernels import Array
from planter.kernels.formulas import HOISTED
from planter.measured.section import SECTION
from planter.measured.sensor_curve import measure_cycle
from planter.measured.sensor_view import find_sensor_view
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import MechanismFile, build_from_table, load
from planter.mechanism.machines import build_machine
from planter.mechanism.model import require_repeating
from planter.numerics import statistics


@formula(MEASURE)
def measure(inputs: Inputs) -> Value:
    """Return the value that a question asks for, in its unit.

    Only assumed values that the quantity can depend on are read. Raises InputError for a question
    without meaning, ComputationError if there is no such motion; both name the number.
    """
    question: MeasureQuestion = inputs["question"]
    stated = (
        ""
        if question.measurement is None
        else json.dumps(question.measurement, sort_keys=True, default=str)
    )
    file = _load_file(question.machine, stated, question.source)
    _check_conditions(question, file)
    parsed = parse_measure(question.quantity, f"{question.label}.quantity =")
    si_units = find_units(file)
    parsed = _find_name(question, parsed, si_units)
    unit = _find_unit(question, parsed, si_units[parsed.name])
    dependencies = find_dependencies(file, parsed.name)
    values = {
        key: float(inputs[key]) for key in file.values if key in dependencies and key in inputs
    }
    moved = _load_with_values(
        question.machine, stated, question.source, tuple(sorted(values.items()))
    )
    try:
        value = evaluate_measure(moved, parsed, question.samples, question.until_s)
    except PlanterError as error:
        raise type(error)(f"{question.label}: {error}") from None
    return value / unit.factor


@cache
def _load_file(path: Path, measurement: str, source: str) -> MechanismFile:
    """Return the mechanism at a path, with the sensor that the file at `source` states in JSON, if
    any.
    """
    file = load(path)
    if not measurement:
        return file
    return build_from_table(file.table() | {SECTION: json.loads(measurement)}, source, file.place)


@cache
def _load_with_values(
    path: Path, measurement: str, source: str, values: tuple[tuple[str, float], ...]
) -> MechanismFile:
    return _load_file(path, measurement, source).with_values(dict(values))


def _check_conditions(question: MeasureQuestion, file: MechanismFile) -> None:
    for key, place in question.conditions.items():
        if key not in file.values:
            close = paths.find_similar(key, file.values)
            hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(file.values)}"
            raise InputError(f"{place}: {file.name} has no value {key}; {hint}")


def _find_name(question: MeasureQuestion, parsed: Measure, si_units: Mapping[str, str]) -> Measure:
    """Return the measure with the names of the mechanism's quantities.

    Raises InputError for another name.
    """
    spellings = {
        name: list_spellings(name, display_key(name, unit)) for name, unit in si_units.items()
    }
    matches = find_spelled(parsed.name, spellings)
    if len(matches) != 1:
        close = matches or paths.find_similar(parsed.name, si_units)
        hint = f"did you mean {' or '.join(close)}?" if close else f"it has {', '.join(si_units)}"
        reason = f"the mechanism has no quantity {parsed.name}; {hint}"
        raise question.refused("quantity", question.quantity, reason)
    return replace(parsed, name=matches[0])


def _find_unit(question: MeasureQuestion, parsed: Measure, si_unit: str) -> Unit:
    """Return the unit of a number.

    Raises InputError for an invalid unit, or one of another kind.
    """
    is_square = parsed.kind == "variance"
    si = parse_unit(si_unit).squared() if is_square else parse_unit(si_unit)
    try:
        unit = parse_unit(question.unit)
    except ValueError as error:
        raise question.refused(
            "unit", question.unit, f"{error}; {parsed.name} is in {si_unit}"
        ) from None
    if not unit.same_kind(si):
        text = f"({si_unit})2" if is_square else si_unit
        raise question.refused(
            "unit", question.unit, f"{parsed} is in {text}, or another unit of its kind"
        )
    return unit


SEEN = "measured_"
"""Beginning of the name of what a sensor sees."""
SIGNAL_KINDS: tuple[Kind, ...] = ("max", "min", "range", "mean", "variance", "std", "rms", "at")
MEAN_SAMPLES = 7200
"""Samples of a mean over a cycle: exact to rounding for a smooth quantity, to 1e-4 of a jump
otherwise.
"""
INSTANTS = 2001
"""Output times of a motion."""
TOLERANCE = 1e-10
"""Relative tolerance of the integrator."""


def find_units(file: MechanismFile) -> dict[str, str]:
    """Return the SI units of all quantities by name; what a sensor sees has the name of its
    quantity behind `SEEN`.
    """
    vectors = file.model.sidecar["vectors"]
    si_units = {
        e["name"]: e["unit"] for part in ("start_state", "outputs") for e in vectors.get(part, ())
    }
    if file.is_driven:
        machine = build_machine(file)
        si_units |= {vector.name: si_units[vector.components[0]] for vector in machine.vectors}
    view = None if file.measurement is None else find_sensor_view(build_machine(file))
    return (
        si_units if view is None else si_units | {f"{SEEN}{view.quantity.name}": view.quantity.unit}
    )


def find_dependencies(file: MechanismFile, name: str) -> frozenset[str]:
    """Return the keys of the values that a quantity can depend on; all keys for a free motion and a
    sensor.
    """
    keys = [entry["shown"].rpartition(".")[2] for entry in file.entries]
    if not file.is_driven or name.startswith(SEEN):
        return frozenset(keys)
    lane = file.model.function("lane")
    inputs = {key: ca.SX.sym(key, lane.size1_in(key)) for key in lane.name_in()}
    data = inputs.setdefault("data", ca.SX.sym("data", len(keys)))
    if HOISTED in inputs:
        prologue = file.model.function("prologue")
        inputs[HOISTED] = prologue(*(inputs[key] for key in prologue.name_in()))
    outputs = file.model.outputs("lane")
    places = [outputs.index(part) for part in build_machine(file).list_parts(name)]
    output = lane(*(inputs[key] for key in lane.name_in()))[places]
    return frozenset(itertools.compress(keys, ca.which_depends(output, data)))


def evaluate_measure(
    file: MechanismFile, measure: Measure, samples: int | None, until_s: float | None
) -> float:
    """Return a measure in SI, over `samples` or, without a number, by true extremes and integrals.

    Raises InputError for a measure that the mechanism does not have, ComputationError if it has no
    such motion.
    """
    evaluate = _evaluate_over_cycle if file.is_driven else _evaluate_over_time
    return evaluate(file, measure, samples, until_s)


def _evaluate_over_cycle(
    file: MechanismFile, measure: Measure, samples: int | None, until_s: float | None
) -> float:
    if measure.in_time or until_s is not None:
        raise InputError(
            f"{measure}: an angle drives {file.name}, so that measures are over a cycle, not a time"
        )
    machine = build_machine(file)
    if measure.name.startswith(SEEN):
        return _evaluate_signal(machine, measure, samples)
    resolved = resolve_measure(machine, measure)
    if measure.kind in AVERAGES:
        require_repeating(machine, [resolved.name], samples)
    return (
        goal.evaluate_measure(machine, resolved, samples)
        * find_display_unit(machine, resolved).factor
    )


def _evaluate_signal(machine: Machine, measure: Measure, samples: int | None) -> float:
    """Return a measure in SI of what the sensor of a machine sees."""
    if measure.is_moving or measure.kind not in SIGNAL_KINDS:
        raise InputError(
            f"{measure}: of what a sensor sees there are {', '.join(SIGNAL_KINDS[:-1])} and NAME "
            f"at DEG"
        )
    view = find_sensor_view(machine)
    assert view is not None
    require_repeating(machine, [view.quantity.name], samples)
    phi = np.linspace(0, machine.turn, samples or MEAN_SAMPLES, endpoint=False)
    if measure.angle is not None:
        phi = np.radians([measure.angle])
    measured = measure_cycle(machine, phi, {})
    assert measured is not None
    values = measured.signal * view.quantity.factor
    values = np.abs(values) if measure.size else values
    return float(
        values[0] if measure.kind == "at" else statistics.reduce_samples(measure.kind, values)
    )


def _evaluate_over_time(
    file: MechanismFile, measure: Measure, samples: int | None, until_s: float | None
) -> float:
    """Return a measure over a time; without a number of samples, that of a spline through the
    instants.
    """
    end = measure.angle if measure.kind == "at" else until_s
    if measure.is_moving or measure.kind == "work":
        raise InputError(f"{measure}: {file.name} moves freely, and this is a measure of a cycle")
    if end is None or (measure.kind == "at" and not measure.in_time):
        raise InputError(
            f"{measure}: {file.name} moves freely: state NAME at SECONDS s, or until_s"
        )
    times = (
        np.linspace(0.0, end, INSTANTS if samples is None else samples) if end else np.array([0.0])
    )
    dynamics = Dynamics(file)
    run = dynamics.run(times, TOLERANCE)
    values = (dict(zip(dynamics.names, run.states, strict=True)) | run.results).get(measure.name)
    if values is None:
        raise InputError(f"{measure}: {measure.name} is statically indeterminate")
    if measure.kind == "at":
        return float(values[-1])
    values = np.abs(values) if measure.size else values
    if samples is not None:
        return float(statistics.reduce_samples(measure.kind, values))
    return _evaluate_spline(measure.kind, times, values)


def _evaluate_spline(kind: Kind, times: Array, values: Array) -> float:
    """Return a measure of the spline through values (n,) at times (n,)."""
    spline, end = scipy.interpolate.CubicSpline(times, values), times[-1]
    if kind in ("max", "min", "range"):
        turning = spline.derivative().roots(extrapolate=False)
        extremes = spline(np.concatenate([[0.0, end], turning[np.isfinite(turning)]]))
        return float(statistics.reduce_samples(kind, extremes))
    mean = float(spline.integrate(0.0, end)) / end
    if kind == "mean":
        return mean
    square = float(scipy.interpolate.CubicSpline(times, values**2).integrate(0.0, end)) / end
    if kind == "rms":
        return float(np.sqrt(square))
    variance = square - mean**2
    return variance if kind == "variance" else float(np.sqrt(variance))
