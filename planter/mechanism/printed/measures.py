"""A printed number as a measure of a mechanism's quantity, with the values that it holds for."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from planter.audit.question import MEASURE, Question
from planter.audit.registry import Inputs, Value, formula
from planter.engine.measures import Measure, parse_measure
from planter.errors import InputError, PlanterError
from planter.files import paths
from planter.files.dimensions import Unit, measured
from planter.mechanism import course
from planter.mechanism.file import MechanismFile, load


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
    told = course.told(file)
    _check_name(asked, one, told)
    unit = _unit(asked, one, told[one.name])
    felt = course.felt(file, one.name)
    values = {key: float(inputs[key]) for key in file.values if key in felt and key in inputs}
    try:
        found = course.measure(_with(asked.machine, tuple(sorted(values.items()))), one, asked.samples, asked.until_s)
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
