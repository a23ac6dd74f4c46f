"""Published numbers of papers as measures of a mechanism's quantities: over a cycle, or over the time of a free motion.

Extremes are true ones, unless the question states a number of samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
from scipy.interpolate import CubicSpline

from planter.audit.registry import Inputs, Value, formula
from planter.audit.user_paper import MEASURE, Question
from planter.engine.goal import Goal, find_display_unit, resolve_measure
from planter.engine.measures import AVERAGES, Measure, parse_measure
from planter.errors import InputError, PlanterError
from planter.files import paths
from planter.files.units import Unit, measured
from planter.kernels import Array
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import MechanismFile, load
from planter.mechanism.machines import build_machine
from planter.mechanism.model import require_repeating
from planter.numerics import statistics


@formula(MEASURE)
def measure(inputs: Inputs) -> Value:
    """The value that a question asks for, in its unit.

    Of assumed values those are read that the quantity can depend on. Raises InputError for what cannot be meant,
    ComputationError where there is no such motion; both name the number.
    """
    asked: Question = inputs["question"]
    file = _file(asked.machine)
    _check_given(asked, file)
    one = parse_measure(asked.quantity, f"{asked.label}.quantity =")
    known_units = told(file)
    _check_name(asked, one, known_units)
    unit = _unit(asked, one, known_units[one.name])
    dependencies = felt(file, one.name)
    values = {key: float(inputs[key]) for key in file.values if key in dependencies and key in inputs}
    try:
        found = evaluate_measure(_with(asked.machine, tuple(sorted(values.items()))), one, asked.samples, asked.until_s)
    except PlanterError as error:
        raise type(error)(f"{asked.label}: {error}") from None
    return found / unit.factor


@cache
def _file(path: Path) -> MechanismFile:
    return load(path)


@cache
def _with(path: Path, values: tuple[tuple[str, float], ...]) -> MechanismFile:
    return _file(path).moved_to(dict(values))


def _check_given(asked: Question, file: MechanismFile) -> None:
    for key, place in asked.conditions.items():
        if key not in file.values:
            near = paths.close(key, file.values)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(file.values)}"
            raise InputError(f"{place} is not allowed: {file.name} has no value {key}; {hint}")


def _check_name(asked: Question, one: Measure, told: Mapping[str, str]) -> None:
    if one.name not in told:
        near = paths.close(one.name, told)
        hint = f"did you mean {near[0]}?" if near else f"it has {', '.join(told)}"
        raise asked.refused("quantity", asked.quantity, f"nothing of the mechanism is called {one.name}; {hint}")


def _unit(asked: Question, one: Measure, si: str) -> Unit:
    """The unit of a number. Raises InputError where it is none, or that of something else."""
    own = measured(si)
    own = own.squared() if one.kind == "variance" else own
    try:
        found = measured(asked.unit)
    except ValueError as error:
        raise asked.refused("unit", asked.unit, f"{error}; {one.name} is in {si}") from None
    if not found.same_kind(own):
        shown = f"({si})2" if one.kind == "variance" else si
        raise asked.refused("unit", asked.unit, f"{one} is in {shown}, or another unit of its kind")
    return found


LOOKED_AT = 720
"""Samples of a turn among which extremes are looked for."""
AVERAGED = 7200
"""Samples of a turn that a mean is taken of: right to rounding where all is smooth, to 1e-4 of a jump elsewhere."""
INSTANTS = 2001
"""Instants of a motion."""
TOLERANCE = 1e-10


def told(file: MechanismFile) -> dict[str, str]:
    """SI units of the quantities that measures may be of, by name."""
    vectors = file.model.sidecar["vectors"]
    return {e["name"]: e["unit"] for part in ("start_state", "outputs") for e in vectors.get(part, ())}


def felt(file: MechanismFile, name: str) -> frozenset[str]:
    """Keys of the values that a quantity can depend on; of a free motion all."""
    keys = [entry["shown"].rpartition(".")[2] for entry in file.entries]
    if not file.is_driven:
        return frozenset(keys)
    lane = file.model.function("lane")
    given = {key: ca.SX.sym(key, lane.size1_in(key)) for key in lane.name_in()}
    data = given.setdefault("data", ca.SX.sym("data", len(keys)))
    if "hoisted" in given:
        prologue = file.model.function("prologue")
        given["hoisted"] = prologue(*(given[key] for key in prologue.name_in()))
    output = lane(*(given[key] for key in lane.name_in()))[file.model.outputs("lane").index(name)]
    return frozenset(key for key, does in zip(keys, ca.which_depends(output, data), strict=True) if does)


def evaluate_measure(file: MechanismFile, one: Measure, samples: int | None, until_s: float | None) -> float:
    """A measure in SI; of so many samples where a number is told, else the true one.

    Raises InputError for a measure that the mechanism does not have, ComputationError where it does not move so.
    """
    return _of_turn(file, one, samples, until_s) if file.is_driven else _of_motion(file, one, samples, until_s)


def _of_turn(file: MechanismFile, one: Measure, samples: int | None, until_s: float | None) -> float:
    if one.in_time or until_s is not None:
        raise InputError(f"{one} is not allowed: an angle drives {file.name}, so that measures are of a turn")
    machine = build_machine(file)
    resolved = resolve_measure(machine, one)
    if one.kind in AVERAGES:
        require_repeating(machine, [resolved.name], samples)
    count = samples or (AVERAGED if one.kind in AVERAGES and not one.during else LOOKED_AT)
    goal, x = Goal(machine, [resolved], [], count, with_events=samples is None), machine.design
    if samples is None:
        goal = goal.refined(x, 0.0) or goal
    return goal.measure(x, resolved) * find_display_unit(machine, resolved).factor


def _of_motion(file: MechanismFile, one: Measure, samples: int | None, until_s: float | None) -> float:
    """Extremes and means are those of a spline through the instants."""
    end = one.angle if one.kind == "at" else until_s
    if one.is_moving or one.kind == "work":
        raise InputError(f"{one} is not allowed: {file.name} moves by itself, and these are measures of a cycle")
    if end is None or (one.kind == "at" and not one.in_time):
        raise InputError(f"{one} is not allowed: {file.name} moves by itself: say NAME at SECONDS s, or until_s")
    times = np.linspace(0.0, end, INSTANTS if samples is None else samples) if end else np.array([0.0])
    dynamics = Dynamics(file)
    run = dynamics.run(times, TOLERANCE)
    found = (dict(zip(dynamics.names, run.states, strict=True)) | run.results).get(one.name)
    if found is None:
        raise InputError(f"{one} is not allowed: the balances do not determine {one.name}")
    if one.kind == "at":
        return float(found[-1])
    values = np.abs(found) if one.size else found
    return _reduce(one, values) if samples is not None else _of_spline(one, times, values)


def _of_spline(one: Measure, times: Array, values: Array) -> float:
    """A measure of the spline through values (n,) at times (n,)."""
    spline, end = CubicSpline(times, values), times[-1]
    if one.kind in ("max", "min", "range"):
        turning = spline.derivative().roots(extrapolate=False)
        return _reduce(one, spline(np.concatenate([[0.0, end], turning[np.isfinite(turning)]])))
    mean = float(spline.integrate(0.0, end)) / end
    if one.kind == "mean":
        return mean
    if one.kind == "std":
        return float(np.sqrt(_of_spline(replace(one, kind="variance"), times, values)))
    square = float(CubicSpline(times, values**2).integrate(0.0, end)) / end
    return float(np.sqrt(square)) if one.kind == "rms" else square - mean**2


def _reduce(one: Measure, values: Array) -> float:
    return float(statistics.reduce_samples(one.kind, values))
