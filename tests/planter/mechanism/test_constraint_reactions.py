"""Constraints of free motion bring the reaction that no joint carries; rigid teeth; what derivation
refuses.
"""

from __future__ import annotations

import numpy as np
import pytest

from derive.mechanics.statement import MechanismError
from planter.mechanism.dynamics import Dynamics, MotionRun
from tests.support import own

DIFFERENTIAL = '''
from sympy import pi, sqrt
from derive import GearContact, Mechanism, Z, quantities, unit

q = quantities("""
    r_s | m | sun | 0.024
    r_p | m | planet | 0.013
    J_s | kg m2 | sun | 3e-4
    J_r | kg m2 | ring | 8e-4
    J_c | kg m2 | carrier | 6e-4
    J_p | kg m2 | planet | 3e-5
    m_b | kg | sun, ring and carrier | 0.5
    m_p | kg | planet | 0.2
    T_s | N m | torque on the sun | 0.7
    T_r | N m | torque on the ring | -0.4
    D_c | N m s | drag of the load | 0.03
    T_f | N m | friction of the planet's pin | 0.02
    w_f | rad/s | creep of it | 0.5
    alpha | deg | pressure angle | 22
""")
m = Mechanism("differential", q)
s, r, c, p = (m.coordinate(n, "rad", t) for n, t in zip("srcp", ("sun", "ring", "carrier", "planet")))
r_r = q.r_s + 2 * q.r_p
sun, ring, arm = (
    m.body(n, m.frame(n, a), q.m_b, m.O, J) for n, a, J in (("sun", s, q.J_s), ("ring", r, q.J_r), ("arm", c, q.J_c))
)
line = m.frame("line", c)
P = m.point("P", m.O, line, q.r_s + q.r_p)
planet = m.body("planet", m.frame("planet", p), q.m_p, P, q.J_p)
GAPS
for n, b in (("OS", sun), ("OR", ring), ("OC", arm)):
    m.pin(n, b, m.ground, m.O)
m.pin("OP", planet, arm, P)
TEETH
m.torque("in_s", sun, m.ground, q.T_s)
m.torque("in_r", ring, m.ground, q.T_r)
m.torque("load", arm, m.ground, -q.D_c * m.rate(c))
w = m.rate(p) - m.rate(c)
m.torque("friction", planet, arm, -q.T_f * w / sqrt(w**2 + q.w_f**2))
SYSTEM = m.system()
'''
GAPS = """
m.constrain("mesh_s", q.r_s * (s - c) + q.r_p * (p - c), start={p: 0, c: 0})
m.constrain("mesh_r", r_r * (r - c) - q.r_p * (p - c), start={p: 0, c: 0})
"""
COUPLES = """
m.couple("M_S", sun, planet, arm, (m.O, P), unit(m.world, Z), -q.r_s / q.r_p)
m.couple("M_R", ring, planet, arm, (m.O, P), unit(m.world, Z), r_r / q.r_p)
"""
MESHES = """
inward = m.frame("inward", pi, parent=line)
m.mesh("S", sun, planet, GearContact(line, P, q.r_p, q.alpha))
m.mesh("R", planet, ring, GearContact(inward, m.O, r_r, q.alpha, internal=True))
"""
TIMES = np.linspace(0, 0.4, 9)


def differential(teeth: str, gaps: str = GAPS) -> str:
    return DIFFERENTIAL.replace("GAPS", gaps).replace("TEETH", teeth)


def run_own(text: str, name: str, **values: float) -> tuple[Dynamics, MotionRun]:
    dynamics = own.dynamics(text, name, **values)
    return dynamics, dynamics.run(TIMES, 1e-10)


@pytest.fixture(scope="module")
def runs() -> dict[str, MotionRun]:
    texts = {"couple": COUPLES, "none": "", "mesh": MESHES}
    return {key: run_own(differential(teeth), "differential")[1] for key, teeth in texts.items()}


