"""Struts, bushings and compliant contacts in free motion, held against closed forms."""

import numpy as np
import pytest
import scipy.optimize
import scipy.special

from planter.mechanism.dynamics import MotionRun
from tests.support import own

HEAD = '''
from sympy import Rational
from derive import Mechanism, quantities
q = quantities("""
    m | kg | block | 2
    k | N/m | stiffness | 800
    c | N s/m | damping | 6
    k_3 | N/m3 | stiffening | 5000
    K | N/m1.5 | contact | 300000
    D | s/m | losses | 0.6
    mu | 1 | friction | 0.3
    g | m/s2 | free fall | 9.81
    w | m | wall | 1
    v_c | m/s | creep | 0.001
    s_0 | m | start | 0.3
""")
'''
STRUT = """
m = Mechanism("own", q)
s = m.coordinate("s", "m", "place")
m.begin({s: q.s_0})
at = m.point("P", m.O, m.world, s)
block = m.body("block", m.world, q.m, at)
ends = at, m.point("wall", m.O, m.world, -q.w)
m.strut("rubber", block, m.ground, ends, lambda distance, rate: q.k_3 * (distance - q.w) ** 3)
SYSTEM = m.system()
"""
BUSHING = """
m = Mechanism("own", q)
x, y = m.coordinate("x", "m", "place"), m.coordinate("y", "m", "place")
m.begin({x: q.s_0, y: -q.s_0 / 2})
at = m.point("P", m.O, m.world, x, y)
block = m.body("block", m.world, q.m, at)
m.bushing("mount", block, m.ground, (at, m.O), q.k, q.c)
SYSTEM = m.system()
"""
DROP = """
m = Mechanism("own", q, gravity=q.g)
x, h = m.coordinate("x", "m", "place"), m.coordinate("h", "m", "height")
m.begin({h: q.s_0})
at = m.point("P", m.O, m.world, x, h)
block = m.body("block", m.world, q.m, at)
m.compliant_contact("floor", block, m.ground, at, m.O,
    lambda depth, rate: q.K * depth ** Rational(3, 2) * (1 + q.D * rate), friction=q.mu, creep=q.v_c)
SYSTEM = m.system()
"""


def run(
    statement: str, times: np.ndarray, start: dict[str, float] | None = None, **values: float
) -> MotionRun:
    motion = own.dynamics(HEAD + statement, "own", **values)
    state = motion.start()
    for name, value in (start or {}).items():
        state[motion.names.index(name)] = value
    return motion.run(times, state=state)


def test_cubic_strut_swings_at_closed_form_period() -> None:
    """Of m s'' = -k s^3 with amplitude A: 4 K(1/2) sqrt(m/k) / A, with the complete elliptic
    integral K.
    """
    period = 4 * scipy.special.ellipk(0.5) * np.sqrt(2 / 5000) / 0.3
    motion = run(STRUT, np.array([0.0, period / 4, period / 2, period]))
    assert motion.states[0] == pytest.approx([0.3, 0.0, -0.3, 0.3], abs=1e-8)
    assert motion.results["F_rubber"][0] == pytest.approx(5000 * 0.3**3, rel=1e-12)


def test_bushing_is_a_damped_oscillator() -> None:
    times = np.linspace(0, 1, 21)
    decay, root = 6 / 4, np.sqrt(800 / 2 - 1.5**2)
    expected = np.exp(-decay * times) * (np.cos(root * times) + decay / root * np.sin(root * times))
    motion = run(BUSHING, times)
    assert motion.states[0] == pytest.approx(0.3 * expected, abs=1e-8)
    assert motion.states[1] == pytest.approx(-0.15 * expected, abs=1e-8)


@pytest.mark.parametrize("losses", [0.0, 0.6])
def test_rebound_follows_hunt_and_crossley(losses: float) -> None:
    """Without weight, v dv / (1 + D v) integrates in closed form from the speed of impact to that
    of the rebound.
    """
    motion = run(DROP, np.array([0.0, 0.5]), {"h": 1e-6, "h_dot": -2.0}, D_s_m=losses, g_m_s2=1e-9)

    def integral(speed: float) -> float:
        return speed / losses - np.log1p(losses * speed) / losses**2 if losses else speed**2 / 2

    rebound = scipy.optimize.brentq(
        lambda v: integral(-v) - integral(2.0), 1e-3, 1.66 if losses else 3.0
    )
    assert motion.states[3][-1] == pytest.approx(rebound, rel=1e-6)


def test_friction_decelerates_sliding_block() -> None:
    rest = (2 * 9.81 / 300000) ** (2 / 3)
    motion = run(DROP, np.array([0.0, 0.1]), {"h": -rest, "x_dot": 1.0})
    assert motion.results["N_floor"][-1] == pytest.approx(2 * 9.81, rel=1e-6)
    assert motion.states[2][-1] == pytest.approx(1.0 - 0.3 * 9.81 * 0.1, abs=1e-5)


@pytest.mark.parametrize("wrong", ["friction=q.mu, creep=q.w", "friction=q.w, creep=q.v_c"])
def test_force_in_other_units_is_refused_by_name(
    wrong: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where no joint is asked for, no balance would tell."""
    with pytest.raises(AssertionError):
        own.generated(HEAD + DROP.replace("friction=q.mu, creep=q.v_c", wrong))
    assert "DimensionError: floor" in capsys.readouterr().err
