"""What could give the experiment of wang2017: effects between the exact model and the sensor,
fitted to its figures.

The inputs are the assumed ones, or those of a machine file, so that only the parameters of the
effects are free. Three figures of a curve cannot choose between explanations; what they can show is
which effect reaches them, and with how many parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import scipy

from planter.audit import numbers
from planter.audit.registry import register_experiment
from planter.engine.machine import Machine
from planter.engine.wording import name_quantity
from planter.files import units
from planter.files.fields import value_error
from planter.kernels import Array
from planter.measured.curve import SAMPLES
from planter.measured.explanations import STATED, describe_effects
from planter.measured.section import SECTION
from planter.measured.sensor_curve import SensorCurve, name_parameter
from planter.measured.sensor_view import (
    ElasticMount,
    Imbalance,
    LeakedForce,
    LeakedTorque,
    SensorEffect,
    SpeedHarmonics,
    find_sensor_view,
)
from planter.numerics.arrays import TURN
from planter.papers.planting.file import load
from planter.papers.planting.model import Device, build_machine
from planter.papers.planting.unpublished_inputs import MET
from planter.progress import Listener

PAPER = "wang2017"
FORCE, TORQUE = "support_N", "M_L_Nm"
BEARING, MIDDLE = "F_O1y_N", "F_Oy_N"
LARGEST_IMBALANCE = 10.0
"""Largest imbalance that is searched [kg m]."""
STARTS, SEED = 12, 0
FIGURES = ("max_N", "min_N", "variance_N2")
Entry = Mapping[str, Any]


@register_experiment(PAPER)
def compare_hypotheses(
    progress: Listener | None = None, source: str | None = None
) -> dict[str, Any]:
    """Return the figures that each hypothesis reaches, fitted to those of the experiment, and
    statements on them.

    With a machine file they are on its inputs, and its [measurement] is one more of them, as it is
    stated. Raises InputError for a file that is not a planting device, or whose sensor measures no
    force.
    """
    point = numbers.load_numbers()["disclosed"][PAPER]["experiment"]
    document = load(PAPER if source is None else source)
    machine = build_machine(Device(document.model_copy(update={SECTION: None}), "exact"))
    speed = float(machine.data[machine.speed])
    lever, mount = LeakedTorque(TORQUE), ElasticMount(speed)
    hypotheses: Sequence[tuple[SensorEffect, ...]] = (
        (lever,),
        (LeakedForce(BEARING),),
        (LeakedForce(MIDDLE),),
        (Imbalance(LARGEST_IMBALANCE),),
        (SpeedHarmonics(),),
        (mount,),
        (lever, mount),
    )
    rows = []
    if document.measurement is not None:
        rows.append(_evaluate_stated(build_machine(Device(document, "exact")), point))
    rows += [fit_hypothesis(machine, FORCE, (), point), fit_hypothesis(machine, BEARING, (), point)]
    rows += [fit_hypothesis(machine, FORCE, effects, point) for effects in hypotheses]
    inputs = "the assumed ones" if source is None else f"those of {document.source}"
    return {
        "paper": PAPER,
        "model": "exact",
        "machine": document.name,
        "measured": point,
        "hypotheses": rows,
        "statements": list(_state_hypotheses(rows, point, inputs)),
    }


def _evaluate_stated(machine: Machine, target: Mapping[str, float]) -> dict[str, Any]:
    """Return the figures of the force that the sensor of a machine file sees, of which nothing is
    fitted.
    """
    view = find_sensor_view(machine)
    assert view is not None
    key = view.quantity.key
    if units.display_unit(key) != "N":
        raise value_error(
            f"{SECTION}.quantity", key, "it must be a force in N for --experiment", machine.source
        )
    seen = "; ".join(map(str, view.effects)) or f"the sensor sees {key} of the rigid machine"
    return fit_hypothesis(machine, key, (), target) | {"name": STATED, "meaning": seen}


def fit_hypothesis(
    machine: Machine, quantity: str, effects: Sequence[SensorEffect], target: Mapping[str, float]
) -> dict[str, Any]:
    """Return the figures of a force behind effects, whose parameters are fitted to target figures.

    The sum of squares of the relative misses is least, from `STARTS` points.
    """
    angles = np.linspace(0, TURN, SAMPLES, endpoint=False)
    curve = SensorCurve.at_angles(machine, quantity, angles, effects)
    goal = np.array([target[key] for key in FIGURES])
    lower, width = curve.chosen.lower, curve.chosen.upper - curve.chosen.lower

    def compute_misses(u: Array) -> tuple[Array, Array]:
        values, slopes = curve(lower + u * width)
        deviation = values - values.mean()
        gradients = np.array(
            [slopes[values.argmax()], slopes[values.argmin()], 2 * deviation @ slopes / len(values)]
        )
        return (_compute_figures(values) - goal) / goal, gradients * width / goal[:, None]

    rng, begin = (
        np.random.default_rng(SEED),
        (curve.machine_values() - lower) / np.where(width > 0, width, 1.0),
    )
    best = begin
    if len(lower):
        starts = [begin, *(rng.random(len(lower)) for _ in range(STARTS - 1))]
        ends = [
            scipy.optimize.least_squares(
                lambda u: compute_misses(u)[0],
                np.clip(start, 1e-3, 1 - 1e-3),
                lambda u: compute_misses(u)[1],
                bounds=(0, 1),
            )
            for start in starts
        ]
        best = min(ends, key=lambda end: end.cost).x
    z = lower + best * width
    values = curve(z)[0]
    misses = (_compute_figures(values) - goal) / goal
    names = curve.chosen.names
    words = next(name_quantity(result) for result in machine.results if result.key == quantity)
    parameters = {
        f"{effect.name}.{p.name}": {
            "value": p.to_display(float(z[names.index(name_parameter(effect, p.name))])),
            "unit": p.unit,
        }
        for effect in effects
        for p in effect.parameters
    }
    return {
        "name": " + ".join(effect.name for effect in effects)
        or ("rigid" if quantity == FORCE else f"only {quantity}"),
        "label": describe_effects(machine, effects)
        or ("rigid machine" if quantity == FORCE else f"only {words}"),
        "meaning": "; ".join(effect.meaning for effect in effects)
        or f"the sensor sees {quantity} of the rigid machine",
        "parameters": parameters,
        **dict(zip(FIGURES, _compute_figures(values).tolist(), strict=True)),
        "range_N": float(np.ptp(values)),
        "mean_N": float(values.mean()),
        "largest_miss_percent": float(100 * np.abs(misses).max()),
        "reached": bool(np.abs(misses).max() <= MET),
    }


def _compute_figures(values: Array) -> Array:
    return np.array([values.max(), values.min(), values.var()])


def _state_hypotheses(
    rows: Sequence[Entry], target: Mapping[str, float], inputs: str
) -> Iterator[str]:
    yield (
        f"Measured: {target['max_N']:g} N, {target['min_N']:g} N and {target['variance_N2']:g} "
        f"N2. Inputs are "
        f"{inputs}; only the parameters of each hypothesis are fitted."
    )
    for row in rows:
        values = [
            f"{name.rpartition('.')[2]} "
            f"{np.inf if entry['value'] is None else entry['value']:.3g} {entry['unit']}"
            for name, entry in row["parameters"].items()
        ]
        listed = f" ({', '.join(value.removesuffix(' 1') for value in values)})" if values else ""
        verdict = (
            "reached" if row["reached"] else f"missed by up to {row['largest_miss_percent']:.3g} %"
        )
        yield (
            f"{row['label'][0].upper()}{row['label'][1:]}{listed}: {row['max_N']:.4g} N, "
            f"{row['min_N']:.4g} N and "
            f"{row['variance_N2']:.4g} N2, {verdict}."
        )
    yield (
        "Three figures cannot decide between hypotheses, and test none of as many parameters. A "
        "curve can: planter "
        "calibrate --data --explain."
    )
