"""Driven mechanisms that are released: the ideal forces as a limit, the balance of energy, events, a motor line."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from derive import ElasticTeeth, GearContact, Mechanism, Release, ReleasedMechanism, quantities
from derive.mechanics.statement import MechanismError
from planter.kernels import Array
from planter.mechanism.dynamics import MotionRun
from tests.support import own

TRAIN = "released_train"
SPEED = 2 * np.pi


@cache
def measure_errors(factor: float, frame_mass: float = 5.0) -> Array:
    """Return the largest errors (2,) [N] of the force of the mount without backlash, along x and y."""
    stiff = {"b_mm": 0, "K_N_m": 1e6 * factor, "K_f_N_m": 1e6 * factor, "M_0_Nm": 600 * factor}
    damped = {"C_N_s_m": 400 * np.sqrt(factor), "C_f_N_s_m": 2000 * np.sqrt(factor)}
    run = own.dynamics(TRAIN, **stiff, **damped).run(np.array([0, *np.linspace(0.6, 1.1, 41)]), 1e-8)
    ideal = own.evaluate_lane(own.file(TRAIN, "ideal_train"), SPEED * run.times)
    weight = {"x": 0.0, "y": frame_mass * 9.81}
    return np.array([
        np.abs(run.results[f"F_mount{axis}"] - ideal[f"F_sun{axis}"] - ideal[f"F_O{axis}"] - weight[axis])[1:].max()
        for axis in "xy"
    ])  # fmt: skip


def test_stiff_released_train_has_ideal_support_force():
    errors = np.array([measure_errors(factor) for factor in (1, 2)])
    assert errors[1].max() < 0.004
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.02)


def test_support_force_without_the_weight_of_the_frame_is_off():
    assert measure_errors(1, frame_mass=0.0)[1] > 40


def run_loose_train(times: Array, tolerance: float = 1e-9) -> MotionRun:
    return own.dynamics(TRAIN).run(times, tolerance)


@cache
def integrate_powers() -> tuple[float, dict[str, float]]:
    """Return the change of energy [J], and the work [J] of each element, by Gauss's rule between the events."""
    end = 0.06
    events = [event.time for event in run_loose_train(np.array([0, end])).events]
    edges = np.unique([*events, *np.linspace(0, end, 601)])
    edges = edges[np.diff(edges, prepend=-1) > 1e-9]
    places, weights = np.polynomial.legendre.leggauss(4)
    halves = np.diff(edges)[:, None] / 2
    times = (edges[:-1, None] + halves * (places + 1)).ravel()
    run = run_loose_train(np.array([0, *times, end]))
    speeds = run.states[run.states.shape[0] // 2 :][1:3]
    powers = {"motor": run.results["P_M_in"], "P": run.results["P_P"], "Q": run.results["P_Q"]}
    powers |= {"mount": -2000 * (speeds**2).sum(axis=0)}
    energy = run.results["kinetic"] + run.results["potential"]
    return energy[-1] - energy[0], {name: power[1:-1] @ (halves * weights).ravel() for name, power in powers.items()}


def test_energy_of_loose_train_changes_by_the_work_of_its_elements():
    change, works = integrate_powers()
    assert change == pytest.approx(sum(works.values()), abs=1e-8)
    assert works["mount"] < 0
    assert all(works[tag] < 0 for tag in "PQ")


def test_energy_without_the_work_of_a_mesh_does_not_balance():
    change, works = integrate_powers()
    assert abs(change - sum(works.values()) + works["Q"]) > 1e-6


def test_times_of_contact_do_not_depend_on_output_times():
    coarse, fine = (run_loose_train(np.linspace(0, 0.06, points)).events for points in (2, 173))
    assert len(coarse) >= 4
    assert [event.event for event in coarse] == [event.event for event in fine]
    assert [event.time for event in coarse] == pytest.approx([event.time for event in fine], abs=1e-10)


FLYWHEEL = """
from derive import Mechanism, Release, ReleasedMechanism, quantities
q = quantities('''
    phi   | rad   | crank
    omega | rad/s | its speed | 2
    M_0   | N m   | at rest   | 3
    W     | rad/s | idle      | 10
    J_f   | kg m2 | flywheel  | 0.2
''')
m = ReleasedMechanism("own", q, Release(lambda speed: q.M_0 * (1 - speed / q.W), q.J_f), angle=q.phi, speed=q.omega)
crank = m.body("crank", m.frame("crank", q.phi))
m.pin("O", crank, m.ground, m.O)
m.motor("M_in", crank, m.ground, m.O)
SYSTEM = m.system()
"""


def test_flywheel_on_a_motor_line_approaches_the_idle_speed():
    run = own.dynamics(FLYWHEEL, "own", omega_start_rad_s=4).run(np.linspace(0, 2, 9), 1e-11)
    expected = 10 - 6 * np.exp(-3 / (10 * 0.2) * run.times)
    assert run.states[1] == pytest.approx(expected, rel=1e-9)
    assert run.results["kinetic"] == pytest.approx(0.1 * expected**2, rel=1e-9)
    assert run.results["M_in"] == pytest.approx(3 * (1 - expected / 10), rel=1e-8)


GIVEN = quantities("""
    phi   | rad   | pinion
    omega | rad/s | its speed      | 10
    r     | m     | pinion         | 0.02
    R     | m     | wheel          | 0.04
    m     | kg    | wheel          | 1
    J     | kg m2 | its inertia    | 1e-4
    alpha | rad   | pressure angle | 0.35
    K     | N/m   | stiffness      | 1e8
""")


def state_pair(coordinate: str, swap: bool) -> Mechanism:
    q = GIVEN
    release = Release(lambda speed: 0 * q.K * q.R, teeth={"P": ElasticTeeth(coordinate, lambda depth, _: q.K * depth)})
    m = ReleasedMechanism("pair", q, release, angle=q.phi, speed=q.omega)
    theta = m.coordinate("theta", "rad", "wheel", equals=-q.phi * q.r / q.R)
    D = m.point("D", m.O, m.world, q.r + q.R)
    gears = m.body("pinion", m.frame("pinion", q.phi)), m.body("wheel", m.frame("wheel", theta), q.m, D, q.J)
    m.mesh("P", *(reversed(gears) if swap else gears), GearContact(m.world, D, q.R, q.alpha))
    return m


@pytest.mark.parametrize(("coordinate", "swap", "message"), [("theta", True, "theta must turn"), ("chi", False, "chi")])
def test_teeth_of_another_coordinate_are_refused(coordinate, swap, message):
    with pytest.raises(MechanismError, match=message):
        state_pair(coordinate, swap)


def test_freed_coordinates_start_as_they_were_driven():
    dynamics = own.dynamics(TRAIN)
    start = dict(zip(dynamics.names, dynamics.start(), strict=True))
    ideal = own.evaluate_lane(own.file(TRAIN, "ideal_train"), np.zeros(1))
    for name in ("psi", "psi_dot", "chi", "chi_dot"):
        assert start[name] == pytest.approx(ideal[name][0], abs=1e-12)
