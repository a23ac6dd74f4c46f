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
from planter.planting.measured.curve import NUISANCE, SUPPORT, Chosen, MeasuredCurve
from planter.planting.measured.fit import Fit, searched
from planter.planting.measured.reading import Columns, Measurement
from planter.planting.measured.results import FittedInput, MeasuredFound, ModelMeasured, Prediction, Spread
from planter.planting.model import Device
from planter.progress import Listener, Phase

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
    measured = reading.read(data, columns, machine.si("operation.speed_rpm"))
    phase = Phase("calibration", "model", len(MODELS), progress)
    fits: dict[Model, Fit] = {}
    for one in MODELS:
        device = Device(machine, one)
        fits[one] = searched(MeasuredCurve(device, Chosen.of(device, bounds), measured, quantity), seed)
        phase.next(one)
    told = {one: _told(fit, measured) for one, fit in fits.items()}
    fitted, why = fitted_machine(fits[model])
    first, other = told[model], fits[next(one for one in MODELS if one != model)]
    values = measured.values[measured.used]
    return Calibrated(
        measured,
        fits,
        fitted,
        MeasuredFound(
            machine=machine.name,
            model=model,
            quantity=quantity,
            statement=_statement(model, told),
            treatment=[*measured.told, *why],
            left_out=int((~measured.used).sum()),
            noise_N=measured.noise,
            target=Spread(float(values.std()), len(values)),
            reached=Spread(first.rms_N, len(values)),
            fitted=first.fitted,
            rank=first.rank,
            models=dict(told.items()),
            other_model=Spread(other.rms, len(values)),
            prediction=None if check is None else _predicted(check, columns, fits, quantity),
        ),
    )


def fitted_machine(fit: Fit) -> tuple[Machine | None, list[str]]:
    """The machine with the fitted inputs; None where they are no machine's, and why."""
    shown = fit.curve.chosen.shown(fit.values)
    inputs = {name: value for name, value in shown.items() if name not in NUISANCE}
    try:
        return fit.curve.device.machine.with_numbers(inputs), []
    except InputError as error:
        return None, [f"the fitted values are no machine's, other bounds are needed: {error.message}"]


def _told(fit: Fit, measured: Measurement) -> ModelMeasured:
    worst = int(np.argmax(np.abs(fit.residuals)))
    correlation = fit.correlation()
    return ModelMeasured(
        rms_N=fit.rms,
        rms_of_noise=fit.rms / max(measured.noise, ROUNDING * float(np.abs(measured.values).max()) + TINY),
        largest_residual_N=float(fit.residuals[worst]),
        largest_residual_deg=float(np.degrees(fit.curve.phi[worst] % (2 * np.pi))),
        fitted=_inputs(fit),
        rank=fit.rank,
        correlation=None if correlation is None else correlation.tolist(),
        starts=len(fit.sums),
        agreeing_starts=fit.agreeing,
    )


def _inputs(fit: Fit) -> list[FittedInput]:
    chosen, own = fit.curve.chosen, fit.curve.own()
    found = []
    for i, name in enumerate(chosen.names):
        factor, (low, high) = units.factor(name), fit.band(i)
        is_open = low <= chosen.lower[i] or high >= chosen.upper[i]
        shown = [
            float(value / factor) for value in (fit.values[i], chosen.lower[i], chosen.upper[i], own[i], low, high)
        ]
        value, lower, upper, start, low95, high95 = shown
        found.append(
            FittedInput(
                name=name, value=value, unit=units.unit(name) or "1", lower=lower, upper=upper, start=start,
                low95=low95, high95=high95, open=bool(is_open), origin="calibrated",
            )
        )  # fmt: skip
    return found


def _statement(model: Model, told: Mapping[Model, ModelMeasured]) -> str:
    """Which models explain the data, and what of the inputs they leave open."""
    parts = []
    for one in (model, *(other for other in MODELS if other != model)):
        found = told[one]
        word = "explains the data" if found.rms_of_noise <= EXPLAINS else "does not explain the data"
        parts.append(
            f"the {one} model {word}: it leaves {found.rms_N:.4g} N, {found.rms_of_noise:.3g} times their noise"
        )
    found = told[model]
    open_ = [entry.name for entry in found.fitted if entry.open]
    parts.append(f"the data determine {found.rank} of {len(found.fitted)} combinations of the inputs")
    if open_:
        parts.append(f"open towards a bound: {', '.join(open_)}")
    return "; ".join(parts)


def _predicted(check: Check, columns: Columns, fits: Mapping[Model, Fit], quantity: str) -> Prediction:
    """What both fitted models leave of a measurement at another speed."""
    left: dict[str, float] = {}
    points = 0
    for model, fit in fits.items():
        machine = fit.curve.device.machine.with_numbers({"operation.speed_rpm": check.speed_rpm})
        measured = reading.read(check.path, columns, machine.si("operation.speed_rpm"))
        curve = MeasuredCurve(Device(machine, model), fit.curve.chosen, measured, quantity)
        aside: Array = curve.values - curve(fit.values)[0]
        left[model], points = float(np.sqrt(np.mean(aside**2))), len(aside)
    return Prediction(check.speed_rpm, points, left)
