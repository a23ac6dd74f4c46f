"""`planter calibrate --data`: models of a machine fitted to a measured curve, with their outcomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.engine.machine import Machine
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document
from planter.kernels import Array
from planter.measured import reading
from planter.measured.curve import PHASE, Chosen, MeasuredCurve, factor_of, find_measured, is_nuisance, is_offset
from planter.measured.findings import (
    FittedInput,
    MeasuredFound,
    ModelMeasured,
    Noise,
    NoiseSpread,
    Outcome,
    Prediction,
)
from planter.measured.fit import STARTS, Correlation, Fit, SearchEnd, assess_correlation, fit_curve, prepare_searches
from planter.measured.reading import Columns, Measurement
from planter.parallel.task import AUTO, Means, Task
from planter.progress import Listener, ProgressPhase

FORCE = "N"
ROUNDING, TINY = 1e-9, 1e-30
"""Share of the largest value below which noise is rounding of digits in the file, and its offset."""
EXPLAINS = 1.5
"""Ratio of RMS residual to noise up to which a model explains the data."""


@dataclass(frozen=True)
class ValidationMeasurement:
    """A second measurement at another speed [r/min], which is predicted and not fitted."""

    path: str | Path
    speed_rpm: float


@dataclass(frozen=True)
class Calibrated:
    """Fits of all models with their data, the machine file with the inputs of the first, if any, and the result."""

    measured: Measurement
    fits: dict[str, Fit]
    machine: Document | None
    result: MeasuredFound


def calibrate(
    builders: Mapping[str, Callable[[], Machine]],
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str,
    rebuild: Callable[[Mapping[str, float]], Document] | None,
    check: ValidationMeasurement | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = AUTO,
) -> Calibrated:
    """Fit chosen inputs within `bounds` (display units, by path) to a curve in a CSV file, in one model or several.

    `builders` return the machines of the models by name, in the order of the report; workers need to pickle them.
    `rebuild` returns the file with other numbers, by path, if there is one. `means` selects the workers of the searches
    and does not change their results. Raises InputError for a file, columns or inputs that cannot be used.
    """
    if not bounds:
        raise InputError("add --fit with an input and its bounds, such as --fit mass.planet_kg=0.8:1.6")
    machines = {name: build() for name, build in builders.items()}
    model, machine = next(iter(machines.items()))
    unit = units.display_unit(find_measured(machine, quantity).key)
    chosen = {name: Chosen.from_bounds(machine, bounds) for name, machine in machines.items()}
    measured = reading.read(data, columns, float(machine.data[machine.speed]), unit)
    phase = ProgressPhase("calibration", "start", STARTS * len(machines), progress)
    fits: dict[str, Fit] = {}
    for name, machine_of_model in machines.items():
        arguments = {"chosen": chosen[name], "measured": measured, "quantity": quantity}
        task = Task(prepare_starts, {"build": builders[name], **arguments})
        curve = MeasuredCurve(machine_of_model, chosen[name], measured, quantity)
        fits[name] = fit_curve(curve, seed, STARTS, phase, task, means)
    results = {name: _describe_fit(fit, measured) for name, fit in fits.items()}
    fitted, notes = (None, []) if rebuild is None else rebuild_machine(fits[model], rebuild)
    first, other_fits = results[model], [fit for name, fit in fits.items() if name != model]
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
            statement=_statement(results, measured.noise, unit),
            treatment=[*measured.treatment, *notes],
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
            other_model=_spread(other_fits[0].rms, len(values), unit) if other_fits else None,
            prediction=None if check is None else _predict(check, columns, fits, quantity),
            noise_N=measured.noise if unit == FORCE else None,
        ),
    )


def prepare_starts(
    build: Callable[[], Machine], chosen: Chosen, measured: Measurement, quantity: str
) -> Callable[[Array], SearchEnd]:
    """Return the function that searches from values (n,), in a worker."""
    return prepare_searches(MeasuredCurve(build(), chosen, measured, quantity))


def _spread(rms: float, points: int, unit: str) -> NoiseSpread:
    return NoiseSpread(rms, points, rms if unit == FORCE else None)


def rebuild_machine(fit: Fit, rebuild: Callable[[Mapping[str, float]], Document]) -> tuple[Document | None, list[str]]:
    """Return the file with the fitted inputs, or None with the reason if no machine can have them."""
    values = fit.curve.chosen.to_display(fit.values)
    try:
        return rebuild({name: value for name, value in values.items() if not is_nuisance(name)}), []
    except InputError as error:
        return None, [f"no machine can have the fitted values; change the bounds: {error.message}"]


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
    """Return the outcome of a fit; a model is refuted only if a better fit and correlated noise are both unlikely."""
    if ratio <= EXPLAINS:
        return "explained"
    return "not explained" if fit.is_settled and not neighbours.is_autoregressive else "not settled"


def describe_inputs(fit: Fit) -> list[FittedInput]:
    """Return the fitted inputs with their bounds and intervals, a phase within its period."""
    curve, start = fit.curve, fit.curve.machine_values()
    lower, upper = curve.bounds(fit.values)
    inputs = []
    for i, name in enumerate(curve.chosen.names):
        factor, (low, high) = factor_of(name), fit.band(i)
        is_open = low <= lower[i] or high >= upper[i]
        moved = 0.0
        ends = lower[i], upper[i]
        if name == PHASE:  # into [0, period): phases repeat with the period
            moved = float(np.mod(fit.values[i], curve.period)) % curve.period - float(fit.values[i])
            if curve.is_cyclic:
                ends = -moved, curve.period - moved
                start[i] = np.mod(start[i], curve.period) - moved
        display = [float((value + moved) / factor) for value in (fit.values[i], *ends, low, high)]
        value, display_lower, display_upper, low95, high95 = display
        inputs.append(
            FittedInput(
                name=name, value=value, unit=curve.unit if is_offset(name) else _unit_of(curve, name),
                lower=display_lower, upper=display_upper, start=float((start[i] + moved) / factor),
                low95=low95, high95=high95, interval=[low95, high95], open=bool(is_open), origin="calibrated",
            )
        )  # fmt: skip
    return inputs


def _unit_of(curve: MeasuredCurve, name: str) -> str:
    """Return the display unit of an input, by its key, else the SI unit of the value."""
    return units.display_unit(name) or next((entry.unit for entry in curve.machine.values if entry.path == name), "1")


FITS: dict[Outcome, str] = {
    "explained": "good fit",
    "not explained": "poor fit within the bounds",
    "not settled": "not settled",
}


def _statement(results: Mapping[str, ModelMeasured], noise: float, unit: str) -> str:
    """Return sentences on the models that explain the data and on inputs that the data do not determine."""
    sentences = []
    for model, result in results.items():
        sentences.append(f"{model.capitalize()} model: {FITS[result.outcome]}")
        sentences.append(
            f"RMS residual {result.rms:.3g} {unit}, {result.rms_of_noise:.3g} times the measurement noise "
            f"({noise:.3g} {unit})"
        )
    first = next(iter(results.values()))
    sentences.append(f"The data determine {first.rank} of {len(first.fitted)} combinations of the inputs")
    undetermined = [entry.name for entry in first.fitted if entry.open]
    if undetermined:
        sentences.append(f"Not determined by the data (interval reaches its bound): {', '.join(undetermined)}")
    return ". ".join(sentences)


def _warnings(result: ModelMeasured) -> list[str]:
    """Return the warnings on the fit of the first model."""
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


def _predict(check: ValidationMeasurement, columns: Columns, fits: Mapping[str, Fit], quantity: str) -> Prediction:
    """Return the residuals of all fitted models for a measurement at another speed."""
    rms: dict[str, float] = {}
    points = 0
    for model, fit in fits.items():
        data, speed = fit.curve.machine.data.copy(), check.speed_rpm * units.unit_factor("speed_rpm")
        data[fit.curve.machine.speed] = speed
        machine = fit.curve.machine.with_data(data)
        measured = reading.read(check.path, columns, speed, fit.curve.unit)
        curve = MeasuredCurve(machine, fit.curve.chosen, measured, quantity)
        residuals: Array = curve.values - curve(fit.values)[0]
        rms[model], points = float(np.sqrt(np.mean(residuals**2))), len(residuals)
    is_force = fit.curve.unit == FORCE
    return Prediction(check.speed_rpm, points, rms, rms if is_force else None)
