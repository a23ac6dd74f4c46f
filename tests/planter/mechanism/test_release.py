"""Driven mechanisms that are released: the ideal forces as a limit, the balance of energy, events,
a motor line.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from derive import (
    ElasticTeeth,
    GearContact,
    LiftingFollower,
    LoosePin,
    Mechanism,
    Release,
    ReleasedMechanism,
    quantities,
)
from derive.mechanics.statement import MechanismError
from planter.kernels import Array
from planter.mechanism.dynamics import MotionRun
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from tests.support import own

TRAIN, PRESS = "released_train", "released_press"
SPEED = 2 * np.pi


@cache
def measure_errors(factor: float, frame_mass: float = 5.0) -> Array:
    """Return the largest errors (2,) [N] of the force of the mount without backlash, along x and
    y.
    """
    stiff = {"b_mm": 0, "K_N_m": 1e6 * factor, "K_f_N_m": 1e6 * factor, "M_0_Nm": 600 * factor}
    damped = {"C_N_s_m": 400 * np.sqrt(factor), "C_f_N_s_m": 2000 * np.sqrt(factor)}
    run = own.dynamics(TRAIN, **stiff, **damped).run(
        np.array([0, *np.linspace(0.6, 1.1, 41)]), 1e-8
    )
    ideal = own.evaluate_lane(own.file(TRAIN, "ideal_train"), SPEED * run.times)
    weight = {"x": 0.0, "y": frame_mass * 9.81}
    return np.array(
        [
            np.abs(
                run.results[f"F_mount{axis}"]
                - ideal[f"F_sun{axis}"]
                - ideal[f"F_O{axis}"]
                - weight[axis]
            )[1:].max()
            for axis in "xy"
        ]
    )


@pytest.mark.long
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
    """Return the change of energy [J], and the work [J] of each element, by Gauss's rule between
    the events.
    """
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
    return energy[-1] - energy[0], {
        name: power[1:-1] @ (halves * weights).ravel() for name, power in powers.items()
    }


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
    assert [event.time for event in coarse] == pytest.approx(
        [event.time for event in fine], abs=1e-10
    )


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
    release = Release(
        lambda speed: 0 * q.K * q.R,
        teeth={"P": ElasticTeeth(coordinate, lambda depth, _: q.K * depth)},
    )
    m = ReleasedMechanism("pair", q, release, angle=q.phi, speed=q.omega)
    theta = m.coordinate("theta", "rad", "wheel", equals=-q.phi * q.r / q.R)
    D = m.point("D", m.O, m.world, q.r + q.R)
    gears = (
        m.body("pinion", m.frame("pinion", q.phi)),
        m.body("wheel", m.frame("wheel", theta), q.m, D, q.J),
    )
    m.mesh("P", *(reversed(gears) if swap else gears), GearContact(m.world, D, q.R, q.alpha))
    return m


@pytest.mark.parametrize(
    ("coordinate", "swap", "message"), [("theta", True, "theta must turn"), ("chi", False, "chi")]
)
def test_teeth_of_another_coordinate_are_refused(coordinate, swap, message):
    with pytest.raises(MechanismError, match=message):
        state_pair(coordinate, swap)


def test_freed_coordinates_start_as_they_were_driven():
    dynamics = own.dynamics(TRAIN)
    start = dict(zip(dynamics.names, dynamics.start(), strict=True))
    ideal = own.evaluate_lane(own.file(TRAIN, "ideal_train"), np.zeros(1))
    for name in ("psi", "psi_dot", "chi", "chi_dot"):
        assert start[name] == pytest.approx(ideal[name][0], abs=1e-12)


def test_press_starts_as_it_is_driven_with_the_pin_in_the_middle():
    dynamics = own.dynamics(PRESS)
    start = dict(zip(dynamics.names, dynamics.start(), strict=True))
    ideal = own.evaluate_lane(own.file(PRESS, "ideal_press"), np.zeros(1))
    assert start["omega"] == pytest.approx(20 * np.pi, rel=1e-14)
    for name in ("beta", "beta_dot", "s", "s_dot", "u", "u_dot"):
        assert start[name] == pytest.approx(ideal[name][0], abs=1e-12)
    assert dynamics.run(np.array([0, 1e-6])).results["gap_B"][0] == pytest.approx(1e-4, abs=1e-12)


def measure_press(factor: float, clearance: float) -> Array:
    """Return the largest errors (3,) [N] of two forces of the ground and of the cam, after the
    start has settled.
    """
    stiff = {"K_N_m": 1e7, "K_e_N_m": 1e6, "J_f_kg_m2": 20, "M_0_Nm": 6e4}
    damped = {"C_N_s_m": 4e3, "C_e_N_s_m": 1e3}
    values = {name: factor * value for name, value in stiff.items()}
    values |= {name: factor**0.5 * value for name, value in damped.items()}
    spring = {"F_0_N": 60, "mu": 1, "b_mm": clearance}
    run = own.dynamics(PRESS, **values, **spring).run(
        np.array([0, *np.linspace(0.03, 0.06, 31)]), 1e-7
    )
    ideal = own.evaluate_lane(own.file(PRESS, "ideal_press", F_0_N=60), run.states[0])
    return np.array(
        [np.abs(run.results[name] - ideal[name])[1:].max() for name in ("F_Ox", "N_guide", "N_cam")]
    )


def test_stiff_released_press_has_ideal_forces():
    soft, stiff = (measure_press(factor, clearance=1e-9) for factor in (4, 16))
    assert stiff.max() < 0.5
    assert np.all(stiff < soft / 3.5)


def test_press_with_clearance_has_other_forces():
    assert measure_press(4, clearance=2.0)[:2].min() > 2


@cache
def run_idle_press() -> MotionRun:
    """Return the motion without motor, damping and friction: a turn."""
    idle = {"M_0_Nm": 0, "C_N_s_m": 0, "C_e_N_s_m": 0, "mu": 0}
    return own.dynamics(PRESS, **idle).run(np.linspace(0, 0.1, 1001), 1e-10)


def list_energies(run: MotionRun) -> dict[str, Array]:
    """Return the energies [J] of bodies, of pin and cam, and of the spring."""
    lift = run.states[own.dynamics(PRESS).names.index("u")]
    pin, cam = (np.maximum(-run.results[f"gap_{name}"], 0) for name in ("B", "N_cam"))
    return {
        "bodies": run.results["kinetic"] + run.results["potential"],
        "contacts": 1e7 * pin**2 / 2 + 1e6 * cam**2 / 2,
        "spring": 2 * lift + 300 * lift**2 / 2,
    }


def test_energy_of_idle_press_is_constant():
    energies = list_energies(run_idle_press())
    assert np.ptp(sum(energies.values())) < 1e-8
    assert np.ptp(energies["contacts"]) > 1e-3


def test_energy_without_the_contacts_changes():
    energies = list_energies(run_idle_press())
    assert np.ptp(energies["bodies"] + energies["spring"]) > 1e-3


def test_lifted_ejector_flies_on_its_spring():
    run = run_idle_press()
    cam = [event for event in run.events if event.event == "contact of N_cam"]
    flights = [(opening.time, closing.time) for opening, closing in pairwise(cam) if opening.rising]
    opens, closes = max(flights, key=lambda flight: flight[1] - flight[0])
    flying = (run.times > opens) & (run.times < closes)
    names, times = own.dynamics(PRESS).names, run.times[flying]
    lift, speed = (run.states[names.index(name)][flying] for name in ("u", "u_dot"))
    rest, frequency, since = -(2 + 0.65 * 9.81) / 300, np.sqrt(300 / 0.65), times - times[0]
    swing = (lift[0] - rest) * np.cos(frequency * since) + speed[0] / frequency * np.sin(
        frequency * since
    )
    assert flying.sum() > 40
    assert lift == pytest.approx(rest + swing, abs=1e-10)
    assert np.all(run.results["N_cam"][flying] == 0)
    assert run.results["gap_N_cam"][flying].max() > 3e-3


def measure_support(**values: float) -> Array:
    """Return the support force (36,) [N] of the ideal statement of the planting device, without the
    sun's offset.
    """
    ideal = own.evaluate_lane(
        own.file("released_device", "ideal_device", **values), np.radians(np.arange(0, 360, 10))
    )
    return ideal["F_suny"] + ideal["F_Oy"]


@cache
def measure_built_in_support() -> Array:
    """Return the support force (36,) [N] of the built-in device whose nozzles stay closed."""
    device = Device(load("wang2017", {"cam.opening_deg": 1e-6}))
    return np.asarray(
        device.support(device.prologue(device.design), np.radians(np.arange(0, 360, 10)))
    )


def test_own_statement_of_the_planting_device_has_its_support_force():
    assert measure_support() == pytest.approx(measure_built_in_support(), abs=2e-4)
    assert np.ptp(measure_support()) > 1


def test_another_gear_of_the_planting_device_has_another_support_force():
    assert np.abs(measure_support(m_61=1.0) - measure_built_in_support()).max() > 0.04


def test_released_planting_device_starts_as_it_is_driven():
    dynamics = own.dynamics("released_device")
    start = dict(zip(dynamics.names, dynamics.start(), strict=True))
    assert start["omega"] == pytest.approx(40 * np.pi / 30, rel=1e-14)
    assert {"kinetic", "potential"} < set(
        dynamics.formulas.outputs("lane")
    )  # not asked for by name
    assert [start[name] for name in ("psi_1", "chi_1", "mount_x", "mount_y_dot")] == pytest.approx(
        [0] * 4, abs=1e-12
    )


ROCKER = """
from sympy import cos, sin
from derive import LiftingFollower, Mechanism, Release, ReleasedMechanism, quantities
q = quantities('''
    phi   | rad   | cam
    omega | rad/s | its speed   | 30
    a     | m     | pivot       | 0.1
    l     | m     | arm         | 0.09
    b_0   | rad   | its angle   | 2.6
    b_1   | rad   | its swing   | -0.15
    J     | kg m2 | its inertia | 0.002
    m     | kg    | its mass    | 0.1
    T     | N m   | its load    | 0.5
    J_f   | kg m2 | flywheel    | 0.05
    K     | N/m   | stiffness   | 2e5
''')
release = Release(lambda speed: 0 * q.T, q.J_f, followers={"N_cam": LiftingFollower("b", lambda depth, _: q.K * depth)})
m = ReleasedMechanism("own", q, release, angle=q.phi, speed=q.omega)
b = m.coordinate("b", "rad", "arm", equals=q.b_0 + q.b_1 * (1 - cos(q.phi) + sin(2 * q.phi) / 4) / 2)
D = m.point("D", m.O, m.world, q.a)
turned = m.frame("arm", b)
cam, arm = m.body("cam", m.frame("cam", q.phi)), m.body("arm", turned, q.m, D, q.J)
m.pin("O", cam, m.ground, m.O)
m.pin("D", arm, m.ground, D)
m.follower("N_cam", arm, cam, m.point("P", D, turned, q.l), m.O, across=m.vector(m.world, z=-1))
m.torque("load", arm, m.ground, q.T)
m.motor("M_in", cam, m.ground, m.O)
SYSTEM = m.system()
"""


def test_energy_of_a_rocker_that_hops_on_its_cam_is_constant():
    run = own.dynamics(ROCKER, "own").run(np.linspace(0, 0.2, 101), 1e-10)
    stored = 1e5 * np.maximum(-run.results["gap_N_cam"], 0) ** 2 - 0.5 * run.states[1]
    assert np.ptp(run.results["kinetic"] + stored) < 1e-8
    assert np.ptp(run.results["kinetic"]) > 1e-2
    assert len(run.events) >= 2


def state_press(release: Release, early: bool = False, by_time: bool = False) -> Mechanism:
    q = GIVEN
    m = ReleasedMechanism("own", q, release, angle=q.phi, speed=q.omega)
    s, b = m.coordinate("s", "m", "place"), m.coordinate("b", "rad", "rod")
    u = m.coordinate(
        "u", "m", "lift", equals=q.r * (2 + q.phi) + (m.rate(s) * q.r / q.omega if by_time else 0)
    )
    A = m.point("A", m.O, m.frame("crank", q.phi), q.r)
    B, slot, P = (
        m.point("B", A, m.frame("rod", b), q.R),
        m.point("slot", m.O, m.world, s),
        m.point("P", m.O, m.world, u),
    )
    crank, rod = (
        m.body("crank", m.frame("crank", q.phi), q.m, m.O, q.J),
        m.body("rod", m.frame("rod", b), q.m, A, q.J),
    )
    slider, tappet = m.body("slider", m.world, q.m, slot), m.body("tappet", m.world, q.m, P)
    m.pin("O", crank, m.ground, m.O)
    if early:
        m.pin("B", slider, rod, slot)
    m.close(B, slot, start={s: q.r + q.R, b: 0})
    m.pin("B", *((slider, rod) if not early else (slider, crank)), slot)
    m.follower("N", tappet, crank, P, m.O, across=m.vector(m.world, z=-1))
    return m


LOOSE = {"B": LoosePin("B", GIVEN.r / 100, lambda depth, _: GIVEN.K * depth)}
LIFTING = {"N": LiftingFollower("u", lambda depth, _: GIVEN.K * depth)}


@pytest.mark.parametrize(
    ("elements", "stated", "message"),
    [
        ({"pins": LOOSE}, {"early": True}, "no loop B"),
        ({"pins": {"B": LoosePin("C", 0, LOOSE["B"].law)}}, {}, "no loop C"),
        ({"followers": {"N": LiftingFollower("s", LIFTING["N"].law)}}, {}, "no coordinate s"),
        ({"followers": LIFTING}, {"by_time": True}, "more than phi and u"),
        ({"pins": {"Q": LOOSE["B"]}, "followers": LIFTING}, {}, "no loop B|Q should be compliant"),
        ({"teeth": {"P": ElasticTeeth("u", LIFTING["N"].law)}}, {}, "P should be compliant"),
    ],
)
def test_elements_that_are_not_stated_are_refused(elements, stated, message):
    with pytest.raises(MechanismError, match=message):
        state_press(Release(lambda speed: 0 * GIVEN.K * GIVEN.R, **elements), **stated).system()
