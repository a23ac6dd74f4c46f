"""The belt drive of the examples, held against the damped oscillator in closed form and a second
integration.
"""

import numpy as np
import pytest
import scipy.integrate

from planter.kernels import Array
from planter.mechanism.dynamics import MotionRun
from tests.support import own

FIRST_RADIUS, SECOND_RADIUS, DISTANCE = 0.06, 0.12, 0.4
FIRST_INERTIA, SECOND_INERTIA = 0.01, 0.2
STIFFNESS, DAMPING = 50000.0, 20.0
COMPLIANCE = FIRST_RADIUS**2 / FIRST_INERTIA + SECOND_RADIUS**2 / SECOND_INERTIA
TIMES = np.linspace(0, 0.3, 61)


def run(**values: float) -> MotionRun:
    return own.dynamics("belt_drive", "", **values).run(TIMES)


def compute_stretch(motion: MotionRun) -> Array:
    stretch: Array = FIRST_RADIUS * motion.states[0] - SECOND_RADIUS * motion.states[1]
    return stretch


def test_taut_belt_is_a_damped_oscillator() -> None:
    """Of e = r_1 a_1 - r_2 a_2: e'' + 2 w (c e' + k e) = r_1 M / J_1, with w = r_1^2 / J_1 + r_2^2
    / J_2.
    """
    motion = run()
    decay, rest = (
        COMPLIANCE * DAMPING,
        FIRST_RADIUS * 5 / FIRST_INERTIA / (2 * COMPLIANCE * STIFFNESS),
    )
    root = np.sqrt(2 * COMPLIANCE * STIFFNESS - decay**2)
    swing = np.exp(-decay * TIMES) * (np.cos(root * TIMES) + decay / root * np.sin(root * TIMES))
    assert compute_stretch(motion) == pytest.approx(rest * (1 - swing), abs=1e-10)


def test_speeds_keep_angular_impulse() -> None:
    """The belt transmits moments in the ratio of the radii: J_1 w_1 / r_1 + J_2 w_2 / r_2 = M t /
    r_1.
    """
    for preload in (300.0, 5.0):
        states = run(T_0_N=preload).states
        impulse = (
            FIRST_INERTIA * states[2] / FIRST_RADIUS + SECOND_INERTIA * states[3] / SECOND_RADIUS
        )
        assert impulse == pytest.approx(5 * TIMES / FIRST_RADIUS, abs=1e-7)


def test_shaft_carries_both_spans() -> None:
    results = run().results
    lean = (FIRST_RADIUS - SECOND_RADIUS) / DISTANCE
    pull, difference = results["T_u"] + results["T_l"], results["T_u"] - results["T_l"]
    assert pull == pytest.approx(600, rel=1e-12)
    assert results["F_Sx"] == pytest.approx(pull * np.sqrt(1 - lean**2), rel=1e-9)
    assert results["F_Sy"] == pytest.approx(-lean * difference, abs=1e-7)
    assert results["F_Ox"] == pytest.approx(-results["F_Sx"], rel=1e-9)


def test_slack_span_does_not_push() -> None:
    def differentiate(_: float, state: Array) -> Array:
        pull = STIFFNESS * state[0] + DAMPING * state[1]
        net = max(5 + pull, 0) - max(5 - pull, 0)
        return np.array([state[1], FIRST_RADIUS * 5 / FIRST_INERTIA - COMPLIANCE * net])

    expected = scipy.integrate.solve_ivp(
        differentiate, (0, TIMES[-1]), [0, 0], "DOP853", TIMES, rtol=1e-11, atol=1e-14
    )
    motion = run(T_0_N=5.0)
    assert motion.results["T_l"].min() == 0.0
    assert compute_stretch(motion) == pytest.approx(expected.y[0], abs=1e-8)
    taut = compute_stretch(run())
    assert np.abs(taut - expected.y[0]).max() > 1e-4