def test_differential_moves_alike_however_its_teeth_are_stated(runs: dict[str, MotionRun]) -> None:
    """Lagrange's equations of the two degrees of freedom, eliminated by hand: planet p = c - r_s (s
    - c)/r_p.
    """
    for run in runs.values():
        assert run.states == pytest.approx(runs["couple"].states, rel=1e-8, abs=1e-8)
        assert run.undetermined == ()
    r_s, r_p, arm, J = 0.024, 0.013, 0.037, np.diag([3e-4, 8e-4, 6e-4 + 0.2 * 0.037**2, 3e-5])
    r_r = r_s + 2 * r_p
    c_by = np.array([r_s, r_r]) / (r_s + r_r)
    p_by = c_by - r_s / r_p * (np.array([1, 0]) - c_by)
    ways = np.array([[1, 0], [0, 1], c_by, p_by])
    assert arm == pytest.approx(r_s + r_p)
    for state, acceleration in zip(
        runs["none"].states.T, runs["none"].accelerations.T, strict=True
    ):
        rates = state[4:]
        slip = rates[3] - rates[2]
        friction = -0.02 * slip / np.hypot(slip, 0.5)
        loads = np.array([0.7, -0.4, -0.03 * rates[2] - friction, friction])
        assert ways.T @ J @ ways @ acceleration[:2] == pytest.approx(
            ways.T @ loads, rel=1e-9, abs=1e-12
        )


def test_own_reaction_is_the_multiplier_and_the_moment_of_a_couple(
    runs: dict[str, MotionRun],
) -> None:
    none, couple = runs["none"].results, runs["couple"].results
    assert none["R_mesh_s"] * 0.013 == pytest.approx(couple["M_S"], rel=1e-7)
    assert -none["R_mesh_r"] * 0.013 == pytest.approx(couple["M_R"], rel=1e-7)
    for name in ("F_OCx", "F_OCy", "F_OPx", "F_OPy", "F_OSx"):
        assert none[name] == pytest.approx(couple[name], rel=1e-7, abs=1e-9)
    dynamics = own.dynamics(differential(""), "differential")
    multipliers = dynamics.accelerations(TIMES[-1], runs["none"].states[:, -1])[1]
    assert [none["R_mesh_s"][-1], none["R_mesh_r"][-1]] == pytest.approx(multipliers, rel=1e-8)
    assert "R_mesh_s" not in couple


def test_teeth_load_bearings_by_pressure_angle_and_balance(runs: dict[str, MotionRun]) -> None:
    """The tooth force is the pitch force over cos(alpha); the shaft of the sun takes its reverse
    alone.
    """
    mesh, none = runs["mesh"].results, runs["none"].results
    pitch = np.abs(none["R_mesh_s"])
    assert mesh["F_NS"] == pytest.approx(pitch / np.cos(np.radians(22)), rel=1e-7)
    assert [mesh["F_OSx"], mesh["F_OSy"]] == [
        pytest.approx(-mesh[f"F_S{a}"], rel=1e-7) for a in "xy"
    ]
    assert np.hypot(mesh["F_OSx"], mesh["F_OSy"]).min() > 1
    for axis in "xy":
        outer = sum(mesh[f"F_{name}{axis}"] for name in ("OS", "OR", "OC"))
        assert outer == pytest.approx(0.2 * mesh[f"a_planet_{axis}"], abs=1e-7)


def test_energy_changes_by_the_power_of_given_torques(runs: dict[str, MotionRun]) -> None:
    dynamics, run = run_own(differential(""), "differential", T_f_Nm=0.0, D_c_N_m_s=0.0)
    assert dynamics.size == 4
    work = 0.7 * run.states[0] - 0.4 * run.states[1]
    assert run.results["kinetic"] == pytest.approx(work, rel=1e-8, abs=1e-9)


ROPE = '''
from sympy import Rational, pi, sin
from derive import Mechanism, Y, quantities

q = quantities("""
    m_1 | kg   | block on the rope       | 2
    m_2 | kg   | block on the loose roll | 3
    g   | m/s2 | free fall               | 9.81
    h   | m    | stroke                  | 0.05
    w   | rad/s | its speed              | 4
""")
m = Mechanism("rope", q, gravity=q.g)
x, y = m.coordinate("x", "m", "first block, up"), m.coordinate("y", "m", "second block, up")
A, B = m.point("A", m.O, m.world, 0, x), m.point("B", m.O, m.world, 0, y)
first, second = m.body("first", m.world, q.m_1, A), m.body("second", m.world, q.m_2, B)
m.slide("GA", first, m.ground, A, along=Y)
m.slide("GB", second, m.ground, B, along=Y)
CONSTRAINT
SYSTEM = m.system()
'''


