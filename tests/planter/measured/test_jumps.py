"""Records of curves that jump: points beside a jump tell of a step of the angle, and are left
out.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.kernels import Array
from planter.measured import reading
from planter.measured.curve import Chosen, MeasuredCurve
from planter.measured.fit import Fit, fit_curve
from planter.measured.reading import Columns, Measurement
from planter.mechanism.model import Model
from planter.numerics.arrays import TURN
from tests.support import own

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
    noise = rng.normal(0, NOISE, len(times))
    for i in range(1, len(noise)):
        noise[i] = 0.9 * noise[i - 1] + np.sqrt(1 - 0.9**2) * noise[i]
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
