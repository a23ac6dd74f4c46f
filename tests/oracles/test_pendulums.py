"""Pendulum, double pendulum and spinning top against quadratures and elliptic functions, by
mpmath.
"""

import mpmath
import numpy as np
import pytest
from mpmath import mp

from planter.mechanism.dynamics import Dynamics
from planter.mechanism.motion import eigenvalues, equilibrium
from tests.support import own

DOUBLE = '''
from derive import Mechanism, quantities

q = quantities("""
    g  | m/s2  | free fall             | 9.81
    l1 | m     | first rod             | 0.7
    l2 | m     | second rod            | 0.4
    m1 | kg    | first bob             | 1.3
    m2 | kg    | second bob            | 0.8
    a0 | rad   | start of the first    | 0.3
    b0 | rad   | start of the second   | 0.5
    w1 | rad/s | its rate              | 0
    w2 | rad/s | that of the second    | 0
""")
m = Mechanism("double", q, gravity=q.g)
a, b = m.coordinate("a", "rad", "first, from below"), m.coordinate("b", "rad", "second, from below")
first, second = m.frame("first", a), m.frame("second", b)
A = m.point("A", m.O, first, 0, -q.l1)
B = m.point("B", A, second, 0, -q.l2)
one, two = m.body("one", first, q.m1, A), m.body("two", second, q.m2, B)
m.pin("O", one, m.ground, m.O)
m.pin("A", two, one, A)
m.begin({a: q.a0, b: q.b0, m.motion.rates[a]: q.w1, m.motion.rates[b]: q.w2})
SYSTEM = m.system()
'''
TOP = '''
from derive import Mechanism, X, Z, quantities

q = quantities("""
    g    | m/s2  | free fall, against z        | 9.81
    m    | kg    | top                         | 0.5
    l    | m     | centroid, from its tip      | 0.08
    A    | kg m2 | across its axis, centroidal | 0.0007
    C    | kg m2 | about its axis              | 0.0011
    tilt | rad   | start                       | 0.6
    spin | rad/s | start                       | 140
""")
m = Mechanism("top", q, gravity=(0, 0, -q.g), spatial=True)
phi, theta, psi = (m.coordinate(n, "rad", n) for n in ("precession", "nutation", "rotation"))
axis = m.frame("axis", theta, X, m.frame("course", phi))
body = m.frame("top", psi, Z, axis)
top = m.body("top", body, q.m, m.point("G", m.O, axis, 0, 0, q.l), (q.A, q.A, q.C))
m.ball("O", top, m.ground, m.O)
m.begin({theta: q.tilt, m.motion.rates[psi]: q.spin})
SYSTEM = m.system()
'''


def double(**values: float) -> Dynamics:
    return own.dynamics(DOUBLE, "double", **values)


def test_small_swings_of_two_bobs() -> None:
    """det(K - w^2 M) = 0 with M = [[m l1^2, m2 l1 l2], [., m2 l2^2]], K = g diag(m l1, m2 l2), m =
    m1 + m2.
    """
    l1, l2, m1, m2, g = 0.7, 0.4, 1.3, 0.8, 9.81
    mass = np.array([[(m1 + m2) * l1**2, m2 * l1 * l2], [m2 * l1 * l2, m2 * l2**2]])
    stiff = g * np.diag([(m1 + m2) * l1, m2 * l2])
    rates = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiff)))
    dynamics = double()
    roots = eigenvalues(dynamics, equilibrium(dynamics))
    assert own.deviation("real parts", roots.real, 0) < 1e-11
    assert own.deviation("rates", np.sort(roots.imag), np.sort([*rates, *-rates])) < 1e-11