def test_rope_over_a_loose_roll_has_its_tension() -> None:
    """x + 2 y constant: Atwood's machine with a loose roll, tension 3 g / (1/m_1 + 4/m_2)."""
    text = ROPE.replace("CONSTRAINT", 'm.constrain("rope", x + 2 * y, start={x: 0, y: 0})')
    _, run = run_own(text, "rope")
    tension = 3 * 9.81 / (1 / 2 + 4 / 3)
    assert run.results["R_rope"] == pytest.approx(tension, rel=1e-9)
    assert run.states[0] == pytest.approx((tension / 2 - 9.81) * TIMES**2 / 2, abs=1e-9)


def test_prescribed_motion_does_the_work_that_energy_gains() -> None:
    """A constraint that depends on time: its force is m (g + h''), its power what the energy
    gains.
    """
    text = ROPE.replace(
        "CONSTRAINT", 'm.constrain("drive", x - q.h * sin(q.w * m.time), start={x: 0})'
    )
    dynamics, run = run_own(text, "rope")
    assert run.results["R_drive"] == pytest.approx(
        2 * (9.81 - 0.05 * 16 * np.sin(4 * TIMES)), rel=1e-8
    )
    assert run.states[0] == pytest.approx(0.05 * np.sin(4 * TIMES), abs=1e-10)
    assert dynamics.size == 2


def test_constraint_nonlinear_in_the_rates_starts_and_stays_on_it() -> None:
    """x' y' = 1 m2/s2: the ideal force is along the gradient (y', x') of the constraint."""
    text = ROPE.replace(
        "CONSTRAINT",
        'm.roll("product", m.rate(x) * m.rate(y) - q.h**2 * q.w**2)\nm.begin({m.rate(x): 0.5, '
        "m.rate(y): 0.1})",
    )
    with pytest.warns(RuntimeWarning, match="hold="):
        _, run = run_own(text, "rope")
    rates = run.states[2:]
    assert rates[0] * rates[1] == pytest.approx(0.05**2 * 4**2, abs=1e-9)
    across = run.results["R_product"] * rates[::-1]
    assert np.array([2, 3])[:, None] * (run.accelerations + 9.81) == pytest.approx(across, abs=1e-8)


def test_rolling_disc_is_pushed_where_it_touches() -> None:
    text = """
from derive import Mechanism, X, quantities
q = quantities("m | kg | disc | 2\\nr | m | radius | 0.1\\nF | N | pull | 6\\ng | m/s2 | free fall | 9.81")
m = Mechanism("disc", q, gravity=q.g)
x, a = m.coordinate("x", "m", "hub"), m.coordinate("a", "rad", "turn")
hub = m.point("hub", m.O, m.world, x, q.r)
disc = m.body("disc", m.frame("disc", a), q.m, hub, q.m * q.r**2 / 2)
m.contact("floor", disc, m.ground, m.point("foot", hub, m.world, 0, -q.r), m.vector(m.world, 0, 1))
m.roll("rim", m.rate(x) + q.r * m.rate(a))
m.force("pull", disc, hub, m.vector(m.world, q.F))
SYSTEM = m.system()
"""
    _, run = run_own(text, "disc")
    assert run.results["R_rim"] == pytest.approx(-2, rel=1e-9)  # a third of the pull, against it
    assert run.results["N_floor"] == pytest.approx(2 * 9.81)
    assert run.states[0] == pytest.approx(2 * TIMES**2 / 2, abs=1e-9)


