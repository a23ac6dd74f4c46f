"""Inputs fitted to measured curves: synthetic data of both models come back, and what data cannot
tell is said.
"""

from functools import cache
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter.engine.machine import Machine
from planter.measured import calibration, reading
from planter.measured.calibration import Calibrated, ValidationMeasurement
from planter.measured.curve import Chosen, MeasuredCurve
from planter.measured.fit import Fit, fit_curve
from planter.measured.noise import (
    LackOfFit,
    assess_lack_of_fit,
)
from planter.measured.presentation import MACHINE_FILE, present_fit
from planter.measured.reading import Columns, read
from planter.mechanism.calibration import MeasuredSource, calibrate_to_data
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device, build_machine
from planter.report.presentation import ModelAssumptions
from tests.support import machines
from tests.support.cli import refusal
from tests.support.schemas import load_schema

SUPPORT = "support_N"

pytestmark = pytest.mark.usefixtures("kernel_cache")
TRUE = {"mass.planet_kg": 1.29, "centroid.planet_xy_mm[0]": 22.0}
BOUNDS = {
    "mass.planet_kg": (0.9, 1.6),
    "centroid.planet_xy_mm[0]": (10.0, 26.0),
    "phase_deg": (-10.0, 10.0),
}
COLUMNS = Columns("force", angle="angle")
NOISE = 0.05


@cache
def wang() -> Machine:
    return build_machine(machines.device("wang2017"))


def curve(machine: PlantingMachine, model: Model, degrees: np.ndarray) -> np.ndarray:
    device = Device(machine, model)
    return device.support(device.prologue(device.design), np.radians(degrees))


