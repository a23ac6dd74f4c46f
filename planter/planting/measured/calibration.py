"""`planter calibrate --data`: both models fitted to a measured curve, and what that says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import units
from planter.kernels import Array
from planter.planting.file import Machine
from planter.planting.functions import MODELS, Model
from planter.planting.measured import reading
from planter.planting.measured.correlation import Correlation, assess_correlation
from planter.planting.measured.curve import NUISANCE, OFFSET, PHASE, SUPPORT, Chosen, MeasuredCurve, quantity_unit
from planter.planting.measured.fit import Fit, searched
from planter.planting.measured.reading import Columns, Measurement
from planter.planting.measured.results import (
    FittedInput,
    MeasuredFound,
    ModelMeasured,
    Noise,
    Outcome,
    Prediction,
    Spread,
)
from planter.planting.model import Device
from planter.progress import Listener, Phase

FORCE = "N"
ROUNDING, TINY = 1e-9, 1e-30
"""Noise below this share of the largest value is that of digits that were written."""
EXPLAINS = 1.5
"""A model explains data that it leaves no more of than this many times their noise."""


@dataclass(frozen=True)
class Check:
    """A second measurement, at its own speed [r/min], that nothing is fitted to."""

    path: str | Path
    speed_rpm: float


@dataclass(frozen=True)
class Calibrated:
    """The fits of both models with their data, the fitted machine of the first, if it is one, and the result."""

    measured: Measurement
    fits: dict[Model, Fit]
    machine: Machine | None
    result: MeasuredFound


def calibrate(
    machine: Machine,
    model: Model,
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str = SUPPORT,
    check: Check | None = None,
    seed: int = 0,
    progress: Listener | None = None,
) -> Calibrated:
    """Fit chosen inputs within `bounds` (shown units, by path) to a curve in a CSV file, in both models.

    Raises InputError for a file, columns or inputs that cannot be used.
    """
    if not bounds:
        raise InputError("--fit must name at least one input with its bounds, as --fit mass.planet_kg=0.8:1.6")
    unit = quantity_unit(Device(machine, model), quantity)
    measured = reading.read(data, columns, machine.si("operation.speed_rpm"), unit)
    phase = Phase("calibration", "model", len(MODELS), progress)
    fits: dict[Model, Fit] = {}
    for one in MODELS:
        device = Device(machine, one)
        fits[one] = searched(MeasuredCurve(device, Chosen.of(device, bounds), measured, quantity), seed)
        phase.next(one)
    results = {one: _describe_fit(fit, measured) for one, fit in fits.items()}
    fitted, why = fitted_machine(fits[model])
    first, other = results[model], fits[next(one for one in MODELS if one != model)]
    values = measured.values[measured.used]
    return Calibrated(
        measured,
        fits,
        fitted,
        MeasuredFound(
            machine=machine.name,
            model=model,
            quantity=quantity,
            unit=unit,
            outcome=first.outcome,
            statement=_statement(model, results, measured.noise, unit),
            treatment=[*measured.told, *why],
            warnings=_warnings(first),
            left_out=int((~measured.used).sum()),
            noise=Noise("white", measured.noise, 0.0, unit),
            target=_spread(float(values.std()), len(values), unit),
            reached=_spread(first.rms, len(values), unit),
            fitted=first.fitted,
            rank=first.rank,
            starts=first.starts,
            agreeing_starts=first.agreeing_starts,
            models=dict(results.items()),
            other_model=_spread(other.rms, len(values), unit),
            prediction=None if check is None else _predicted(check, columns, fits, quantity),
            noise_N=measured.noise if unit == FORCE else None,
        ),
    )


def _spread(rms: float, points: int, unit: str) -> Spread:
    return Spread(rms, points, rms if unit == FORCE else None)


def fitted_machine(fit: Fit) -> tuple[Machine | None, list[str]]:
    """The machine with the fitted inputs; None where they are no machine's, and why."""
    shown = fit.curve.chosen.shown(fit.values)
    inputs = {name: value for name, value in shown.items() if name not in NUISANCE}
    try:
        return fit.curve.device.machine.with_numbers(inputs), []
    except InputError as error:
        return None, [f"the fitted values are no machine's, other bounds are needed: {error.message}"]


def _describe_fit(fit: Fit, measured: Measurement) -> ModelMeasured:
    worst, is_force = int(np.argmax(np.abs(fit.residuals))), fit.curve.unit == FORCE
    correlation, largest = fit.correlation(), float(fit.residuals[worst])
    ratio = fit.rms / max(measured.noise, ROUNDING * float(np.abs(measured.values).max()) + TINY)
    neighbours = assess_correlation(fit.residuals)
    return ModelMeasured(
        outcome=judge_fit(fit, ratio, neighbours),
        rms=fit.rms,
        rms_of_noise=ratio,
        largest_residual=largest,
        largest_residual_deg=float(np.degrees(fit.curve.phi[worst] % (2 * np.pi))),
        autocorrelation=neighbours.rho,
        white=neighbours.is_white,
        fitted=describe_inputs(fit),
        rank=fit.rank,
        correlation=None if correlation is None else correlation.tolist(),
        starts=len(fit.sums),
        agreeing_starts=fit.agreeing,
        rms_N=fit.rms if is_force else None,
        largest_residual_N=largest if is_force else None,
    )