REFUSED = {
    "teeth without their constraint": (
        differential(MESHES, GAPS.splitlines()[1]),
        "M_R.*constrain",
    ),
    "a support against what moves": (
        ROPE.replace(
            "CONSTRAINT", 'm.contact("floor", first, m.ground, A, m.vector(m.world, 0, 1))'
        ),
        "N_floor.*resists a motion",
    ),
    "a drive without a motion": (
        ROPE.replace(
            "CONSTRAINT",
            'm.actuator("F_in", first, m.ground, (A, m.point("top", m.O, m.world, 0, q.h)))',
        ),
        "F_in.*constrain",
    ),
    "teeth with friction": (
        differential(
            MESHES.replace(
                "GearContact(line, P, q.r_p, q.alpha)",
                "SlidingContact(line, P, q.r_p, q.alpha, "
                "q.alpha / 9, beyond=q.r_p / 9, turning=m.rate(s) - m.rate(p))",
            ).replace("inward =", "from derive import SlidingContact\ninward =")
        ),
        "compliant_mesh",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_no_joint_can_carry_or_allow_is_refused(case: str) -> None:
    text, message = REFUSED[case]
    with pytest.raises(MechanismError, match=message):
        exec(text, {})


def test_reaction_of_a_constraint_that_joints_carry_is_refused() -> None:
    text = differential(COUPLES).replace("m.system()", 'm.system(reported=["R_mesh_s"])')
    with pytest.raises(MechanismError, match="R_mesh_s: joints carry"):
        exec(text, {})


PLANETS = '''
from sympy import pi
from derive import GearContact, Mechanism, quantities

q = quantities("""
    r_s | m | sun | 0.024
    r_p | m | planet | 0.013
    J | kg m2 | each | 3e-4
    m_p | kg | planet | 0.2
    m_b | kg | sun, ring and carrier | 0.5
    T | N m | torque | 0.7
    alpha | deg | pressure angle | 22
""")
m = Mechanism("planets", q)
s, r, c, *planets = (m.coordinate(n, "rad", n) for n in ("s", "r", "c", "p", "o"))
r_r = q.r_s + 2 * q.r_p
sun, ring, arm = (m.body(n, m.frame(n, a), q.m_b, m.O, q.J) for n, a in (("sun", s), ("ring", r), ("arm", c)))
for n, b in (("OS", sun), ("OR", ring), ("OC", arm)):
    m.pin(n, b, m.ground, m.O)
first = None
for k, (a, turn) in enumerate(zip(planets, (0, pi)), 1):
    line = m.frame(f"line{k}", c + turn)
    P = m.point(f"P{k}", m.O, line, q.r_s + q.r_p)
    planet = m.body(f"planet{k}", m.frame(f"planet{k}", a), q.m_p, P, q.J)
    m.constrain(f"s{k}", q.r_s * (s - c) + q.r_p * (a - c), start={})
    m.constrain(f"r{k}", r_r * (r - c) - q.r_p * (a - c), start={})
    m.pin(f"P{k}", planet, arm, P)
    TEETH
m.torque("in", sun, m.ground, q.T)
SYSTEM = m.system()
'''
PAIRS = """teeth = m.mesh(f"S{k}", sun, planet, GearContact(line, P, q.r_p, q.alpha)EQUAL)
    inward = m.frame(f"in{k}", pi, parent=line)
    m.mesh(f"R{k}", planet, ring, GearContact(inward, m.O, r_r, q.alpha, internal=True))
    first = teeth"""


def test_what_two_planets_share_is_undetermined_unless_stated() -> None:
    """Balances do not say how rigid planets share a load: no result says so, though the motion is
    determined.
    """
    texts = {
        "constrain": "pass",
        "mesh": PAIRS.replace("EQUAL", ""),
        "equal": PAIRS.replace("EQUAL", ", equal_to=first"),
    }
    runs = {
        key: run_own(PLANETS.replace("TEETH", text), "planets")[1] for key, text in texts.items()
    }
    assert {"R_s1", "R_r2"} <= set(runs["constrain"].undetermined)
    assert {"M_S1", "F_NS1", "F_S2x", "F_NR2", "F_P1x"} <= set(runs["mesh"].undetermined)
    assert not runs["mesh"].results.keys() & {"M_S1", "F_NS1", "F_S2x", "F_NR2", "F_P1x"}
    equal = runs["equal"]
    assert equal.undetermined == ()
    assert equal.results["M_S1"] == pytest.approx(equal.results["M_S2"], rel=1e-9)
    acceleration = equal.accelerations
    torque = 2 * equal.results["M_S1"] * 0.024 / 0.013  # of both planets, as the sun feels it
    assert 0.7 + torque == pytest.approx(3e-4 * acceleration[0], rel=1e-8)
    for run in runs.values():
        assert run.states == pytest.approx(equal.states, rel=1e-8)
