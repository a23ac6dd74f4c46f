"""Statements of mechanisms that move freely, for the table of dynamics."""

from __future__ import annotations

import re

from tests.planter.mechanism.test_size import statement
from tests.support import own

FOUR_BAR = r'''
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall           | 9.81
    a   | m     | crank               | 0.1
    b   | m     | coupler             | 0.35
    c   | m     | rocker              | 0.25
    d   | m     | ground              | 0.4
    m_a | kg    | crank               | 0.5
    J_a | kg m2 | crank, centroidal   | 0.0005
    m_b | kg    | coupler             | 1.2
    J_b | kg m2 | coupler, centroidal | 0.012
    m_c | kg    | rocker              | 0.9
    J_c | kg m2 | rocker, centroidal  | 0.005
""")
m = Mechanism("own", q, gravity=q.g)
alpha, beta, gamma = (m.coordinate(n, "rad", f"bar {n}") for n in ("alpha", "beta", "gamma"))
T = m.input("T", "N m", "torque on the crank")
k1, k2, k3 = m.frame("k1", alpha), m.frame("k2", beta), m.frame("k3", gamma)
D = m.point("D", m.O, m.world, q.d)
A, B = m.point("A", m.O, k1, q.a), m.point("B", D, k3, q.c)
E = m.point("E", A, k2, q.b)
m.close(E, B, start={alpha: 1, beta: 0.5, gamma: 1.5})
crank = m.body("crank", k1, q.m_a, m.point("C1", m.O, k1, q.a / 2), q.J_a)
coupler = m.body("coupler", k2, q.m_b, m.point("C2", A, k2, q.b / 2), q.J_b)
rocker = m.body("rocker", k3, q.m_c, m.point("C3", D, k3, q.c / 2), q.J_c)
m.pin("O", crank, m.ground, m.O)
m.pin("A", coupler, crank, A)
m.pin("B", rocker, coupler, B)
m.pin("D", rocker, m.ground, D)
m.torque("drive", crank, m.ground, T)
m.begin({alpha: 1.0})
SYSTEM = m.system(reported=["kinetic", "potential"])
'''
"""A four-bar linkage that gravity and a torque move."""

_PLATFORM = """x, y, z = (m.coordinate(n, "m", f"platform, {n}") for n in "xyz")
yaw, pitch, roll = (m.coordinate(n, "rad", n) for n in ("yaw", "pitch", "roll"))
P = m.point("P", m.O, m.world, x, y, z)
plat = m.frame("plat", roll, X, m.frame("pitched", pitch, Y, m.frame("yawed", yaw, Z)))
"""
_CHANGES = {
    r"    (phi|omega|A|B|C|S) \| .*\n": "",
    r"    m_p \|": "    K | N/m | springs of the legs | 20000\n    m_p |",
    r'Mechanism\("stewart"': 'Mechanism("own"',
    r"angle=q.phi, speed=q.omega, ": "",
    r"(?s)x = m.coordinate.*?(?=platform = m.body)": _PLATFORM,
    r"m.actuator\((.*)\)": r"m.spring(\1, q.K, q.h)",
    r"SYSTEM = m.system\(\)": 'm.begin({z: q.h})\nSYSTEM = m.system(["kinetic", "potential"])',
}
"""What the statement of a driven platform says differently where it is free."""


def build_platform() -> str:
    """Return the statement of a Stewart platform of six degrees of freedom on springs."""
    text = statement("stewart")
    for pattern, replacement in _CHANGES.items():
        text, count = re.subn(pattern, replacement, text)
        assert count, pattern
    return text


def build_released_device() -> str:
    """Return the statement of the planting device of Wang et al. (2017), released alone."""
    return (own.EXAMPLES / "released_device.py").read_text("utf-8") + "SYSTEMS = SYSTEMS[1:]\n"
