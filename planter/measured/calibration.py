"""`planter calibrate --data`: models of a machine fitted to a measured curve, with their
outcomes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.engine.machine import Machine
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document
from planter.kernels import Array
from planter.measured import reading
from planter.measured.curve import (
    EFFECT,
    PHASE,
    SMALLEST_NOISE,
    TINIEST_NOISE,
    ChannelNoise,
    Chosen,
    MeasuredCurve,
    factor_of,
    find_measured,
    find_offset_channel,
    is_nuisance,
    is_offset,
)
from planter.measured.findings import (
    ChannelFit,
    FitBound,
    FittedInput,
    MeasuredFound,
    ModelMeasured,
    Noise,
    NoiseSpread,
    Outcome,
    Prediction,
)
from planter.measured.fit import STARTS, Fit, SearchEnd, fit_curve, prepare_searches
from planter.measured.noise import REFUTING, LackOfFit, assess_lack_of_fit
from planter.measured.reading import Columns, Measurement
from planter.measured.sensor_curve import build_curve, describe_view
from planter.progress import Listener, ProgressPhase
from planter.task import AUTO, Means, Task

FORCE = "N"
MachineBuilder = Callable[[], Machine]
ROUNDING, TINY = 1e-6, 1e-30
"""Share of the range of the values below which residuals are rounding of digits, and its offset."""


@dataclass(frozen=True)
class ValidationMeasurement:
    """A second measurement at another speed [r/min], which is predicted and not fitted."""

    path: str | Path
    speed_rpm: float


@dataclass(frozen=True)
class Calibrated:
    """Fits of all models with their data, the machine file with the inputs of the first, if any,
    and the result.
    """

    measured: Measurement
    fits: dict[str, Fit]
    machine: Document | None
    result: MeasuredFound


def read_measurement(
    machine: Machine, data: str | Path, columns: Columns, quantities: Sequence[str]
) -> Measurement:
    """Return the measured curves of quantities of a machine.

    Raises InputError as `planter.measured.reading.read`.
    """
    display = find_units(machine, columns, quantities)
    return reading.read(data, columns, find_speed(machine), display)


def find_speed(machine: Machine) -> float | None:
    """Return the speed of the drive [rad/s], None of what moves freely."""
    return None if machine.motion is not None else float(machine.data[machine.speed])


def find_units(machine: Machine, columns: Columns, quantities: Sequence[str]) -> list[str]:
    """Return the display unit of each quantity.

    Raises InputError unless there is one for each column of values.
    """
    if len(quantities) != len(columns.names):
        raise InputError(
            f"--quantity is given {len(quantities)} times, but --column {len(columns.names)} "
            f"times: give one for each"
        )
    return [units.display_unit(find_measured(machine, quantity).key) for quantity in quantities]


def calibrate(
    builders: Mapping[str, Callable[[], Machine]],
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str | Sequence[str],
    rebuild: Callable[[Mapping[str, float]], Document] | None,
    check: ValidationMeasurement | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = AUTO,
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> Calibrated:
    """Fit chosen inputs within `bounds` (display units, by path) to curves in a CSV file, in one
    model or several.

    `builders` return the machines of the models by name, in the order of the report; workers need
    to pickle them. `quantity` names what each column of values is. `rebuild` returns the file with
    other numbers, by path, if there is one. `means` selects the workers of the searches and does
    not change their results. `priors` are means and standard deviations of inputs that are known
    about. Raises InputError for a file, columns or inputs that cannot be used.
    """
    if not bounds:
        raise InputError(
            "add --fit with an input and its bounds, such as --fit mass.planet_kg=0.8:1.6"
        )
    quantities = (quantity,) if isinstance(quantity, str) else tuple(quantity)
    machines = {name: build() for name, build in builders.items()}
    model, machine = next(iter(machines.items()))
    chosen = {
        name: Chosen.from_bounds(machine, bounds, priors) for name, machine in machines.items()
    }
    measured = read_measurement(machine, data, columns, quantities)
    phase = ProgressPhase("calibration", "start", STARTS * len(machines), progress)
    fits: dict[str, Fit] = {}
    for name, machine_of_model in machines.items():
        arguments = {"chosen": chosen[name], "measured": measured, "quantities": quantities}
        task = Task(prepare_starts, {"build": builders[name], **arguments})
        curve = build_curve(machine_of_model, chosen[name], measured, quantities)
        fits[name] = fit_curve(curve, seed, STARTS, phase, task, means)
    results = {name: describe_fit(fit, measured) for name, fit in fits.items()}
    fitted, notes = (None, []) if rebuild is None else rebuild_machine(fits[model], rebuild)
    first, other_fits = results[model], [fit for name, fit in fits.items() if name != model]
    values, unit = measured.values[measured.used], fits[model].curve.unit
    assert measured.reading is not None
    return Calibrated(
        measured,
        fits,
        fitted,
        MeasuredFound(
            machine=machine.name,
            model=model,
            quantity=quantities[0],
            unit=unit,
            outcome=first.outcome,
            statement=_statement(results, measured.noise, unit),
            treatment=[
                *measured.treatment,
                *describe_view(fits[model].curve, fits[model].values),
                *notes,
            ],
            warnings=list_warnings(first),
            noise=first.noise,
            target=_spread(float(values.std()), len(values), unit),
            reached=_spread(first.rms, len(values), unit),
            fitted=first.fitted,
            rank=first.rank,
            starts=first.starts,
            agreeing_starts=first.agreeing_starts,
            models=dict(results.items()),
            other_model=_spread(other_fits[0].rms, len(values), unit) if other_fits else None,
            reading=measured.reading,
            prediction=None if check is None else _predict(check, columns, fits, quantities),
        ),
    )


def prepare_starts(
    build: Callable[[], Machine], chosen: Chosen, measured: Measurement, quantities: Sequence[str]
) -> Callable[[Array], SearchEnd]:
    """Return the function that searches from values (n,), in a worker."""
    return prepare_searches(build_curve(build(), chosen, measured, quantities))


def _spread(rms: float, points: int, unit: str) -> NoiseSpread:
    return NoiseSpread(rms, points, rms if unit == FORCE else None)


def rebuild_machine(
    fit: Fit, rebuild: Callable[[Mapping[str, float]], Document]
) -> tuple[Document | None, list[str]]:
    """Return the file with the fitted inputs, or None with the reason if no machine can have
    them.
    """
    values = fit.curve.chosen.to_display(fit.values)
    try:
        return rebuild({name: value for name, value in values.items() if not is_nuisance(name)}), []
    except InputError as error:
        return None, [f"no machine can have the fitted values; change the bounds: {error.message}"]


def describe_fit(fit: Fit, measured: Measurement) -> ModelMeasured:
    """Return the record of a fit."""
    curve = fit.curve.with_angles_at(fit.values)
    first = fit.residuals[curve.channels[0]]
    worst, correlation = int(np.argmax(np.abs(first))), fit.correlation()
    moves, place = curve.duration is not None, float(curve.to_places(curve.phi[worst]))
    span = float(np.ptp(measured.values[measured.used]))
    noise = max(measured.noise, SMALLEST_NOISE * span + TINIEST_NOISE)
    lack = assess_lack_of_fit(curve, fit.residuals, curve(fit.values)[1])
    noises = [describe_noise(*each) for each in zip(curve.noises, curve.units, strict=True)]
    described = zip(curve.keys, curve.units, curve.channels, fit.channel_rms, noises, strict=True)
    return ModelMeasured(
        outcome=judge_fit(fit, lack),
        rms=fit.rms,
        rms_of_noise=None if measured.is_path else fit.rms / noise,
        largest_residual=float(first[worst]),
        largest_residual_deg=None if moves else place % 360.0,
        largest_residual_s=place if moves else None,
        fitted=describe_inputs(fit),
        rank=fit.rank,
        correlation=None if correlation is None else correlation.tolist(),
        starts=len(fit.sums),
        agreeing_starts=fit.agreeing,
        lack_of_fit=lack,
        noise=noises[0],
        channels=[
            ChannelFit(key, unit, points.stop - points.start, rms, noise)
            for key, unit, points, rms, noise in described
        ],
        active_bounds=describe_active_bounds(fit),
        rms_N=fit.rms if curve.unit == FORCE else None,
    )


def describe_noise(noise: ChannelNoise, unit: str) -> Noise:
    """Return the record of a noise."""
    return Noise("ar1" if noise.rho else "white", noise.std, noise.rho, unit)


def leaves_noise(fit: Fit, lack: LackOfFit) -> bool:
    """Return whether what a fit leaves passes as noise, or is rounding."""
    is_rounding = all(
        rms <= ROUNDING * float(np.ptp(fit.curve.values[points])) + TINY
        for rms, points in zip(fit.channel_rms, fit.curve.channels, strict=True)
    )
    return is_rounding or lack.probability >= REFUTING


def judge_fit(fit: Fit, lack: LackOfFit) -> Outcome:
    """Return the outcome of a fit.

    A model explains data by values inside its bounds alone, and is refuted only if a better fit and
    noise are both unlikely.
    """
    if leaves_noise(fit, lack):
        return "not settled" if fit.active_bounds else "explained"
    return "not explained" if fit.is_settled else "not settled"


def describe_active_bounds(fit: Fit) -> list[FitBound]:
    """Return the bounds on which a fit rests, of inputs and of parameters of effects."""
    names = fit.curve.chosen.names
    return [
        FitBound(names[i].removeprefix(EFFECT), side)
        for i, side in sorted(fit.active_bounds.items())
    ]


def state_active_bounds(bounds: Sequence[FitBound]) -> str:
    """Return a sentence on the bounds on which a fit rests."""
    named = ", ".join(f"{bound.name} ({bound.side})" for bound in bounds)
    return f"It rests on bounds, beyond which a better fit may lie: {named}"


def describe_inputs(fit: Fit) -> list[FittedInput]:
    """Return the fitted inputs with their bounds and intervals, a phase within its period."""
    curve, start = fit.curve, fit.curve.machine_values()
    lower, upper = curve.bounds(fit.values)
    inputs = []
    for i, name in enumerate(curve.chosen.names):
        if name.startswith(EFFECT):
            continue
        factor, (low, high) = factor_of(name), fit.band(i)
        is_open = low <= lower[i] or high >= upper[i]
        moved = 0.0
        ends = lower[i], upper[i]
        if name == PHASE:  # into [0, period): phases repeat with the period
            moved = float(np.mod(fit.values[i], curve.period)) % curve.period - float(fit.values[i])
            if curve.is_cyclic:
                ends = -moved, curve.period - moved
                start[i] = np.mod(start[i], curve.period) - moved
        all_values = (fit.values[i], *ends, start[i], low, high)
        value, lowest, highest, begin, *interval = (
            float((each + moved) / factor) for each in all_values
        )
        unit = find_unit(curve, name)
        inputs.append(
            FittedInput(
                name, value, unit, lowest, highest, begin, interval, bool(is_open), "calibrated"
            )
        )
    return inputs


def find_unit(curve: MeasuredCurve, name: str) -> str:
    """Return the display unit of an input, by its key, else the SI unit of the value."""
    if is_offset(name):
        return curve.units[find_offset_channel(name, curve.keys, curve.units)]
    return units.display_unit(name) or next(
        (entry.unit for entry in curve.machine.values if entry.path == name), "1"
    )


FITS: dict[Outcome, str] = {
    "explained": "good fit",
    "not explained": "poor fit within the bounds",
    "not settled": "not settled",
}


def _statement(results: Mapping[str, ModelMeasured], noise: float, unit: str) -> str:
    """Return sentences on the models that explain the data and on what the data determine."""
    sentences = []
    for model, result in results.items():
        sentences.append(f"{model.capitalize()} model: {FITS[result.outcome]}")
        sentences.append(
            f"RMS residual {result.rms:.3g} {unit}, {result.rms_of_noise:.3g} times the "
            f"measurement noise "
            f"({noise:.3g} {unit})"
        )
        sentences += state_shortfalls(result)
    return ". ".join([*sentences, *state_determined(next(iter(results.values())))])


def state_shortfalls(result: ModelMeasured) -> list[str]:
    """Return sentences on bounds on which a fit rests, and on what it leaves that is no noise."""
    sentences = []
    if result.active_bounds:
        sentences.append(state_active_bounds(result.active_bounds))
    if result.lack_of_fit.probability < REFUTING:
        sentences.append(
            f"What it leaves has a probability of {result.lack_of_fit.probability:.2g} as noise"
        )
    return sentences


def state_determined(result: ModelMeasured) -> list[str]:
    """Return sentences on how many combinations of the inputs the data determine, and on inputs
    that they do not.
    """
    sentences = [
        f"The data determine {result.rank} of {len(result.fitted)} combinations of the inputs"
    ]
    undetermined = [entry.name for entry in result.fitted if entry.open]
    if undetermined:
        sentences.append(
            f"Not determined by the data (interval reaches its bound): {', '.join(undetermined)}"
        )
    return sentences


def list_warnings(result: ModelMeasured) -> list[str]:
    """Return the warnings on the fit of the first model."""
    if result.active_bounds:
        names = ", ".join(bound.name for bound in result.active_bounds)
        return [f"not settled: no fit inside the bounds of {names} is as good; widen them"]
    if result.outcome != "not settled":
        return []
    return [
        f"not settled: {result.agreeing_starts} of {result.starts} starts agree, so a better fit "
        "may exist; narrow the bounds"
    ]


def _predict(
    check: ValidationMeasurement,
    columns: Columns,
    fits: Mapping[str, Fit],
    quantities: Sequence[str],
) -> Prediction:
    """Return the residuals of all fitted models for a measurement at another speed."""
    rms: dict[str, float] = {}
    points = 0
    for model, fit in fits.items():
        data, speed = (
            fit.curve.machine.data.copy(),
            check.speed_rpm * units.unit_factor("speed_rpm"),
        )
        data[fit.curve.machine.speed] = speed
        machine = fit.curve.machine.with_data(data)
        measured = read_measurement(machine, check.path, columns, quantities)
        curve = build_curve(machine, fit.curve.chosen, measured, quantities)
        residuals: Array = (curve.values - curve(fit.values)[0])[curve.channels[0]]
        rms[model], points = float(np.sqrt(np.mean(residuals**2))), len(residuals)
    is_force = fit.curve.unit == FORCE
    return Prediction(check.speed_rpm, points, rms, rms if is_force else None)
