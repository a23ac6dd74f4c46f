"""Coupled drives, cycles of several turns, and unequal sides, held against closed forms and virtual
work.
"""

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.kernels import Array
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from tests.support import own

TURN = np.linspace(0.05, 6.2, 83)
STEP = 1e-4
FIVE_BAR = (own.EXAMPLES / "geared_five_bar.py").read_text()
TWO_TURNS = FIVE_BAR.replace(
    'psi = m.coordinate("psi", "rad", "second crank", equals=q.ratio * q.phi)',
    'theta = m.coordinate("theta", "rad", "first crank", equals=2 * q.phi)\n'
    'psi = m.coordinate("psi", "rad", "second crank", equals=q.ratio * theta)',
).replace('m.frame("crank1", q.phi)', 'm.frame("crank1", theta)')


def compute_pump_torque(masses: Array, loads: Array) -> Array:
    """The crank's torque (n,): that of three slider-cranks by the closed form, a third of a turn
    apart.
    """
    speed, r, rod = 600 * np.pi / 30, 0.02, 0.09
    torque = np.zeros_like(TURN)
    for k, (mass, load) in enumerate(zip(masses, loads, strict=True)):
        a = TURN - 2 * np.pi * k / 3
        root = np.sqrt(rod**2 - (r * np.sin(a)) ** 2)
        slope = -r * np.sin(a) - r**2 * np.sin(a) * np.cos(a) / root
        bend = (
            -r * np.cos(a) - r**2 * np.cos(2 * a) / root - r**4 * np.sin(2 * a) ** 2 / (4 * root**3)
        )
        torque += slope * (mass * speed**2 * bend + load * (slope > 0))
    return torque


def test_pump_adds_unequal_cylinders() -> None:
    values = Model(own.machine("radial_pump"))(TURN)
    masses, loads = np.array([0.6, 0.6, 0.9]), np.array([400, 400, 600])
    assert values["M_in"] == pytest.approx(compute_pump_torque(masses, loads), abs=1e-10)
    assert np.abs(values["M_in"] - compute_pump_torque(masses[[0, 0, 0]], loads)).max() > 0.1
    equal = Model(own.machine("radial_pump", m_3_kg=0.6, F_3_N=400.0))(TURN)
    third = Model(own.machine("radial_pump", m_3_kg=0.6, F_3_N=400.0))(TURN + 2 * np.pi / 3)
    assert equal["M_in"] == pytest.approx(third["M_in"], abs=1e-9), (
        "equal cylinders repeat three times a turn"
    )


def find_tool(first: Array, second: Array) -> Array:
    """Places (2, n) of the five-bar's tool at the angles of both cranks, where the circles of the
    rods meet above.
    """
    a = 0.04 * np.array([np.cos(first), np.sin(first)])
    b = np.array([0.12 + 0.03 * np.cos(second), 0.03 * np.sin(second)])
    d = b - a
    long = np.hypot(*d)
    foot = (0.15**2 - 0.14**2 + long**2) / (2 * long)
    place: Array = a + (foot * d + np.sqrt(0.15**2 - foot**2) * np.array([-d[1], d[0]])) / long
    return place


def compute_torques(first: Array, ratio: float, speed: float) -> tuple[Array, Array]:
    """Both motors' torques (n,) by virtual work: the force on the tool, times its path as one crank
    alone turns.
    """
    now, after, before = (find_tool(first + h, ratio * (first + h)) for h in (0, STEP, -STEP))
    force = 2 * ((after - 2 * now + before) / STEP**2 * speed**2 + np.array([[0.0], [9.81]]))
    slopes = (
        find_tool(first + h, ratio * first + k) - find_tool(first - h, ratio * first - k)
        for h, k in ((STEP, 0), (0, STEP))
    )
    by_first, by_second = ((force * slope).sum(0) / (2 * STEP) for slope in slopes)
    return by_first, by_second


def test_both_motors_of_five_bar_do_the_virtual_work() -> None:
    values = Model(own.machine("geared_five_bar"))(TURN)
    expected = compute_torques(TURN, -2, 2 * np.pi)
    assert np.array([values["M_1"], values["M_2"]]) == pytest.approx(np.array(expected), abs=1e-5)
    assert np.array([values["x_P"], values["y_P"]]) == pytest.approx(
        find_tool(TURN, -2 * TURN), abs=1e-12
    )


def test_cycle_of_two_turns_repeats_where_one_does_not() -> None:
    with pytest.raises(ComputationError, match="does not repeat after one turn"):
        compute_cycle(Model(own.machine("geared_five_bar", ratio=-0.5)), 90)
    machine = own.machine(TWO_TURNS, "geared_five_bar", ratio=-0.5, omega_rpm=30.0)
    cycle = compute_cycle(Model(machine), 90).result
    assert not cycle.not_repeating
    assert max(law.violation for law in cycle.laws) < 1e-10
    values = Model(machine)(TURN)
    expected = compute_torques(2 * TURN, -0.5, 2 * np.pi)
    assert np.array([values["M_1"], values["M_2"]]) == pytest.approx(np.array(expected), abs=1e-5)
