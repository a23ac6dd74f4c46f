"""Friction, clearance, play and collisions in free motion, against equations written by hand and
conservation laws.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scipy.integrate

from derive import Mechanism, quantities
from derive.mechanics.statement import MechanismError
from planter.errors import ComputationError
from planter.kernels import Array
from planter.mechanism.motion import compute_motion
from tests.support import own

TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}

SLOPE = """
from derive import Mechanism, quantities
q = quantities('''
    g   | m/s2 | free fall | 9.81
    m   | kg   | block     | 2
    mu  | 1    | friction  | 0.2
    a   | rad  | slope     | 0.5
    v_c | m/s  | creep     | 1e-8
''')
m = Mechanism("own", q, gravity=q.g)
slope = m.frame("slope", q.a)
plane = m.body("plane", slope)
m.weld("W", plane, m.ground, m.O)
at = m.point("P", m.O, slope, m.coordinate("s", "m", "place"))
m.slide("guide", m.body("block", slope, q.m, at), plane, at, friction=q.mu, origin=m.O, creep=q.v_c)
SYSTEM = m.system()
"""
CRANK = """
from derive import Mechanism, quantities
q = quantities('''
    phi   | rad   | crank | 0
    omega | rad/s | its speed | 11
    g     | m/s2  | free fall | 9.81
    r     | m     | crank     | 0.05
    l     | m     | rod       | 0.17
    e     | m     | offset    | 0.03
    m_r   | kg    | rod       | 0.7
    J     | kg m2 | rod       | 2e-3
    m_s   | kg    | slider    | 1.3
    mu    | 1     | friction  | 0.4
    v_c   | m/s   | creep     | 1e-9
    T     | N m   | torque    | 0
''')
m = Mechanism("own", q, angle=q.phi, speed=q.omega, gravity=q.g)
phi, psi, s = q.phi, m.coordinate("psi", "rad", "rod"), m.coordinate("s", "m", "slider")
turned, rod = m.frame("crank", phi), m.frame("rod", psi)
A = m.point("A", m.O, turned, q.r)
B, S = m.point("B", A, rod, q.l), m.point("S", m.O, m.world, s, q.e)
crank, link = m.body("crank", turned), m.body("link", rod, q.m_r, m.point("C", A, rod, q.l / 2), q.J)
slider = m.body("slider", m.world, q.m_s, S)
m.pin("O", crank, m.ground, m.O)
m.pin("A", link, crank, A)
m.pin("B", slider, link, B)
m.slide("guide", slider, m.ground, S, friction=q.mu)
m.close(B, S, start={psi: 0, s: q.r + q.l})
m.motor("T_in", crank, m.ground, m.O)
SYSTEM = m.system()
"""
TRAMMEL = """
from derive import Mechanism, X, Y, quantities
q = quantities('''
    phi   | rad   | bar | 0
    omega | rad/s | its speed | 11
    g     | m/s2  | free fall | 9.81
    l     | m     | bar       | 0.4
    m     | kg    | bar       | 2
    J     | kg m2 | bar       | 0.03
    a     | kg    | slider, x | 0.7
    b     | kg    | slider, y | 0.9
    mu    | 1     | friction  | 0.25
    v_c   | m/s   | creep     | 1e-9
    T     | N m   | torque    | 0
''')
m = Mechanism("own", q, angle=q.phi, speed=q.omega, gravity=q.g)
phi, psi, s = q.phi, m.coordinate("psi", "m", "slider, y"), m.coordinate("s", "m", "slider, x")
bar = m.frame("bar", phi)
A, B = m.point("A", m.O, m.world, s), m.point("B", m.O, m.world, 0, psi)
rod = m.body("rod", bar, q.m, m.point("C", A, bar, q.l / 2), q.J)
first, second = m.body("first", m.world, q.a, A), m.body("second", m.world, q.b, B)
m.slide("guide", first, m.ground, A, along=X, friction=q.mu)
m.slide("other", second, m.ground, B, along=Y, friction=q.mu)
m.pin("A", rod, first, A)
m.pin("B", rod, second, B)
m.close(m.point("E", A, bar, q.l), B, start={s: -q.l, psi: 0})
m.motor("T_in", rod, m.ground, m.O)
SYSTEM = m.system()
"""
FALLING_ROD = """
from derive import Mechanism, quantities
q = quantities('''
    g   | m/s2  | free fall   | 9.81
    m   | kg    | rod         | 1
    h   | m     | half of it  | 0.5
    J   | kg m2 | rod         | 0.0833333333
    m_s | kg    | slider      | 1e-6
    mu  | 1     | friction    | 3
    v_c | m/s   | creep       | 1e-6
''')
m = Mechanism("own", q, gravity=q.g)
s, a = m.coordinate("s", "m", "slider"), m.coordinate("a", "rad", "rod")
rod, P = m.frame("rod", a), m.point("P", m.O, m.world, s)
slider = m.body("slider", m.world, q.m_s, P)
falling = m.body("rod", rod, q.m, m.point("C", P, rod, q.h), q.J)
m.slide("floor", slider, m.ground, P, friction=q.mu, creep=q.v_c)
m.pin("P", falling, slider, P)
SYSTEM = m.system()
"""
DISCS = """
from derive import Mechanism, quantities
from sympy import Rational
q = quantities('''
    m   | kg     | first disc  | 2
    n   | kg     | second disc | 0.5
    R   | m      | radii, both | 0.1
    K   | N/m1.5 | contact     | 1e7
    v   | m/s    | first disc  | 3
    b   | m      | offset      | 0.06
    s_0 | m      | first disc  | -0.3
''')
m = Mechanism("own", q)
x, y, u, w = (m.coordinate(name, "m", name) for name in "xyuw")
m.begin({x: q.s_0, y: q.b, m.rate(x): q.v})
P, Q = m.point("P", m.O, m.world, x, y), m.point("Q", m.O, m.world, u, w)
first, second = m.body("first", m.world, q.m, P), m.body("second", m.world, q.n, Q)
m.compliant_contact("rims", first, second, P, Q, lambda depth, rate: q.K * depth ** Rational(3, 2), radius=q.R)
SYSTEM = m.system()
"""
PEG = """
from derive import Mechanism, quantities
q = quantities('''
    m | kg   | ball      | 1
    g | m/s2 | free fall | 9.81
    K | N/m  | contact   | 1e5
    R | mm   | ball      | 100
    h | m    | start     | 0.5
''')
m = Mechanism("own", q, gravity=q.g)
x, y = m.coordinate("x", "m", "x"), m.coordinate("y", "m", "y")
m.begin({y: q.h})
C = m.point("C", m.O, m.world, x, y)
ball = m.body("ball", m.world, q.m, C)
m.compliant_contact("peg", ball, m.ground, C, m.O, lambda depth, rate: q.K * depth, radius=q.R)
SYSTEM = m.system()
"""
Rates = Callable[[float, Array], list[float]]


def test_block_on_slope_decelerates_by_coulomb() -> None:
    motion = own.dynamics(SLOPE, "own")
    (down,), _ = motion.accelerations(0.0, np.array([0.0, -1.0]))
    (up,), _ = motion.accelerations(0.0, np.array([0.0, 1.0]))
    assert down == pytest.approx(-9.81 * (np.sin(0.5) - 0.2 * np.cos(0.5)), rel=1e-12)
    assert up == pytest.approx(-9.81 * (np.sin(0.5) + 0.2 * np.cos(0.5)), rel=1e-12)


def make_free(driven: str) -> str:
    """The statement with its drive as a coordinate, the motor as a torque T, and smooth
    friction.
    """
    changes = {
        ", angle=q.phi, speed=q.omega": "",
        "    phi   |": "    phi_0 |",
        "= q.phi,": '= m.coordinate("turn", "rad", "drive"),',
        "friction=q.mu": "friction=q.mu, creep=q.v_c",
        'm.motor("T_in", crank, m.ground, m.O)': 'm.torque("T_in", crank, m.ground, q.T)',
        'm.motor("T_in", rod, m.ground, m.O)': 'm.torque("T_in", rod, m.ground, q.T)',
    }
    for old, new in changes.items():
        driven = driven.replace(old, new)
    return driven


@pytest.mark.parametrize("angle", [0.4, 1.9, 2.8, 4.0, 5.5])
@pytest.mark.parametrize(
    ("statement", "pressing"), [(CRANK, ["N_guide"]), (TRAMMEL, ["N_guide", "N_other"])]
)
def test_friction_agrees_with_driven_motion(
    statement: str, pressing: list[str], angle: float
) -> None:
    """With the torque that keeps the speed, the drive of the free mechanism does not accelerate."""
    driven = own.evaluate_lane(own.file(statement, "own"), np.array([angle]))
    now = {name: float(values[0]) for name, values in driven.items()}
    free = own.dynamics(make_free(statement), "own", T_Nm=now["T_in"], phi_0_rad=0.0)
    state = np.array([angle, now["psi"], now["s"], 11.0, now["psi_dot"], now["s_dot"]])
    accelerations, _ = free.accelerations(0.0, state)
    assert accelerations == pytest.approx([0.0, now["psi_ddot"], now["s_ddot"]], abs=1e-7)
    assert free.find_sizes(0.0, state) == pytest.approx(
        [abs(now[name]) for name in pressing], rel=1e-9
    )


def test_friction_takes_what_energy_loses() -> None:
    free = own.dynamics(make_free(CRANK), "own", v_c_m_s=1e-3, phi_0_rad=0.0)
    state = free.start()
    state[3:] = [11.0, -11.0 * 0.05 / 0.17, 0.0]
    run = free.run(np.linspace(0.0, 0.1, 1001), state=free.project(0.0, state))
    lost = scipy.integrate.cumulative_simpson(run.results["P_guide"], x=run.times, initial=0)
    energy = run.results["kinetic"] + run.results["potential"] + lost
    assert lost[-1] > 0.01
    assert np.ptp(energy) < 1e-5 * lost[-1]


def test_friction_that_jams_is_refused() -> None:
    """The rod of Painleve: pushed into the floor, no normal force goes with its friction."""
    rod = own.dynamics(FALLING_ROD, "own")
    answers = []
    for speed in (-1.0, 1.0):
        try:
            answers.append(rod.find_sizes(0.0, np.array([0.0, 1.0, speed, 0.0])).item())
        except ComputationError as error:
            answers.append(str(error))
    assert isinstance(answers[0], float) != isinstance(answers[1], float)
    assert any("jams: no forces N_floor" in str(answer) for answer in answers)
    assert (
        own.dynamics(FALLING_ROD, "own", mu=1.0).find_sizes(0.0, np.array([0.0, 1.0, 1.0, 0.0])) > 0
    )


def test_sharp_friction_is_refused() -> None:
    q = quantities("m | kg | block | 2\nmu | 1 | friction | 0.2")
    m = Mechanism("own", q)
    at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place"))
    m.slide("guide", m.body("block", m.world, q.m, at), m.ground, at, friction=q.mu)
    with pytest.raises(MechanismError, match=r"friction of guide jumps .* `creep`"):
        m.system()


def test_inertia_without_mass_is_refused() -> None:
    m = Mechanism("own", quantities("J | kg m2 | wheel | 2"))
    with pytest.raises(MechanismError, match="body wheel: an inertia needs a mass"):
        m.body("wheel", m.world, inertia=m.given.J)


def test_discs_collide_as_momentum_and_energy_say() -> None:
    """The velocities along the line of centres at impact change as in an elastic impact, those
    across it not at all.
    """
    run = own.dynamics(DISCS, "own", K_N_m15=1e15).run(np.array([0.0, 0.2]))
    normal = np.array([0.08, -0.06]) / 0.1
    impulse = 2 * (2 * 0.5 / 2.5) * 3 * normal[0] * normal
    assert run.states[4:6, -1] == pytest.approx(np.array([3, 0]) - impulse / 2, abs=3e-4)
    assert run.states[6:, -1] == pytest.approx(impulse / 0.5, abs=3e-4)
    assert 2 * run.states[4:6] + 0.5 * run.states[6:] == pytest.approx(
        np.tile([[6.0], [0.0]], 2), abs=1e-10
    )
    assert run.results["kinetic"][-1] == pytest.approx(9.0, rel=1e-8)
    assert [event.rising for event in run.events] == [False, True]
    assert run.events[0].time == pytest.approx((0.3 - 0.08) / 3, abs=1e-9)


def rattle(time: float, state: Array) -> list[float]:
    """The pinion and the wheel of the example by hand."""
    a_1, a_2, w_1, w_2 = state
    ahead = (0.03 * a_1 + 0.06 * a_2) * np.cos(0.35)
    push = 2e6 * (max(ahead - 5e-5, 0) - max(-ahead - 5e-5, 0)) * np.cos(0.35)
    return [
        w_1,
        w_2,
        (2 + 8 * np.sin(120 * time) - push * 0.03) / 4e-4,
        (-push * 0.06 - 0.02 * w_2) / 3e-3,
    ]


def slack(time: float, state: Array) -> list[float]:
    """The crank, the rod and the slider of the example by hand: the pin pushes the bush, the bush
    the guide.
    """
    phi, psi, s, phi_dot, psi_dot, s_dot = state
    r, long, m_r, m_s, g, c = 0.05, 0.15, 0.4, 0.8, 9.81, 2e-4
    outward, rod = np.array([np.cos(phi), np.sin(phi)]), np.array([np.cos(psi), np.sin(psi)])
    across, over = np.array([-outward[1], outward[0]]), np.array([-rod[1], rod[0]])
    place, speed = (
        r * outward + long * rod - [s, 0],
        r * phi_dot * across + long * psi_dot * over - [s_dot, 0],
    )
    far = np.linalg.norm(place)
    depth, rate = far - c, speed @ place / far
    push = max(4e9 * depth**1.5 * (1 + 0.8 * rate), 0) if depth > 0 else 0.0
    on_rod = -push * place / far
    arms = np.array([r * across, long / 2 * over])  # of the rod's centroid, by both angles
    inertia = m_r * arms @ arms.T + np.diag([0.02, 9e-4])
    bent = -r * phi_dot**2 * outward - long / 2 * psi_dot**2 * rod
    loads = (
        arms @ (m_r * np.array([0, -g]) - m_r * bent) + np.array([r * across, long * over]) @ on_rod
    )
    normal = m_s * g + on_rod[1]
    friction = -0.1 * abs(normal) * s_dot / np.hypot(s_dot, 0.002)
    return [phi_dot, psi_dot, s_dot, *np.linalg.solve(inertia, loads), (friction - on_rod[0]) / m_s]


@pytest.mark.parametrize(
    ("example", "by_hand", "until", "tolerance"),
    [("gear_rattle", rattle, 0.06, 1e-6), ("pin_clearance", slack, 0.02, 1e-6)],
)
def test_impacts_agree_with_equations_by_hand(
    example: str, by_hand: Rates, until: float, tolerance: float
) -> None:
    motion = own.dynamics(example)
    run = motion.run(np.linspace(0.0, until, 7), tolerance=1e-11)
    expected = scipy.integrate.solve_ivp(
        by_hand, (0.0, until), motion.start(), t_eval=run.times, **TIGHT
    )
    assert run.states == pytest.approx(expected.y, abs=tolerance * (1 + np.abs(expected.y).max()))
    assert len(run.events) > 4


def test_rattle_touches_both_flanks_when_the_equations_say() -> None:
    def touch(time: float, state: Array) -> float:
        return float((0.03 * state[0] + 0.06 * state[1]) * np.cos(0.35) - 5e-5)

    run = own.dynamics("gear_rattle").run(np.array([0.0, 0.06]), tolerance=1e-11)
    expected = scipy.integrate.solve_ivp(rattle, (0.0, 0.06), np.zeros(4), events=touch, **TIGHT)
    front = [event.time for event in run.events if event.event.endswith("ahead = b")]
    assert front == pytest.approx(expected.t_events[0], abs=1e-8)
    assert any(event.event.endswith("ahead = -b") for event in run.events)


def test_result_lists_events() -> None:
    motion = compute_motion(own.dynamics("gear_rattle"), 0.01, 11, 1e-9)
    events = motion.result.events
    assert [event.time_s for event in events] == sorted(event.time_s for event in events)
    assert {event.rising for event in events} == {True, False}


@pytest.mark.parametrize("radius", [0.1, 0.01, 1e-3])
def test_ball_does_not_pass_through_peg(radius: float) -> None:
    """In free fall steps are long: a contact may begin and end within one."""
    run = own.dynamics(PEG, "own", R_mm=1e3 * radius, K_N_m=1e10).run(np.array([0.0, 2.0]))
    bounces = [event.time for event in run.events if not event.rising]
    fall = np.sqrt(2 * (0.5 - radius) / 9.81)
    assert bounces == pytest.approx(fall * np.arange(1, 2 * len(bounces), 2), abs=1e-3)
    assert len(bounces) == int((2 / fall + 1) / 2)
    assert run.states[1, -1] > radius


def test_pin_may_start_in_the_middle_of_its_bush() -> None:
    text = (own.EXAMPLES / "pin_clearance.py").read_text(encoding="utf-8")
    motion = own.dynamics(text.replace("s: q.r + q.l - q.c", "s: q.r + q.l"), "pin_clearance")
    run = motion.run(np.array([0.0, 0.002]))
    assert run.results["gap_pin"][0] == pytest.approx(2e-4, rel=1e-9)
    assert [event.rising for event in run.events] == [False]
