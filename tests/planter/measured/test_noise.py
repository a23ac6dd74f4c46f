"""Noise of residuals: its likelihood equals that of dense matrices, intervals hold what they claim,
tests refute.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import binom
from scipy.stats import f as f_distribution

from planter.engine.machine import Machine
from planter.kernels import Array
from planter.measured import reading
from planter.measured.calibration import describe_active_bounds, describe_inputs, judge_fit
from planter.measured.curve import Chosen, MeasuredCurve, find_records, whiten_rows
from planter.measured.fit import Fit, fit_curve
from planter.measured.noise import (
    PLAUSIBLE,
    REFUTING,
    RHOS,
    TREND_DEGREES,
    RhoLikelihood,
    assess_lack_of_fit,
    build_trends,
    compare_nested,
)
from planter.measured.reading import Channel, Columns, Measurement, fourier_basis
from planter.mechanism.model import Model
from planter.numerics.arrays import TURN
from tests.support import own

BOUNDS = {"m_s_kg": (1.0, 3.0), "k_N_m": (300.0, 1500.0), "offset_N": (-60.0, 60.0)}


def correlate(rng: np.random.Generator, count: int, rho: float, std: float) -> Array:
    """Return stationary noise of an autoregression of first order (count,)."""
    noise = rng.normal(0, std, count)
    for i in range(1, count):
        noise[i] = rho * noise[i - 1] + np.sqrt(1 - rho**2) * noise[i]
    return noise


def test_whitening_inverts_covariance_across_gaps() -> None:
    gaps, rho = np.array([1.0, 3.0, 1.0, 2.0, 1.0]), 0.8
    steps = np.concatenate([[0], np.cumsum(gaps)])
    covariance = rho ** np.abs(steps[:, None] - steps)
    rows = whiten_rows(np.eye(len(steps)), gaps, rho)
    assert rows @ covariance @ rows.T == pytest.approx(np.eye(len(steps)), abs=1e-12)


def test_likelihood_equals_dense_formula() -> None:
    """Harville (1977): log |V| + log |X' V^-1 X| + (m - p) log of the generalised sum of squares,
    over minus two.
    """
    rng, count = np.random.default_rng(1), 40
    columns = np.linalg.qr(fourier_basis(np.linspace(0, 5, count), 2)).Q
    residuals, gaps = correlate(rng, count, 0.6, 1.0), np.ones(count - 1)
    likelihood = RhoLikelihood.compute(residuals, columns, gaps)
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    expected = []
    for rho in RHOS[[0, 10, 30]]:
        covariance = rho**lag if rho else np.eye(count)
        inverse = np.linalg.inv(covariance)
        normal = columns.T @ inverse @ columns
        left = residuals - columns @ np.linalg.solve(normal, columns.T @ inverse @ residuals)
        total = left @ inverse @ left
        free = count - columns.shape[1]
        logs = (
            np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1] + free * np.log(total)
        )
        expected.append((-logs / 2, total))
    assert likelihood.logs[[0, 10, 30]] == pytest.approx([value for value, _ in expected], rel=1e-9)
    assert likelihood.sums[[0, 10, 30]] == pytest.approx([total for _, total in expected], rel=1e-9)


def test_nested_comparison_equals_classical_f() -> None:
    rng, phi = np.random.default_rng(3), np.linspace(0, TURN, 90)
    small, large = fourier_basis(phi, 1), fourier_basis(phi, 3)
    values = large @ rng.normal(0, 0.2, 7) + rng.normal(0, 1, 90)
    logs = RhoLikelihood.compute(values, np.linalg.qr(large).Q, np.ones(89)).logs
    probabilities = []
    for rho in RHOS[logs >= logs.max() - PLAUSIBLE]:
        rows = [whiten_rows(x, np.ones(89), float(rho)) for x in (small, large, values)]
        sums = [float(np.linalg.lstsq(x, rows[2], rcond=None)[1][0]) for x in rows[:2]]
        probabilities.append(f_distribution.sf((sums[0] - sums[1]) / 4 / (sums[1] / 83), 4, 83))
    test = compare_nested(values, small, large, np.ones(89))
    assert len(probabilities) > 1
    assert (test.harmonics, test.probability) == (4, pytest.approx(max(probabilities), rel=1e-6))


def fit_truth(
    rng: np.random.Generator, rho: float, revolutions: int, warp: float = 0.0, mu: float = 0.1
) -> tuple[Fit, dict[str, float]]:
    """Return the fit to a curve of random inputs and phase, and these; `warp` adds a fifth harmonic
    [N].

    Friction `mu` of the guide makes the curve jump.
    """
    degrees = np.arange(0, 360 * revolutions, 3.0)
    truth = {
        key: rng.uniform(low + (high - low) / 4, high - (high - low) / 4)
        for key, (low, high) in BOUNDS.items()
    }
    truth["phase_deg"] = rng.uniform(0, 360)
    phi = np.radians(degrees + truth["phase_deg"])
    machine = own.machine("slider_crank", "", m_s_kg=truth["m_s_kg"], k_N_m=truth["k_N_m"], mu=mu)
    values = (
        Model(machine).results(np.mod(phi, TURN))["F_Ox_N"]
        + truth["offset_N"]
        + warp * np.cos(5 * phi)
    )
    values += correlate(rng, len(phi), rho, 0.03 * float(np.ptp(values)))
    channel = Channel("F", "N", values, np.ones(len(phi), dtype=bool), 0.03 * float(np.ptp(values)))
    measured = Measurement(np.radians(degrees), (channel,))
    base = own.machine("slider_crank", "", mu=mu)
    chosen = Chosen.from_bounds(base, {**BOUNDS, "phase_deg": (0.0, 360.0)})
    return fit_curve(MeasuredCurve(base, chosen, measured, "F_Ox_N"), starts=2), truth


def count_covered(fit: Fit, truth: dict[str, float]) -> list[bool]:
    """Return whether the intervals of the inputs hold the truth."""
    covered = []
    for entry in describe_inputs(fit):
        value = truth[entry.name.removeprefix("values.")]
        if entry.name == "phase_deg":  # nearest repetition
            value = entry.value + (value - entry.value + 180) % 360 - 180
        covered.append(entry.interval[0] <= value <= entry.interval[1])
    return covered


def count_covered_angles(fit: Fit, truth: dict[str, float], mu: float = 0.1) -> list[bool]:
    """Return whether the band holds the true curve at four angles."""
    phi = np.array([0.4, 2.0, 3.6, 5.2])
    machine = own.machine("slider_crank", "", m_s_kg=truth["m_s_kg"], k_N_m=truth["k_N_m"], mu=mu)
    curve = (
        Model(machine).results(np.mod(phi + np.radians(truth["phase_deg"]), TURN))["F_Ox_N"]
        + truth["offset_N"]
    )
    values, half_widths = fit.curve_band(phi)
    return (np.abs(values[0] - curve) <= half_widths[0]).tolist()


def judge(fit: Fit) -> str:
    return judge_fit(fit, assess_lack_of_fit(fit.curve, fit.residuals, fit.curve(fit.values)[1]))


def test_intervals_allow_for_correlation() -> None:
    """At 95 % less than 26 of 32 have a probability of 9e-4; intervals for white noise hold about
    half of them.
    """
    rng = np.random.default_rng(6)
    fits = [fit_truth(rng, 0.9, 1) for _ in range(8)]
    covered = [flag for fit, truth in fits for flag in count_covered(fit, truth)]
    assert sum(covered) >= 26
    assert sum(flag for fit, truth in fits for flag in count_covered_angles(fit, truth)) >= 26
    assert sum(judge(fit) == "explained" for fit, _ in fits) >= 7
    rhos = [fit.curve.noises[0].rho for fit, _ in fits]
    assert np.median(rhos) == pytest.approx(0.9, abs=0.08)


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_revolutions_refute_a_wrong_curve(rho: float) -> None:
    """The tampered case: a harmonic of 1.5 deviations that no input gives, over three
    revolutions.
    """
    rng = np.random.default_rng(9)
    good, _ = fit_truth(rng, rho, 3, mu=0.0)
    assert judge(good) == "explained"
    wrong, _ = fit_truth(rng, rho, 3, warp=1.5 * good.curve.noises[0].std, mu=0.0)
    assert (judge(wrong), wrong.is_settled) == ("not explained", True)


@pytest.mark.long
@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_intervals_cover_truths(rho: float) -> None:
    """Over 120 truths of one and two revolutions: 90 to 98 % of all, and of each input and angle
    within chance.
    """
    rng = np.random.default_rng(17)
    fits = [fit_truth(rng, rho, revolutions) for revolutions in (1, 2) for _ in range(60)]
    covered = np.array(
        [[*count_covered(fit, truth), *count_covered_angles(fit, truth)] for fit, truth in fits]
    )
    assert 0.9 <= covered.mean() <= 0.98
    lowest, highest = binom.ppf([5e-4, 1 - 5e-4], len(fits), [0.9, 0.98])
    counts = covered.sum(axis=0)
    assert ((lowest <= counts) & (counts <= highest)).all(), counts
    outcomes = [judge(fit) for fit, _ in fits]
    assert outcomes.count("not settled") <= 12
    assert outcomes.count("not explained") <= 1


def count_trends(
    rho: float, rise: Callable[[Array], Array], records: int = 1, seeds: int = 120
) -> int:
    """Return how often a rise over revolutions is seen in noise of size 1, over records of four."""
    phi = np.concatenate(
        [np.linspace(0, 4 * TURN, 240, endpoint=False) + 9 * TURN * k for k in range(records)]
    )
    numbers, gaps, offset = find_records(phi), np.ones(len(phi) - 1), np.ones((len(phi), 1))
    gaps[np.diff(numbers) > 0] = 500.0
    large = [
        np.column_stack([offset, build_trends(phi, numbers, degree)]) for degree in TREND_DEGREES
    ]
    seen = 0
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        noise = np.concatenate([correlate(rng, 240, rho, 1.0) for _ in range(records)])
        values = noise + rise(np.mod(phi, 9 * TURN) / TURN)
        probabilities = [
            compare_nested(values, offset, columns, gaps).probability for columns in large
        ]
        seen += min(probabilities) * len(large) < REFUTING
    return seen


@pytest.mark.parametrize(("rho", "records"), [(0.0, 1), (0.5, 1), (0.9, 1), (0.97, 1), (0.5, 3)])
def test_noise_without_trend_is_seldom_refuted(rho: float, records: int) -> None:
    assert count_trends(rho, np.zeros_like, records) <= 1


@pytest.mark.parametrize(("rho", "slope"), [(0.0, 0.5), (0.5, 1.0), (0.8, 2.0)])
def test_trend_is_no_noise(rho: float, slope: float) -> None:
    assert count_trends(rho, lambda turns: slope * turns) >= 108


@pytest.mark.parametrize("waves", [0.6, 1.0, 1.37, 2.0])
def test_swinging_zero_is_no_noise(waves: float) -> None:
    assert count_trends(0.5, lambda turns: 5 * np.sin(turns / 4 * waves * TURN + 1), seeds=40) >= 38


def test_records_end_at_gaps_and_steps_back() -> None:
    turn = np.linspace(0, TURN, 60, endpoint=False)
    assert find_records(np.concatenate([turn, turn + TURN])).max() == 0
    assert find_records(-np.concatenate([turn, turn + TURN])).max() == 0
    assert find_records(np.concatenate([turn, turn + 3 * TURN])).tolist() == [0] * 60 + [1] * 60
    assert find_records(np.concatenate([turn + TURN, turn])).max() == 1
    assert find_records(np.delete(turn, slice(10, 40))).max() == 0


DEGREES = np.arange(0, 360, 3.0)
MASS, STIFFNESS = 1.8, 720.0
SCATTER = 1.0


@pytest.fixture(scope="module")
def crank() -> Machine:
    return own.machine("slider_crank", "", m_s_kg=MASS, k_N_m=STIFFNESS)


@pytest.fixture(scope="module")
def measured(crank: Machine) -> Measurement:
    values = Model(crank).results(np.radians(DEGREES))["F_Ox_N"]
    values = values + 2.0 + np.random.default_rng(5).normal(0, SCATTER, len(values))
    return Measurement(
        np.radians(DEGREES), (Channel("F", "N", values, np.ones(len(values), bool), SCATTER),)
    )


def fit_within(crank: Machine, measured: Measurement, **bounds: tuple[float, float]) -> Fit:
    chosen = Chosen.from_bounds(crank, {"m_s_kg": (1.0, 3.0), "offset_N": (-60.0, 60.0)} | bounds)
    return fit_curve(MeasuredCurve(crank, chosen, measured, "F_Ox_N"), starts=2)


def name_bounds(fit: Fit) -> list[tuple[str, str]]:
    return [(bound.name, bound.side) for bound in describe_active_bounds(fit)]


def test_fit_inside_bounds_explains(crank: Machine, measured: Measurement) -> None:
    fit = fit_within(crank, measured)
    assert (judge(fit), name_bounds(fit)) == ("explained", [])


@pytest.mark.parametrize(("low", "high", "side"), [(1.0, 1.797, "upper"), (1.803, 3.0, "lower")])
def test_fit_on_a_bound_is_not_settled(
    crank: Machine, measured: Measurement, low: float, high: float, side: str
) -> None:
    """The tampered case: a bound less than a deviation from the truth, so that noise alone is
    left.
    """
    fit = fit_within(crank, measured, m_s_kg=(low, high))
    assert (judge(fit), name_bounds(fit)) == ("not settled", [("values.m_s_kg", side)])


def test_bound_without_effect_does_not_count(crank: Machine, measured: Measurement) -> None:
    """The data depend on the inertia of the crank by less than their noise."""
    fit = fit_within(crank, measured, J_kg_m2=(0.0039, 0.0041))
    lower, upper = fit.curve.bounds(fit.values)
    assert np.isclose(fit.values, [lower, upper], rtol=1e-6).any(axis=0)[2], "on a bound"
    assert (judge(fit), name_bounds(fit)) == ("explained", [])


BALER = "hay_baler"
TRUTH = {"m_p_kg": 134.0, "F_h_N": 52000.0, "offset_N": 250.0}
SPEED = 95.0
NOISE = 560.0


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    """Return the force of a baler whose load ends in a jump, by a logger that takes the mean over
    each step.
    """
    rng, times = np.random.default_rng(5), np.arange(0, 5, 1e-3)
    file = own.file(BALER, m_p_kg=TRUTH["m_p_kg"], F_h_N=TRUTH["F_h_N"], omega_rpm=SPEED)
    angles = 1.234 + SPEED / 60 * TURN * times
    noise = correlate(rng, len(times), 0.9, NOISE)
    step_angles = angles[:, None] + SPEED / 60 * TURN * 1e-3 * np.linspace(-0.5, 0.5, 11)
    means = (
        own.evaluate_lane(file, np.mod(step_angles.ravel(), TURN))["F_Ox"]
        .reshape(step_angles.shape)
        .mean(axis=1)
    )
    force = means + TRUTH["offset_N"] + noise
    pulse = np.where(np.mod(angles, TURN) < 0.15, 5.0, 0.0)
    path = tmp_path_factory.mktemp("baler") / "force.csv"
    rows = np.column_stack([times, pulse, force])
    np.savetxt(path, rows, "%.6g", ",", header="time [s],pulse [V],force [N]", comments="")
    return reading.read(path, Columns("force", time="time", trigger="pulse"), SPEED / 60 * TURN)


def fit_baler(measured: Measurement, starts: int = 8) -> Fit:
    machine = Model(own.machine(BALER)).machine
    bounds = {
        "m_p_kg": (80, 200),
        "F_h_N": (40e3, 90e3),
        "offset_N": (-1000, 1000),
        "phase_deg": (0, 360),
    }
    return fit_curve(
        MeasuredCurve(machine, Chosen.from_bounds(machine, bounds), measured, "F_Ox_N"),
        starts=starts,
    )


def find_errors(fit: Fit) -> Array:
    """Return the errors (3,) of the fitted inputs, in halves of their intervals."""
    widths = [np.diff(fit.band(index))[0] / 2 for index in range(3)]
    return (fit.values[:3] - np.array(list(TRUTH.values()))) / np.array(widths)


def test_inputs_of_a_curve_that_jumps_are_found(record):
    assert np.abs(find_errors(fit_baler(record))).max() < 1.6
    assert record.noise == pytest.approx(NOISE, rel=0.1)
    assert record.channels[0].rho == pytest.approx(0.9, abs=0.03)
    (entry,) = (entry for entry in record.reading.dropped if "beside a jump" in entry.reason)
    assert 7 * 4 <= entry.count <= 8 * 6


def test_points_beside_jumps_mislead_a_fit(record, monkeypatch):
    monkeypatch.setattr(reading, "JUMP", np.inf)
    with_jumps = reading.read(
        record.reading.file, Columns("force", time="time", trigger="pulse"), SPEED / 60 * TURN
    )
    assert with_jumps.used.sum() > record.used.sum()
    fit = fit_baler(with_jumps, starts=2)
    assert abs(fit.values[1] - TRUTH["F_h_N"]) > 10 * np.sqrt(
        fit_baler(record, starts=2).covariance[1, 1]
    )


@pytest.mark.parametrize("shape", ["noise", "spikes", "steep"])
def test_what_is_no_jump_stays(shape):
    rng, phi = np.random.default_rng(2), np.linspace(0, 3 * TURN, 1081)
    values = rng.normal(0, 1, len(phi)) + {"noise": 0, "spikes": 20, "steep": 200}[shape] * np.tanh(
        3 * np.sin(phi)
    )
    if shape == "spikes":
        values[rng.integers(20, 1060, 9)] += 500
    channel, beside_jumps = reading._build_channel("F", "N", values, phi)
    assert not beside_jumps.any()
    assert (~channel.used).sum() == pytest.approx(9 if shape == "spikes" else 0, abs=1)
