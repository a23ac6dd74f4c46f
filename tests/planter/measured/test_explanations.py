"""Effects between a machine and its sensor obey their equations, are told apart in noise, and are
not seen in noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from planter.engine.machine import Machine
from planter.engine.response import MachineResponse
from planter.kernels import Array
from planter.measured.curve import Chosen
from planter.measured.explanations import explain_curve
from planter.measured.findings import ExplanationFound
from planter.measured.noise import REFUTING
from planter.measured.presentation import draw_reading
from planter.measured.reading import Channel, DataReading, Measurement
from planter.measured.sensor_curve import SensorCurve, interpolate_periodic, name_parameter
from planter.measured.sensor_view import (
    LARGEST_SWING,
    SQUARE,
    Curves,
    ElasticMount,
    ElectricCoupling,
    Gain,
    LeakedForce,
    LeakedTorque,
    SensorEffect,
    SpeedHarmonics,
    ZeroDrift,
)
from planter.numerics.arrays import TURN
from planter.papers.planting.model import build_machine
from tests.planter.measured.test_noise import correlate
from tests.planter.measured.test_sensor import build_knife, check_slopes, write_file
from tests.support import machines, own
from tests.support.cli import answer, refusal

SPEED = 5.0
PHI = np.linspace(0, TURN, 720, endpoint=False)
SIGNAL = 3 + 2 * np.cos(PHI) + np.sin(3 * PHI)


def filter_signal(effect: SensorEffect, **values: float) -> Array:
    """Return the signal behind an effect with parameters in display units."""
    searched = [np.log(values[p.name] / p.reference) for p in effect.parameters]
    return effect.apply(SIGNAL[:, None], Curves({"": SIGNAL[:, None]}, TURN, SPEED), searched)[:, 0]


def test_coupling_equals_first_order_response() -> None:
    corner = 0.4
    signal, wc = filter_signal(ElectricCoupling(SPEED), corner=corner), TURN * corner
    # y' + wc y = x', as a Fourier derivative in time
    orders = 1j * np.fft.rfftfreq(720, 1 / 720) * SPEED
    left = np.fft.irfft((orders + wc) * np.fft.rfft(signal), 720)
    right = np.fft.irfft(orders * np.fft.rfft(SIGNAL), 720)
    assert left == pytest.approx(right, abs=1e-9)
    assert signal.mean() == pytest.approx(0, abs=1e-12)


def test_speed_law_equals_machine_with_acceleration() -> None:
    """The generated machine, at the speed and the acceleration of each instant."""
    machine, degrees = own.machine("slider_crank", "", mu=0), np.arange(0, 360, 7.0)
    assert machine.acceleration is not None
    curve = build_curve(machine, "F_Ox_N", [SpeedHarmonics()], degrees)
    z = set_values(curve, {"speed harmonics.cos1": 0.1, "speed harmonics.sin2": -0.05})
    phi, speed = np.radians(degrees), float(machine.data[machine.speed])
    omega = speed * (1 + 0.1 * np.cos(phi) - 0.05 * np.sin(2 * phi))
    slope = speed * (-0.1 * np.sin(phi) - 0.1 * np.cos(2 * phi))
    response, expected = MachineResponse(machine, ["F_Ox"]), []
    for angle, now, rise in zip(phi, omega, slope * omega, strict=True):
        data = machine.data.copy()
        data[machine.speed], data[machine.acceleration] = now, rise
        expected.append(response.values(response.at_data(data), np.array([angle]))[0, 0])
    assert curve.evaluate(z, phi)[0][0] == pytest.approx(expected, abs=2e-3)
    assert np.ptp(expected - curve.evaluate(curve.machine_values(), phi)[0][0]) > 5


def test_acceleration_part_is_integral_of_square_part() -> None:
    """The momentum of a machine of constant weight: the part of the acceleration follows from that
    of the speed.
    """
    machine = build_machine(machines.device("wang2017", "exact"))
    curve = build_curve(machine, "support_N", [SpeedHarmonics()], np.arange(0, 360, 10.0))
    curves = curve._compute_curves(np.zeros(0))
    spectrum = np.fft.rfft(curves.rows["acceleration"][:, 0])
    derivative = np.fft.irfft(1j * np.arange(361) * spectrum, 720)
    square = curves.rows[SQUARE][:, 0]
    assert derivative == pytest.approx(square - square.mean(), abs=1e-3 * np.ptp(square))
    assert abs(square.mean()) < 1e-3 * np.ptp(square)  # momentum repeats


def test_interpolation_equals_periodic_spline() -> None:
    rng = np.random.default_rng(2)
    rows, at = rng.normal(size=(45, 3)), rng.uniform(-9, 20, 50)
    grid = np.linspace(0, 1.5 * TURN, 46)
    spline = CubicSpline(grid, np.vstack([rows, rows[:1]]), bc_type="periodic")
    values, slopes = interpolate_periodic(rows, 1.5 * TURN, at)
    assert values == pytest.approx(spline(at % (1.5 * TURN)), abs=1e-12)
    assert slopes == pytest.approx(spline(at % (1.5 * TURN), 1), abs=1e-10)


def build_curve(
    machine: Machine, key: str, effects: Sequence[SensorEffect], degrees: Array
) -> SensorCurve:
    return SensorCurve.at_angles(machine, key, np.radians(degrees), effects)


def set_values(curve: SensorCurve, values: Mapping[str, float]) -> Array:
    z = curve.machine_values()
    for name, value in values.items():
        z[curve.chosen.names.index(f"effect: {name}")] = value
    return z


def test_slopes_equal_differences() -> None:
    machine = own.machine("slider_crank", "", mu=0)
    mount = ElasticMount(float(machine.data[machine.speed]))
    drift = ZeroDrift(3, ((0.0, 6.0),), 20.0, "N")
    effects = [LeakedTorque("M_in_Nm"), SpeedHarmonics(), mount, Gain(), drift]
    degrees = np.arange(0, 360, 9.0)
    empty = Channel("F", "N", np.zeros(40), np.ones(40, dtype=bool), 1.0)
    chosen = Chosen.from_bounds(
        machine, {"m_s_kg": (1.0, 3.0), "phase_deg": (0.0, 360.0), "offset_N": (-9.0, 9.0)}
    )
    curve = SensorCurve(
        machine, chosen, Measurement(np.radians(degrees), (empty,)), "F_Ox_N", effects
    )
    check_slopes(curve)


def measure(
    machine: Machine,
    key: str,
    effects: Sequence[SensorEffect],
    values: Mapping[str, float],
    std: float,
    rho: float = 0.0,
    seed: int = 0,
) -> Measurement:
    """Return a measurement of a machine behind effects, with a phase of 40 deg, an offset of 3 N,
    and noise.
    """
    degrees = np.arange(0, 360, 3.0)
    curve = build_curve(machine, key, effects, degrees)
    signal = curve.evaluate(set_values(curve, values), np.radians(degrees + 40))[0][0] + 3.0
    signal += correlate(np.random.default_rng(seed), len(signal), rho, std)
    channel = Channel("F", "N", signal, np.ones(len(signal), dtype=bool), std)
    reading = DataReading("made up", "", "", "", len(signal), len(signal), 1.0, 3.0, None, [], [])
    return Measurement(np.radians(degrees), (channel,), (), None, reading)


def explain(machine: Machine, key: str, measured: Measurement) -> ExplanationFound:
    return explain_curve(machine, "derived", measured, {}, key).result


def test_lever_of_drive_is_found() -> None:
    machine = build_machine(machines.device("wang2017", "exact"))
    effect = LeakedTorque("M_L_Nm")
    result = explain(
        machine,
        "support_N",
        measure(machine, "support_N", [effect], {"lever M_L_Nm.lever": 27.0}, 1.0),
    )
    assert (result.outcome, result.preferred) == ("explained", "lever M_L_Nm")
    assert not any(row.active_bounds for row in result.explanations if row.name == result.preferred)
    rows = {row.name: row for row in result.explanations}
    assert rows["rigid"].outcome == "not explained"
    lever = rows["lever M_L_Nm"].parameters[0]
    assert lever.interval is not None
    low, high = lever.interval
    assert low is not None
    assert high is not None
    assert low < 1e3 / 27 < high
    assert high - low < 2
    assert rows["lever M_L_Nm"].log10_bayes > 20
    assert rows["imbalance"].log10_bayes < 1


def test_swing_beyond_its_bounds_is_not_settled() -> None:
    """The tampered case: harmonics larger than any that are searched, so that two parameters end on
    bounds.
    """
    machine = own.machine("slider_crank", "", mu=0)
    swing = {
        "speed harmonics.cos1": 1.2 * LARGEST_SWING,
        "speed harmonics.sin2": 1.1 * LARGEST_SWING,
    }
    measured = measure(machine, "F_Ox_N", [SpeedHarmonics()], swing, 3.0, 0.9)
    result = explain_curve(
        machine, "derived", measured, {"phase_deg": (20.0, 60.0)}, "F_Ox_N"
    ).result
    assert (result.outcome, result.preferred) == ("not settled", "speed harmonics")
    row = next(row for row in result.explanations if row.name == result.preferred)
    assert row.lack_of_fit.probability > REFUTING, "what is left passes as noise"
    assert {(bound.name, bound.side) for bound in row.active_bounds} == {
        (name, "upper") for name in swing
    }
    assert all(name in result.statement for name in swing)


@pytest.mark.long
def test_mount_below_a_lever_is_found() -> None:
    machine = build_machine(machines.device("wang2017", "exact"))
    mount = ElasticMount(float(machine.data[machine.speed]))
    values = {
        "lever M_L_Nm.lever": 20.0,
        "elastic mount.frequency": np.log(12 / mount.parameters[0].reference),
        "elastic mount.damping": np.log(0.06),
    }
    measured = measure(machine, "support_N", [LeakedTorque("M_L_Nm"), mount], values, 2.0, 0.5)
    result = explain(machine, "support_N", measured)
    assert result.outcome == "explained"
    row = next(row for row in result.explanations if row.name == result.preferred)
    frequency = next(p for p in row.parameters if p.name == "elastic mount.frequency")
    assert frequency.value == pytest.approx(12, rel=0.03)


def count_alarms(seeds: range) -> int:
    machine = own.machine("slider_crank")
    alarms = 0
    for seed in seeds:
        result = explain(machine, "F_Oy_N", measure(machine, "F_Oy_N", [], {}, 1.0, 0.9, seed))
        alarms += result.preferred != "rigid"
    return alarms


def test_correlated_noise_is_no_effect() -> None:
    assert count_alarms(range(1)) == 0


@pytest.mark.long
def test_false_alarms_are_rare() -> None:
    assert count_alarms(range(16)) <= 1


def test_record_has_no_empty_panel() -> None:
    """The correlation of noise needs two revolutions; a record of less has no panel for it."""
    machine = build_knife()
    short = measure(machine, "F_Oy_N", [], {}, 0.3)
    values, phi = np.tile(short.values, 3), np.concatenate([short.phi + TURN * k for k in range(3)])
    values = values + np.random.default_rng(1).normal(0, 0.3, len(values))
    channel = Channel("F", "N", values, np.ones(len(values), dtype=bool), 0.3)
    long = Measurement(phi, (channel,), (), None, short.reading)
    assert [len(draw_reading(each).axes) for each in (short, long)] == [2, 2]


def record(
    drift: float = 0.0, gain: float = 1.0, records: int = 1, rho: float = 0.5, seed: int = 0
) -> Measurement:
    """Return records of three revolutions of the knife drive, each with another zero, and a drift
    per revolution.
    """
    machine, rng = build_knife(), np.random.default_rng(seed)
    turn = np.radians(np.arange(0, 3 * 360, 4.0))
    curve = build_curve(machine, "F_Oy_N", [], np.degrees(turn) + 40)
    rigid = curve.evaluate(np.zeros(0), curve.phi)[0][0]
    parts = [
        gain * rigid
        + 3.0
        + 0.7 * k
        + drift * (1 - 1.5 * k) * turn / TURN
        + correlate(rng, len(turn), rho, 0.3)
        for k in range(records)
    ]
    phi, values = (
        np.concatenate([turn + 8 * TURN * k for k in range(records)]),
        np.concatenate(parts),
    )
    channel = Channel("F", "N", values, np.ones(len(values), dtype=bool), 0.3)
    reading = DataReading(
        "made up", "", "", "", len(values), len(values), 3.0 * records, 4.0, None, [], []
    )
    return Measurement(phi, (channel,), (), None, reading)


def explain_record(measured: Measurement) -> ExplanationFound:
    return explain_curve(
        build_knife(), "derived", measured, {"phase_deg": (20.0, 60.0)}, "F_Oy_N"
    ).result


def test_drift_of_zero_is_no_noise() -> None:
    result = explain_record(record(drift=0.6))
    assert (result.outcome, result.preferred) == ("explained", "linear drift of zero")
    rows = {row.name: row for row in result.explanations}
    assert rows["rigid"].outcome == "not explained"
    best = rows["linear drift of zero"]
    assert best.noise.std == pytest.approx(0.3, rel=0.2)
    assert best.noise.rho == pytest.approx(0.5, abs=0.2)
    (slope,) = best.parameters
    assert slope.unit == "N/r"
    assert slope.interval is not None
    assert slope.interval[0] < 0.6 < slope.interval[1]
    assert best.probability_of_any == pytest.approx(min(1.0, best.probability * result.compared))
    assert any("no machine file has it" in line for line in result.treatment)


def test_each_record_has_its_own_drift() -> None:
    result = explain_record(record(drift=0.8, records=2))
    assert (result.outcome, result.preferred) == ("explained", "linear drift of zero")
    row = next(row for row in result.explanations if row.name == result.preferred)
    slopes = {p.name.rpartition(".")[2]: p.value for p in row.parameters}
    assert slopes["slope1"] == pytest.approx(0.8, abs=0.25)
    assert slopes["slope2"] == pytest.approx(-0.4, abs=0.25)


@pytest.mark.long
def test_noise_of_records_is_no_drift() -> None:
    for seed in range(4):
        assert explain_record(record(rho=0.9, seed=seed)).preferred == "rigid"


def test_command_explains_and_refuses(tmp_path: Path) -> None:
    """Bounds of the phase spare the scan of a whole turn, which other tests have."""
    machine = build_knife()
    measured = measure(
        machine, "F_Oy_N", [LeakedForce("F_Ox_N")], {"enclosed F_Ox_N.share": 0.4}, 0.3
    )
    rows = zip(np.degrees(measured.phi), measured.values, strict=True)
    path = tmp_path / "data.csv"
    path.write_text(
        "a [deg];F [N]\n" + "".join(f"{a:.1f};{f:.5f}\n" for a, f in rows), encoding="utf-8"
    )
    call = (
        "calibrate",
        write_file(tmp_path, machine.document),
        "--data",
        str(path),
        "--column",
        "F",
    )
    out = tmp_path / "out"
    result = answer(
        *call,
        "--angle",
        "a",
        "--quantity",
        "F_Oy_N",
        "--fit",
        "m_k_kg=0.8:1.8",
        "--fit",
        "phase_deg=20:60",
        "--explain",
        "--out",
        str(out),
    )
    assert (result["outcome"], result["preferred"]) == ("explained", "enclosed F_Ox_N")
    row = next(row for row in result["explanations"] if row["name"] == "enclosed F_Ox_N")
    assert row["parameters"][0]["value"] == pytest.approx(0.4, abs=0.05)
    assert "calibrated (derived model" in (out / "calibrated.toml").read_text(encoding="utf-8")
    assert (out / "figures" / "explained.png").stat().st_size > 10_000
    assert result["statement"].startswith("Share of force of ")
    assert "more than a million times" in result["statement"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "below 1e" in page
    assert "enclosed F_Ox_N" in page  # the key, in the table of the fits
    sentence = refusal("calibrate", "wang2017", "--explain")
    assert "--explain" in sentence
    assert "--data" in sentence
    assert "--check" in refusal(
        *call,
        "--angle",
        "a",
        "--quantity",
        "F_Oy_N",
        "--explain",
        "--check",
        str(path),
        "--check-rpm",
        "300",
    )
    assert "--explain takes one quantity" in refusal(
        *call,
        "--column",
        "F",
        "--angle",
        "a",
        "--quantity",
        "F_Oy_N",
        "--quantity",
        "F_Ox_N",
        "--explain",
    )
    assert name_parameter(LeakedForce("F_Ox_N"), "share") == "effect: enclosed F_Ox_N.share"
