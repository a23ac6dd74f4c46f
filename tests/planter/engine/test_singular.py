"""Quantities without a derivative at an angle, 0/0 in their graph: what is finite is given, and its
sides are taken.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.engine.machine import Machine
from planter.engine.outputs import SampledOutputs
from planter.engine.response import MachineResponse
from planter.errors import ComputationError
from planter.mechanism.cycle import simulate_machine
from planter.mechanism.optimisation import compute_objective_sensitivity, optimise_machine
from tests.support import own

STATEMENT = '''
from sympy import Max, Piecewise, Rational, cos, pi, sin, sqrt
from derive import Formulas, quantities
q = quantities("""
    t | rad   | angle
    n | rad/s | its speed | 1
    r | m     | radius    | 1   | 0.5 2
    s | m     | shift     | 0.3 | 0 0.6
    R0 | m | chord from the point at 0 deg
    R1 | m | chord from the point at 40 deg
    R2 | m | chord from the point at 90 deg
    R3 | m | norm that rests at zero
    R4 | m | pole at 41 deg
    R5 | m | wave
""")
f = Formulas("singular", given=q, angle=q.t, speed=q.n)


def chord(degrees):
    at = Rational(degrees, 180) * pi
    return sqrt((q.r * cos(q.t) - q.r * cos(at)) ** 2 + (q.r * sin(q.t) - q.r * sin(at)) ** 2)


f.defines(q.R0, chord(0))
f.defines(q.R1, chord(40))
f.defines(q.R2, chord(90))
rest = Max(q.r * cos(q.t), 0)
f.defines(q.R3, sqrt(rest**2 + (rest * sin(q.t)) ** 2))
f.defines(q.R4, q.s**2 / (q.r * sin(q.t - Rational(41, 180) * pi + Rational(1, 10**7))))
f.defines(q.R5, q.s + q.r * cos(q.t))
SYSTEM = f.system()
'''
CHORDS = {"R0": 0.0, "R1": 40.0, "R2": 90.0}
MEAN = 4 / np.pi
"""Mean of the chord 2 r |sin((t - t0) / 2)| of a circle, in radii."""


@pytest.fixture(scope="module")
def machine() -> Machine:
    return own.machine(STATEMENT, "singular")


def test_summary_has_vanishing_norms(machine: Machine) -> None:
    result = simulate_machine(machine).result
    assert result.designer is not None
    peaks = {peak.name: peak for peak in result.designer.peaks}
    assert peaks.keys() >= {*CHORDS, "R3", "R5"}
    for name in CHORDS:
        assert peaks[name].mean == pytest.approx(1e3 * MEAN, rel=1e-9)
        assert peaks[name].rms == pytest.approx(1e3 * np.sqrt(2), rel=1e-9)
        assert peaks[name].max == pytest.approx(2e3, rel=1e-12)
    assert (peaks["R0"].min, peaks["R0"].min_phi_deg) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert peaks["R5"].mean == pytest.approx(300.0, rel=1e-12)
    assert peaks["R3"].max == pytest.approx(1e3, rel=1e-12)
    assert not any(name in warning.message for warning in result.warnings for name in CHORDS)


@pytest.mark.parametrize("name", CHORDS)
@pytest.mark.parametrize("samples", [360, None])
def test_gradient_takes_a_side(machine: Machine, name: str, samples: int | None) -> None:
    for kind, expected in (("mean", MEAN), ("rms", np.sqrt(2)), ("max", 2.0)):
        result = compute_objective_sensitivity(machine, samples, f"{kind} {name}")
        rel = 1e-9 if samples is None else 1e-4
        assert result.gradient["r_m"] == pytest.approx(1e3 * expected, rel=rel)
        assert result.gradient["s_m"] == 0.0


@pytest.mark.parametrize("count", [1, 80])
def test_sampled_slopes_take_a_side(machine: Machine, count: int) -> None:
    outputs = SampledOutputs(
        machine, ["values.r_m", "values.s_m"], ["mean R0", "R2_rms_mm", "R5_mean_mm"]
    )
    values, slopes = outputs.gradients(np.tile([1.0, 0.3], (count, 1)), 1)
    expected = np.array([[1e3 * MEAN, 0], [1e3 * np.sqrt(2), 0], [0, 1e3]])
    np.testing.assert_allclose(slopes, np.tile(expected, (count, 1, 1)), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(values[:, 0], 1e3 * MEAN, rtol=1e-9)


def test_search_passes_vanishing_norms(machine: Machine) -> None:
    for sum_text, optimum in (
        ("range R0", 1e3),
        ("mean R2", 500 * MEAN),
        ("rms R1", 500 * np.sqrt(2)),
    ):
        result = optimise_machine(machine, sum_text).result
        assert result.design["r_m"] == pytest.approx(0.5)
        assert result.objective == pytest.approx(optimum, rel=1e-9)


def test_rest_at_zero_has_no_slopes_and_says_so(machine: Machine) -> None:
    response = MachineResponse(machine, ["R5", "R3"])
    with pytest.raises(ComputationError, match=r"the derivative of R3 .* is not finite at 180 deg"):
        response.slopes(response.at(machine.design), np.array([0.1, np.pi]))


def test_pole_between_samples_leaves_the_rest(machine: Machine) -> None:
    response = MachineResponse(machine, ["R4"])
    peak = float(np.abs(response.values(response.at(machine.design), machine.list_angles())).max())
    assert np.isfinite(peak)
    result = simulate_machine(machine).result
    assert result.designer is not None
    assert "R5" in {peak.name for peak in result.designer.peaks}
