"""How a sum of measures changes with a machine's values, and which combinations of these its curves
depend on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planter.engine.goal import Goal
from planter.engine.machine import Machine
from planter.engine.measures import (
    TIME,
    Crossing,
    EventTime,
    Measure,
    SettlingBand,
    format_sum,
)
from planter.engine.response import open_response
from planter.engine.solvers.insensitive import (
    WEIGHT_TOLERANCE,
    InsensitiveDirections,
    find_insensitive,
)
from planter.errors import InputError
from planter.files.record import Record
from planter.kernels import Array

Direction = list[dict[str, float]]
"""Weights of values, in parts of their widths."""


@dataclass(frozen=True)
class Combination(Record):
    """A combination of values, by weights in parts of their widths, whose squares sum to 1.

    `strength` is how much moving along it changes the curves, as a share of the strongest
    combination's.
    """

    strength: float
    weights: dict[str, float]


@dataclass(frozen=True)
class SensitivityResult(Record):
    """`planter sensitivity`: gradient per display unit, and a basis of directions on which the
    curves do not depend.

    `objective` and `gradient` are those of true extremes and integrals (`kind` "true", `samples`
    null) or of a number of `samples` ("sampled"); an extreme that two angles share has the gradient
    of one. `scaled` is the gradient times the width of each value's bounds, or the size of a value
    without. The curves are those of the quantities in `least`, in parts of their ranges;
    `combinations` are those that they depend on, the strongest first.
    """

    samples: int | None
    objective: float
    gradient: dict[str, float]
    effective_parameters: int
    insensitive: list[Direction]
    machine: str
    kind: Literal["true", "sampled"]
    least: str
    scaled: dict[str, float]
    combinations: list[Combination]


def compute_sensitivity(
    machine: Machine, terms: Sequence[Measure], samples: int | None = None, count: int | None = None
) -> SensitivityResult:
    """Return the sensitivity of a sum of measures at a machine's own design, in its moved values.

    Measures are as `goal.resolve_measure` gives them, over `samples` of a cycle, or by true
    extremes if None; curves over `count` samples then. Raises ComputationError where loops do not
    close.
    """
    x, curve = machine.design, samples or count or machine.samples
    goal, names = Goal(machine, terms, (), samples), machine.design_names
    gradient = goal.slope(x)
    columns = _scaled_slopes(machine, _list_names(machine, terms), curve)
    if not columns.any():
        raise InputError(
            f"{machine.source}: no value that moves has an effect on "
            f"{' or '.join(_list_names(machine, terms))}"
        )
    directions = find_insensitive(names, columns)
    return SensitivityResult(
        samples=samples,
        objective=goal.evaluate(x),
        gradient=_by_name(names, gradient * machine.scale),
        effective_parameters=directions.effective_parameters,
        insensitive=directions.named,
        machine=machine.name,
        kind="sampled" if samples else "true",
        least=format_sum(terms),
        scaled=_by_name(names, gradient * find_widths(machine)),
        combinations=_combinations(names, columns, directions.effective_parameters),
    )


def find_directions(
    machine: Machine, terms: Sequence[Measure], samples: int, equations: Array | None = None
) -> InsensitiveDirections:
    """Return on how many combinations of a machine's moved values the curves of a sum depend, and
    on which not.

    That is to first order at the machine's own design, over samples of a cycle. If equations with
    gradients `equations` (k, p) constrain the design, only directions that satisfy them count.
    """
    rows = None if equations is None else equations * find_widths(machine)
    columns = _scaled_slopes(machine, _list_names(machine, terms), samples)
    return find_insensitive(machine.design_names, columns, rows)


def move_all(machine: Machine) -> Machine:
    """Return the machine with all its values to move; those that it does not move yet have no
    bounds.
    """
    lower, upper = np.full(len(machine.values), np.nan), np.full(len(machine.values), np.nan)
    lower[list(machine.moved)], upper[list(machine.moved)] = machine.lower, machine.upper
    return replace(machine, moved=tuple(range(len(machine.values))), lower=lower, upper=upper)


def find_widths(machine: Machine) -> Array:
    """Return the widths (p,) of bounds in SI; of values without bounds their size, or one display
    unit if zero.
    """
    sizes = np.where(machine.design == 0.0, machine.scale, np.abs(machine.design))
    widths: Array = np.where(np.isnan(machine.lower), sizes, machine.upper - machine.lower)
    return widths


def _list_names(machine: Machine, terms: Sequence[Measure]) -> list[str]:
    names = (name for measure in terms for name in _list_curves(machine, measure))
    return list(dict.fromkeys(names))


def _list_curves(machine: Machine, measure: Measure) -> list[str]:
    """Return the names of the quantities that a measure depends on, its place too: of an event the
    states.
    """
    where = measure.where
    places: Sequence[str] = ()
    if isinstance(where, EventTime) and machine.motion is not None:
        places = machine.motion.motions.dynamics.names
    elif isinstance(where, Crossing | SettlingBand):
        places = where.names
    names = [name for name in (measure.name, *places) if name != TIME]
    return names or [measure.name]


def _scaled_slopes(machine: Machine, names: list[str], samples: int) -> Array:
    """Return the slopes (n, p) of curves at samples, in parts of their ranges, times the widths of
    the values.
    """
    response = open_response(machine, names)
    values, slopes = response.slopes(response.at(machine.design), machine.list_angles(samples))
    ranges = np.ptp(values, axis=1)
    ranges[ranges == 0.0] = 1.0
    scaled = slopes[:, :, 1:] / ranges[:, None, None]
    columns: Array = scaled.reshape(-1, len(machine.moved)) * find_widths(machine)
    return columns


def _combinations(names: tuple[str, ...], columns: Array, rank: int) -> list[Combination]:
    _, strengths, right = np.linalg.svd(columns, full_matrices=False)
    combinations = []
    for strength, weights in zip(strengths[:rank], right, strict=False):
        signed = weights * np.sign(weights[np.abs(weights).argmax()])
        named = {
            name: float(w)
            for name, w in zip(names, signed, strict=True)
            if abs(w) > WEIGHT_TOLERANCE
        }
        combinations.append(Combination(float(strength / strengths[0]), named))
    return combinations


def _by_name(names: Sequence[str], values: Array) -> dict[str, float]:
    return dict(zip(names, values.tolist(), strict=True))