def written(
    path: Path, model: Model, machine: PlantingMachine | None = None, **more: float
) -> Path:
    """A measurement of the true machine: noise, an offset [N], a wrong zero of the angle [deg], a
    missing piece.
    """
    changed_machine = (
        machines.machine("wang2017").with_numbers(TRUE) if machine is None else machine
    )
    degrees = np.arange(0, 360, 1.5)
    degrees = degrees[(degrees < 300) | (degrees > 300 + more.get("missing", 0))]
    force = curve(changed_machine, model, degrees + more.get("phase", 0.0)) + more.get(
        "offset", 0.0
    )
    force = force + np.random.default_rng(int(more.get("seed", 4))).normal(0, NOISE, len(force))
    rows = "\n".join(f"{a},{f:.9f}" for a, f in zip(degrees, force, strict=True))
    path.write_text(f"# a made-up measurement\nangle [deg],force [N]\n{rows}\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def calibrations(tmp_path_factory: pytest.TempPathFactory) -> dict[Model, Calibrated]:
    """Fits to data of each model, with a piece missing, a wrong zero, and a second measurement at
    another speed.
    """
    folder, base = tmp_path_factory.mktemp("measured"), machines.machine("wang2017")
    results: dict[Model, Calibrated] = {}
    models: tuple[Model, ...] = ("exact", "printed")
    for model in models:
        faster = base.with_numbers({**TRUE, "operation.speed_rpm": 50.0})
        data = written(folder / f"{model}.csv", model, phase=2.0, missing=40)
        check = written(folder / f"{model}-faster.csv", model, faster, phase=2.0, seed=8)
        source = MeasuredSource(Device(base), data, COLUMNS, model=model)
        results[model] = calibrate_to_data(source, BOUNDS, ValidationMeasurement(check, 50.0))
    return results


@pytest.mark.parametrize("model", ["exact", "printed"])
def test_fitted_intervals_contain_true_inputs(
    model: Model, calibrations: dict[Model, Calibrated]
) -> None:
    result = calibrations[model].result
    truth = {**TRUE, "phase_deg": 2.0}
    assert result.rank == 3
    for entry in result.fitted:
        low, high = entry.interval
        assert low <= truth[entry.name] <= high
        assert low < entry.value < high
        assert high - low < 0.6 * (entry.upper - entry.lower)
    assert result.noise.std == pytest.approx(NOISE, rel=0.4)
    assert result.reached.rms_N == result.reached.rms == pytest.approx(NOISE, rel=0.2)
    assert (result.outcome, result.noise.model, result.noise.unit) == ("explained", "white", "N")
    assert (result.starts, result.warnings) == (8, [])


def test_wrong_model_explains_neither_data_nor_prediction(
    calibrations: dict[Model, Calibrated],
) -> None:
    for model, other in (("exact", "printed"), ("printed", "exact")):
        result = calibrations[model].result
        assert result.models[other].outcome == "not explained"
        assert result.models[other].agreeing_starts > result.models[other].starts / 2
        assert result.prediction is not None
        assert result.prediction.rms_N[model] == pytest.approx(NOISE, rel=0.4)
        assert result.prediction.rms_N[other] > 10 * NOISE


def test_fitted_file_reproduces_fitted_force(
    calibrations: dict[Model, Calibrated], tmp_path: Path
) -> None:
    calibrated = calibrations["exact"]
    device = machines.device("wang2017")
    present_fit(
        device.machine,
        calibrated,
        ModelAssumptions.from_sidecar(device.sidecar).meanings,
        "carrier angle / deg",
    ).write(tmp_path)
    machine = load(tmp_path / MACHINE_FILE)
    assert machine.origin("mass.planet_kg").startswith("calibrated (exact model")
    degrees = np.degrees(calibrated.fits["exact"].curve.phi) + calibrated.result.fitted[2].value
    again = curve(machine, "exact", degrees)
    assert again == pytest.approx(
        calibrated.fits["exact"].curve(calibrated.fits["exact"].values)[0], abs=1e-9
    )
    head = (tmp_path / "residuals.csv").read_text(encoding="utf-8")
    assert "phi_deg,measured_N,exact_N,printed_N,exact_low95_N,exact_high95_N\n" in head, (
        "no band of a refuted model"
    )
    page = (tmp_path / "report.html").read_text(encoding="utf-8").replace("\u2212", "-")
    assert calibrated.result.statement in page
    jsonschema.validate(calibrated.result.table(), load_schema("calibrate"))


def test_offset_is_detected_and_fitted(tmp_path: Path) -> None:
    measured = read(
        written(tmp_path / "data.csv", "exact", machines.machine("wang2017"), offset=4.0),
        COLUMNS,
        1.0,
    )
    without = fit_curve(
        MeasuredCurve(
            wang(), Chosen.from_bounds(wang(), {"mass.sun_kg": (0.35, 0.45)}), measured, SUPPORT
        ),
        starts=2,
    )
    assert without.rms > 20 * measured.noise
    gauge = fit_curve(
        MeasuredCurve(
            wang(), Chosen.from_bounds(wang(), {"offset_N": (-20.0, 20.0)}), measured, SUPPORT
        ),
        starts=2,
    )
    assert gauge.rms == pytest.approx(NOISE, rel=0.2)
    assert gauge.values[0] == pytest.approx(4.0, abs=4 * NOISE / np.sqrt(len(measured.phi)))


def test_outlier_is_left_out_and_reported(tmp_path: Path) -> None:
    path = written(tmp_path / "data.csv", "printed")
    text = path.read_text(encoding="utf-8").splitlines()
    angle, force = text[40].split(",")
    path.write_text(
        "\n".join([*text[:40], f"{angle},{float(force) + 60}", *text[41:]]) + "\n", encoding="utf-8"
    )
    measurement = read(path, COLUMNS, 1.0)
    assert not measurement.used[38]
    assert measurement.used.sum() == len(measurement.used) - 1
    assert "1 of 239" in measurement.treatment[2]


def test_invalid_calibration_options_exit_with_a_line(tmp_path: Path) -> None:
    data = str(written(tmp_path / "data.csv", "exact"))
    call = ("calibrate", "wang2017", "--data", data, "--column", "force", "--angle", "angle")
    assert "add --fit" in refusal(*call)
    assert "it must be PATH=LOW:HIGH" in refusal(*call, "--fit", "sun_kg=0.3")
    assert "the lower bound must be below the upper" in refusal(*call, "--fit", "sun_kg=0.5:0.3")
    assert "did you mean mass.sun_kg" in refusal(*call, "--fit", "sun_gk=0.3:0.5")
    assert "--check and --check-rpm belong together" in refusal(*call, "--check-rpm", "50")
    assert "--quantity = weight is not a quantity" in refusal(
        *call, "--fit", "sun_kg=0.3:0.5", "--quantity", "weight"
    )


def measurement(phi_deg: np.ndarray, values: np.ndarray, noise: float) -> reading.Measurement:
    channel = reading.Channel("force", "N", values, np.ones(len(phi_deg), dtype=bool), noise)
    return reading.Measurement(np.radians(phi_deg), (channel,))


ANYWHERE = {
    "mass.planet_kg": (0.8, 1.6),
    "mass.half_C2_kg": (0.2, 0.8),
    "offset_N": (-20.0, 20.0),
    "phase_deg": (0.0, 360.0),
}


def shifted(
    degrees: np.ndarray, phase: float, noise: float, seed: int, rho: float = 0.0
) -> np.ndarray:
    """Forces of an exact machine with an offset and a phase [deg]; neighbours of the noise are
    correlated by rho.
    """
    machine = machines.machine("wang2017").with_numbers(
        {"mass.planet_kg": 1.29, "mass.half_C2_kg": 0.45}
    )
    noises = np.random.default_rng(seed).normal(0, 1, len(degrees))
    for i in range(1, len(noises)):
        noises[i] = rho * noises[i - 1] + np.sqrt(1 - rho**2) * noises[i]
    return curve(machine, "exact", (degrees + phase) % 360) + 3.0 + noise * noises


@pytest.mark.parametrize("bounds", [(0.0, 360.0), (-150.0, -140.0)])
def test_phase_is_recovered_from_any_start(bounds: tuple[float, float]) -> None:
    """A curve with two minima: a search from one phase ends in the wrong one."""
    degrees = np.arange(0, 360, 4.0)
    chosen = Chosen.from_bounds(wang(), {**ANYWHERE, "phase_deg": bounds})
    curve = MeasuredCurve(
        wang(), chosen, measurement(degrees, shifted(degrees, 37.0, 0.4, 1), 0.4), SUPPORT
    )
    noise = curve.values - shifted(degrees, 37.0, 0.0, 1)
    fit = fit_curve(curve, starts=2)
    assert np.degrees(curve.period) == pytest.approx(180)
    assert curve.is_cyclic == (bounds[1] - bounds[0] >= 180)
    assert (fit.agreeing, fit.is_settled) == (2, True)
    assert fit.rms <= np.sqrt(np.mean(noise**2))  # a global fit leaves no more than the truth does
    low, value, high = (
        np.degrees(end) % 180 for end in (fit.band(3)[0], fit.values[3], fit.band(3)[1])
    )
    assert low < value < high < low + 3
    assert value == pytest.approx(37.0, abs=2 * (high - low))


def test_negative_phase_moves_into_period() -> None:
    degrees = np.arange(0, 360, 4.0)
    data = measurement(degrees, shifted(degrees, 179.9, 0.01, 1), 0.01)
    chosen = Chosen.from_bounds(
        wang(), {"mass.half_C2_kg": (0.2, 0.8), "offset_N": (-9.0, 9.0), "phase_deg": (-10.0, 10.0)}
    )
    entry = calibration.describe_inputs(
        fit_curve(MeasuredCurve(wang(), chosen, data, SUPPORT), starts=1)
    )[2]
    assert 178 < entry.value < 180
    assert (entry.lower, entry.start, entry.upper) == pytest.approx((170, 180, 190))
    assert entry.interval[0] < entry.value < entry.interval[1]


def test_curve_period_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    angles = np.arange(0, 360, 30.0)
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    for parts, periodic in (
        (1, np.cos(angle)),
        (3, np.cos(6 * angle) + np.sin(9 * angle)),
        (1, 0 * angle + 4),
    ):
        chosen = Chosen.from_bounds(wang(), {"phase_deg": (0.0, 200.0)})
        measured_curve = MeasuredCurve(wang(), chosen, measurement(angles, 0 * angles, 1), SUPPORT)
        monkeypatch.setattr(
            measured_curve, "sample", lambda _, curve=periodic: (curve[None], np.zeros((1, 720, 1)))
        )
        assert np.degrees(measured_curve.period) == pytest.approx(360 / parts)
        assert measured_curve.is_cyclic == (parts > 1)


def fit_and_judge(
    values: np.ndarray, degrees: np.ndarray, bounds: dict[str, tuple[float, float]], starts: int = 2
) -> tuple[str, Fit, LackOfFit]:
    data = read_inliers(degrees, values)
    fit = fit_curve(
        MeasuredCurve(wang(), Chosen.from_bounds(wang(), bounds), data, SUPPORT), starts=starts
    )
    lack = assess_lack_of_fit(fit.curve, fit.residuals, fit.curve(fit.values)[1])
    return calibration.judge_fit(fit, lack), fit, lack


def read_inliers(degrees: np.ndarray, values: np.ndarray) -> reading.Measurement:
    return measurement(degrees, values, reading._inliers(np.radians(degrees), values)[1])


def test_bounds_without_true_phase_refute_model() -> None:
    """The tampered case: where the truth is excluded and starts agree, the answer is a refutation
    within the bounds.
    """
    degrees = np.arange(0, 360, 2.0)
    outcome, fit, lack = fit_and_judge(
        shifted(degrees, 37.0, 0.05, 3), degrees, {**ANYWHERE, "phase_deg": (80.0, 100.0)}
    )
    assert (outcome, fit.is_settled) == ("not explained", True)
    assert lack.probability < 1e-6


def test_disagreeing_starts_are_not_settled() -> None:
    degrees = np.arange(0, 360, 2.0)
    curve = MeasuredCurve(
        wang(),
        Chosen.from_bounds(wang(), ANYWHERE),
        measurement(degrees, shifted(degrees, 37.0, 0.4, 1), 0.1),
        SUPPORT,
    )
    fit = Fit(curve, curve.machine_values(), (1.0, 1.1, 1.2, 1.0))
    assert (fit.agreeing, fit.is_settled) == (2, False)
    assert calibration.judge_fit(fit, LackOfFit(9.0, 1e-9, 20)) == "not settled"
    assert calibration.judge_fit(fit, LackOfFit(1.0, 0.4, 20)) == "explained"


@pytest.mark.long
def test_identifiable_inputs_are_never_refuted() -> None:
    outcomes = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        degrees = np.arange(0, 360, 2.0)
        machine = machines.machine("wang2017").with_numbers(
            {"mass.planet_kg": rng.uniform(0.85, 1.55), "mass.half_C2_kg": rng.uniform(0.25, 0.75)}
        )
        force = curve(machine, "exact", (degrees + rng.uniform(0, 360)) % 360) + rng.uniform(
            -15, 15
        )
        force += rng.normal(0, rng.choice([0.005, 0.02, 0.05, 0.1]) * np.ptp(force), len(force))
        outcomes.append(fit_and_judge(force, degrees, ANYWHERE, starts=8)[0])
    assert "not explained" not in outcomes
    assert outcomes.count("not settled") <= 4
