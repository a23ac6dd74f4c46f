"""Values fitted to records of what moves freely: free decays made by closed formulas, and what
linear theory says of their uncertainty.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.kernels import Array
from planter.measured.curve import Chosen, MeasuredCurve
from planter.measured.reading import Columns
from planter.mechanism.calibration import MeasuredSource, calibrate_to_data
from tests.planter.mechanism.test_motion_measures import BALL, OSCILLATOR, oscillate
from tests.support import own
from tests.support.cli import answer, refusal

TRUTH = {"k_N_m": 47.0, "c_N_s_m": 0.31, "x_0_m": 0.085}
BOUNDS = {"k_N_m": (20.0, 80.0), "c_N_s_m": (0.05, 2.0), "x_0_m": (0.05, 0.15)}
NOISE = 0.5
"""Standard deviation of a record [mm]."""
PENDULUM = r'''
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2 | free fall | 9.81
    m_b | kg   | bob       | 0.5
    L   | mm   | length    | 800
    a_0 | rad  | start     | 1.2
""")
m = Mechanism("own", q, gravity=q.g)
a = m.coordinate("a", "rad", "angle from the horizontal")
rod = m.frame("rod", a)
bob = m.body("bob", rod, q.m_b, m.point("P", m.O, rod, q.L))
m.pin("pivot", bob, m.ground, m.O)
m.begin({a: q.a_0})
SYSTEM = m.system()
'''


def source(text: str) -> str:
    return str(own.generated(text) / "own.toml")


def decay(t: Array) -> Array:
    """The place [mm] of the oscillator with the true values."""
    return 1e3 * oscillate(0.5, TRUTH["k_N_m"], TRUTH["c_N_s_m"], TRUTH["x_0_m"], t)


def write_record(path: Path, t: Array, x: Array, head: str = "t [s],x [mm]") -> Path:
    lines = [f"{a:.6f},{b:.6f}" for a, b in zip(t.tolist(), x.tolist(), strict=True)]
    path.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return path


def fit(path: Path, bounds: dict[str, tuple[float, float]], text: str = OSCILLATOR) -> Any:
    columns = Columns("x", time="t")
    data = MeasuredSource(load_machine(source(text)), path, columns, "x")
    return calibrate_to_data(data, bounds)


def test_values_of_a_decay_have_the_intervals_of_linear_theory(tmp_path: Path) -> None:
    """Five oscillations with white noise, in bounds of 3.3 to 6.4 of them."""
    t = np.arange(0, 3, 0.01)
    x = decay(t) + np.random.default_rng(5).normal(0, NOISE, len(t))
    result = fit(write_record(tmp_path / "x.csv", t, x), BOUNDS).result
    assert result.outcome == "explained"
    assert result.agreeing_starts == result.starts, "also from an oscillation too few"

    def place(values: Array) -> Array:
        return 1e3 * oscillate(0.5, *values, t)

    truth = np.array(list(TRUTH.values()))
    steps = np.diag(1e-5 * truth)
    slopes = np.transpose([(place(truth + s) - place(truth - s)) / (2 * s.sum()) for s in steps])
    covariance = NOISE**2 * np.linalg.inv(slopes.T @ slopes)
    for k, entry in enumerate(result.fitted):
        low, high = entry.interval
        sigma = float(np.sqrt(covariance[k, k]))
        assert (high - low) / 2 == pytest.approx(1.96 * sigma, rel=0.12), "4 % by the noise's size"
        assert abs(entry.value - truth[k]) < 4 * sigma
    assert result.noise.std == pytest.approx(NOISE, rel=0.15)


def test_length_of_a_pendulum_follows_from_its_period(tmp_path: Path) -> None:
    """The record is a cosine of elliptic functions: theta = 2 asin(k cd(w t, k))."""
    from scipy.special import ellipj

    length, start = 930.0, 1.2
    t = np.arange(0, 5, 0.02)
    k = np.sin(start / 2)
    _, cn, dn, _ = ellipj(np.sqrt(9.81 / (1e-3 * length)) * t, k**2)
    angle = np.degrees(2 * np.arcsin(k * cn / dn)) - 90
    path = write_record(tmp_path / "a.csv", t, angle, "t [s],a [deg]")
    words = f"--data {path} --column a --time t --quantity a_deg --fit L_mm=500:1500"
    words += f" --set a_0_rad={start - np.pi / 2!r}"
    result = answer(f"calibrate {source(PENDULUM)} {words}")
    assert result["fitted"][0]["value"] == pytest.approx(length, rel=1e-6)
    assert result["reading"]["duration_s"] == pytest.approx(4.98)
    assert result["reading"]["revolutions"] is None


def test_record_of_a_logger_that_starts_later_is_read(tmp_path: Path) -> None:
    """Milliseconds of a clock, centimetres, semicolons, decimal commas, a text above; it begins
    0.25 s after the release.
    """
    t = np.arange(0, 3, 0.02)
    lines = [
        f"{1e3 * (a + 12.3):.1f};{x / 10:.6f}" for a, x in zip(t, decay(t + 0.25), strict=True)
    ]
    text = "\n".join(["Messung vom 1.2.", "", "Zeit [ms];Weg [cm]", *lines]).replace(".", ",")
    path = tmp_path / "x.csv"
    path.write_text(text, encoding="latin-1")
    words = f"--data {path} --column Weg --time Zeit --quantity x_mm"
    fits = "--fit k_N_m=30:60 --fit c_N_s_m=0.05:1 --fit shift_s=0:0.5 --set x_0_m=0.085"
    result = answer(f"calibrate {source(OSCILLATOR)} {words} {fits}")
    values = [entry["value"] for entry in result["fitted"]]
    assert values == pytest.approx([47.0, 0.31, 0.25], rel=1e-4)
    assert result["fitted"][2]["unit"] == "s"
    assert result["models"]["derived"]["largest_residual_deg"] is None


def test_slopes_of_a_curve_are_those_of_differences_through_contacts(tmp_path: Path) -> None:
    t = np.linspace(0, 0.8, 60)
    path = write_record(tmp_path / "y.csv", t, 200 - 100 * t, "t [s],y [mm]")
    machine = load_machine(source(BALL))
    from planter.measured.calibration import read_measurement

    measured = read_measurement(machine, path, Columns("y", time="t"), ["y"])
    bounds = {"k_N_m": (3000.0, 5000.0), "y_0_m": (0.1, 0.3), "shift_s": (0.0, 0.1)}
    curve = MeasuredCurve(machine, Chosen.from_bounds(machine, bounds), measured, "y")
    z = curve.machine_values() + np.array([0, 0, 0.05])
    slopes = curve(z)[1]
    for column, step in enumerate(np.diag([0.4, 2e-5, 1e-5])):
        expected = (curve(z + step)[0] - curve(z - step)[0]) / (2 * step.sum())
        close = np.abs(slopes[:, column] - expected) <= 1e-4 * np.abs(expected).max()
        assert close.mean() > 0.9, "all but points that a contact passes"
    span = replace(measured, duration=2 * (measured.duration or 0.0))
    assert np.abs(MeasuredCurve(machine, curve.chosen, span, "y")(z)[0] - curve(z)[0]).max() > 1


@pytest.mark.parametrize("oscillations", [8, pytest.param(40, marks=pytest.mark.long)])
def test_a_force_that_the_machine_lacks_is_not_explained(tmp_path: Path, oscillations: int) -> None:
    """The amplitude of dry friction falls linearly, and no viscous damper does so."""
    omega = np.sqrt(40 / 0.5)
    t = np.linspace(0, oscillations * 2 * np.pi / omega, 800)
    x = 100 * (1 - 0.7 * t / t[-1]) * np.cos(omega * t)
    x += np.random.default_rng(2).normal(0, NOISE, len(t))
    path = write_record(tmp_path / "x.csv", t, x)
    result = fit(path, {"k_N_m": (38.0, 42.0), "c_N_s_m": (0.0001, 0.4), "x_0_m": (0.05, 0.2)})
    assert result.result.outcome == "not explained"
    assert result.result.models["derived"].lack_of_fit.probability < 1e-6


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("--time t --fit phase_deg=0:360", "shift_s"),
        ("--time t --fit shift_s=-1:1", "at least 0"),
        ("--angle t --fit k_N_m=20:80", "--angle"),
        ("--fit k_N_m=20:80", "--interval-s"),
        ("--time t --explain --fit k_N_m=20:80", "--explain"),
        ("--time t --fit q_N_m=20:80", "q_N_m"),
    ],
)
def test_what_is_of_an_angle_is_refused(tmp_path: Path, words: str, reason: str) -> None:
    t = np.linspace(0, 1, 40)
    path = write_record(tmp_path / "x.csv", t, decay(t))
    common = f"--data {path} --column x --quantity x_mm"
    assert reason in refusal(f"calibrate {source(OSCILLATOR)} {common} {words}")


def test_a_shift_is_not_of_what_an_angle_drives() -> None:
    machine = load_machine("wang2017")
    from planter.errors import InputError

    with pytest.raises(InputError, match="phase_deg"):
        Chosen.from_bounds(machine, {"shift_s": (0.0, 1.0)})
