"""Any machine on a motor: reduced inertia by hand, energy, loops along the way, other integrators,
refusals.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.integrate

from derive import Mechanism, quantities
from derive.mechanics.statement import MechanismError
from planter.engine.drive import DrivenMachine, Motor, drive_machine
from planter.engine.machine import Machine
from planter.errors import ComputationError, InputError
from planter.mechanism.cycle import simulate_machine
from planter.mechanism.machines import build_machine
from tests.support import own

SPEED = 300 * np.pi / 30
MOTOR = Motor(20.0, 1.07 * SPEED, 0.02)
PHI = np.radians(np.arange(0.0, 360.0, 5.0))


@cache
def machine(**values: float) -> Machine:
    return build_machine(own.file("slider_crank", "", **values))


def test_reduced_inertia_equals_kinetic_energy() -> None:
    """Of rod and slider without friction, by their velocities over that of the crank."""
    driven = DrivenMachine(machine(mu=0.0), MOTOR, ["M_in"])
    r, rod, e, c, m_r, m_s, inertia = 0.05, 0.2, 0.01, 0.08, 0.8, 1.5, 0.004
    across = e - r * np.sin(PHI)
    projection = np.sqrt(rod**2 - across**2)
    turning = -r * np.cos(PHI) / projection
    slider = -r * np.sin(PHI) - across * turning
    x = -r * np.sin(PHI) - c * across / rod * turning
    y = r * np.cos(PHI) + c * projection / rod * turning
    expected = m_s * slider**2 + m_r * (x**2 + y**2) + inertia * turning**2
    state = driven.state(PHI, np.full_like(PHI, SPEED), np.zeros_like(PHI))
    assert state.inertia == pytest.approx(expected, rel=1e-9)
    slower = driven.state(PHI, np.full_like(PHI, SPEED / 2), np.full_like(PHI, 7.0))
    still = driven.state(PHI, np.full_like(PHI, SPEED / 2), np.zeros_like(PHI))
    assert slower.load - still.load == pytest.approx(7.0 * expected, rel=1e-8)


def test_laws_hold_at_an_acceleration() -> None:
    result = simulate_machine(own.machine("slider_crank", eps_rad_s2=300.0, mu=0.3), 36).result
    assert max(law.violation for law in result.laws) < 1e-10
    plain = simulate_machine(own.machine("slider_crank", mu=0.3), 36).result
    assert abs(result.quantities["M_in_Nm"].max - plain.quantities["M_in_Nm"].max) > 0.1


def test_acceleration_requires_an_angle() -> None:
    q = quantities(
        "phi | rad | angle\nomega | rad/s | speed\neps | rad/s2 | acceleration\nslow | m/s2 | none"
    )
    with pytest.raises(MechanismError, match="which is lacking"):
        Mechanism("free", q, acceleration=q.eps)
    with pytest.raises(MechanismError, match="m/s2"):
        Mechanism("driven", q, angle=q.phi, speed=q.omega, acceleration=q.slow)


def test_motor_work_equals_friction_loss() -> None:
    drive = drive_machine(own.machine("slider_crank"), MOTOR, turns=2, samples=720)
    turn, result = drive.turn, drive.result
    assert turn.omega[-1] == pytest.approx(turn.omega[0], rel=1e-9)
    assert result.motor_work_J == pytest.approx(result.friction_work_J, rel=2e-5)
    assert result.imbalance_W < 1e-10
    kinetic = 0.02 + drive.driven.inertia
    rise = np.gradient(kinetic * turn.omega**2 / 2, turn.phi)
    assert np.ptp(rise) > 1.0, "energy moves between flywheel and mechanism"
    assert drive.columns().keys() >= {"phi_deg", "F_Ox_N", "constant_F_Ox_N", "motor_Nm"}


def test_another_integrator_finds_the_same_speed() -> None:
    driven = DrivenMachine(machine(), MOTOR, [])
    at = driven.run(SPEED, 1, 36)

    def rates(phi: float, omega: np.ndarray) -> np.ndarray:
        slope: np.ndarray = driven.acceleration(np.array([phi]), omega) / omega
        return slope

    solution = scipy.integrate.solve_ivp(
        rates, (0, 1), [SPEED], "LSODA", [np.radians(50)], rtol=1e-9, atol=1e-10
    )
    assert solution.y[0, 0] == pytest.approx(at.omega[5], rel=1e-7)


def test_a_heavy_flywheel_keeps_the_speed() -> None:
    results = [
        drive_machine(own.machine("slider_crank"), replace(MOTOR, flywheel=j), 1).result
        for j in (1e3, 1e5)
    ]
    assert results[0].speed.fluctuation / results[1].speed.fluctuation == pytest.approx(
        100, rel=1e-2
    )
    assert (
        max(quantity.change for quantity in results[1].quantities.values() if quantity.unit == "N")
        < 1e-3
    )


def test_undrivable_machine_is_refused() -> None:
    base = machine()
    with pytest.raises(InputError, match=r"acceleration=q\.eps"):
        DrivenMachine(replace(base, acceleration=None), MOTOR)
    with pytest.raises(InputError, match="no torque of a motor"):
        DrivenMachine(replace(base, motors=()), MOTOR)
    with pytest.raises(InputError, match="one motor"):
        DrivenMachine(replace(base, motors=("M_in", "M_guide")), MOTOR)
    with pytest.raises(InputError, match="omega_rpm = -300"):
        DrivenMachine(machine(omega_rpm=-300.0), MOTOR)
    with pytest.raises(ComputationError, match="stalls"):
        DrivenMachine(base, replace(MOTOR, stall=0.01, flywheel=1e-4), []).run(SPEED, 20, 36)