def judge_fit(fit: Fit, ratio: float, neighbours: Correlation) -> Outcome:
    """What a fit says of its model: it is refuted only if no better fit is likely and noise cannot look like this."""
    if ratio <= EXPLAINS:
        return "explained"
    return "not explained" if fit.is_settled and not neighbours.is_autoregressive else "not settled"


def describe_inputs(fit: Fit) -> list[FittedInput]:
    """The fitted inputs with their bounds and intervals, a phase within its period."""
    curve, start = fit.curve, fit.curve.own()
    lower, upper = curve.bounds(fit.values)
    inputs = []
    for i, name in enumerate(curve.chosen.names):
        factor, (low, high) = units.factor(name), fit.band(i)
        is_open = low <= lower[i] or high >= upper[i]
        moved = 0.0
        ends = lower[i], upper[i]
        if name == PHASE:  # into [0, period): a phase means the same after whole periods
            moved = float(np.mod(fit.values[i], curve.period)) % curve.period - float(fit.values[i])
            if curve.is_cyclic:
                ends = -moved, curve.period - moved
                start[i] = np.mod(start[i], curve.period) - moved
        shown = [float((value + moved) / factor) for value in (fit.values[i], *ends, low, high)]
        value, shown_lower, shown_upper, low95, high95 = shown
        inputs.append(
            FittedInput(
                name=name, value=value, unit=curve.unit if name == OFFSET else units.unit(name) or "1",
                lower=shown_lower, upper=shown_upper, start=float((start[i] + moved) / factor),
                low95=low95, high95=high95, interval=[low95, high95], open=bool(is_open), origin="calibrated",
            )
        )  # fmt: skip
    return inputs


FITS: dict[Outcome, str] = {
    "explained": "good fit",
    "not explained": "poor fit within the bounds",
    "not settled": "not settled",
}


def _statement(model: Model, results: Mapping[Model, ModelMeasured], noise: float, unit: str) -> str:
    """Which models explain the data, and what of the inputs the data do not determine, in sentences."""
    sentences = []
    for one in (model, *(other for other in MODELS if other != model)):
        result = results[one]
        sentences.append(f"{one.capitalize()} model: {FITS[result.outcome]}")
        sentences.append(
            f"RMS residual {result.rms:.3g} {unit}, {result.rms_of_noise:.3g} times the measurement noise "
            f"({noise:.3g} {unit})"
        )
    first = results[model]
    sentences.append(f"The data determine {first.rank} of {len(first.fitted)} combinations of the inputs")
    undetermined = [entry.name for entry in first.fitted if entry.open]
    if undetermined:
        sentences.append(f"Not determined by the data (interval reaches its bound): {', '.join(undetermined)}")
    return ". ".join(sentences)


def _warnings(result: ModelMeasured) -> list[str]:
    """What limits the answer of the first model."""
    warnings = []
    if not result.white:
        warnings.append(
            f"neighbouring residuals are correlated ({result.autocorrelation:.2f}); the intervals assume white noise, "
            "so they are too narrow or the model is incomplete"
        )
    if result.outcome == "not settled":
        disagree = 2 * result.agreeing_starts <= result.starts
        reason = (
            f"{result.agreeing_starts} of {result.starts} starts agree, so a better fit may exist; narrow the bounds"
            if disagree
            else "the residual may be correlated noise as well as an error of the model; measure several revolutions"
        )
        warnings.append(f"not settled: {reason}")
    return warnings


def _predicted(check: Check, columns: Columns, fits: Mapping[Model, Fit], quantity: str) -> Prediction:
    """What both fitted models leave of a measurement at another speed."""
    left: dict[str, float] = {}
    points = 0
    for model, fit in fits.items():
        machine = fit.curve.device.machine.with_numbers({"operation.speed_rpm": check.speed_rpm})
        measured = reading.read(check.path, columns, machine.si("operation.speed_rpm"), fit.curve.unit)
        curve = MeasuredCurve(Device(machine, model), fit.curve.chosen, measured, quantity)
        aside: Array = curve.values - curve(fit.values)[0]
        left[model], points = float(np.sqrt(np.mean(aside**2))), len(aside)
    is_force = fit.curve.unit == FORCE
    return Prediction(check.speed_rpm, points, left, left if is_force else None)