def test_two_bobs_without_gravity_turn_as_their_quadrature_says() -> None:
    """Energy and momentum L stand, so the angle d between the rods obeys d'^2 = (2T - L^2/I)/(B -
    (B + D c)^2/I).
    """
    l1, l2, m1, m2 = map(mp.mpf, ("0.7", "0.4", "1.3", "0.8"))
    w1, w2, start = mp.mpf(-2), mp.mpf(9), mp.mpf("0.2")
    a, b, d = (m1 + m2) * l1**2, m2 * l2**2, m2 * l1 * l2
    c = mp.cos(start)
    moment = (a + d * c) * w1 + (b + d * c) * w2
    twice = a * w1**2 + b * w2**2 + 2 * d * c * w1 * w2

    def pace(angle: object) -> object:
        reach = b + d * mp.cos(angle)
        inertia = a + b + 2 * d * mp.cos(angle)
        return mp.sqrt((b - reach**2 / inertia) / (twice - moment**2 / inertia))

    dynamics = double(g_m_s2=0.0, a0_rad=0.3, b0_rad=0.5, w1_rad_s=-2.0, w2_rad_s=9.0)
    ends = [mp.mpf(k) for k in range(1, 13)]
    times = np.array([0.0, *(float(mp.quad(pace, [start, *ends[:k]])) for k in range(1, 13))])
    run = dynamics.run(times, 1e-13)
    between = run.states[1, 1:] - run.states[0, 1:]
    assert own.deviation("angle between the rods", between, np.array(ends, float)) < 1e-11


def exact_tilt(times: np.ndarray) -> np.ndarray:
    """Cosine of a heavy top's tilt, released without precession (Whittaker, Analytical dynamics,
    sections 71-72).

    u'^2 = beta (u0 - u)(1 - u^2) - a^2 (u0 - u)^2, a = C spin/A, beta = 2 m g l/A:
    u = u1 + (u0 - u1) sn^2(K + sqrt(beta (u3 - u1))/2 t).
    """
    with mp.workdps(30):
        g, m, length, tilt, spin = map(mp.mpf, ("9.81", "0.5", "0.08", "0.6", "140"))
        across = mp.mpf("0.0007") + m * length**2
        a, beta, u0 = mp.mpf("0.0011") * spin / across, 2 * m * g * length / across, mp.cos(tilt)
        half = a**2 / beta
        root = mp.sqrt(half**2 / 4 - half * u0 + 1)
        u1, u3 = half / 2 - root, half / 2 + root
        modulus = (u0 - u1) / (u3 - u1)
        pace, quarter = mp.sqrt(beta * (u3 - u1)) / 2, mp.ellipk(modulus)
        return np.array(
            [
                float(u1 + (u0 - u1) * mpmath.ellipfun("sn", quarter + pace * t, m=modulus) ** 2)
                for t in times
            ]
        )


def test_a_spinning_top_nods_as_elliptic_functions_say() -> None:
    times = np.linspace(0, 1, 41)
    run = own.dynamics(TOP, "top").run(times, 1e-13)
    assert np.ptp(run.states[1]) > 0.05
    assert own.deviation("cosine of the tilt", np.cos(run.states[1]), exact_tilt(times)) < 1e-11
    energy = run.results["kinetic"] + run.results["potential"]
    assert own.deviation("energy", energy, energy[0]) < 1e-11 * energy[0]


def test_slightly_slower_top_is_detected() -> None:
    times = np.linspace(0, 1, 41)
    run = own.dynamics(TOP, "top", spin_rad_s=139.9999).run(times, 1e-12)
    assert np.abs(np.cos(run.states[1]) - exact_tilt(times)).max() > 1e-8


def test_the_tip_bears_weight_and_momentum() -> None:
    """Momentum from central differences of the centroid's place."""
    step = 1e-4
    dynamics = own.dynamics(TOP, "top")
    run = dynamics.run(np.array([0.0, 0.3 - step, 0.3, 0.3 + step]), 1e-12)
    phi, theta = run.states[:2]
    place = 0.08 * np.array(
        [np.sin(theta) * np.sin(phi), -np.sin(theta) * np.cos(phi), np.cos(theta)]
    )
    bent = 0.5 * (place[:, 3] - 2 * place[:, 2] + place[:, 1]) / step**2
    force = [run.results[f"F_O{axis}"][2] for axis in "xyz"]
    assert force == pytest.approx(bent + np.array([0, 0, 0.5 * 9.81]), rel=1e-5, abs=1e-5)
    assert run.undetermined == ()
