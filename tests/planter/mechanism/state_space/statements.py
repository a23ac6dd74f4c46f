"""Mechanisms that move freely, for tests of models and their exports."""

from typing import Any

import numpy as np
import pytest

CART = r'''
from sympy import pi
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall           | 9.81
    l   | m     | rod                 | 0.5
    m_c | kg    | cart                | 1
    m_p | kg    | bob                 | 0.3
    d   | N s/m | damping of the cart | 0.1
""")
m = Mechanism("own", q, gravity=q.g)
s = m.coordinate("s", "m", "place of the cart")
a = m.coordinate("a", "rad", "rod, from hanging down")
F = m.input("F", "N", "force on the cart", low=-12, high=12)
P = m.point("C", m.O, m.world, s)
cart = m.body("cart", m.world, q.m_c, P)
rod = m.frame("rod", a - pi / 2)
bob = m.body("bob", rod, q.m_p, m.point("B", P, rod, q.l))
m.slide("rail", cart, m.ground, P)
m.pin("A", bob, cart, P)
m.force("push", cart, P, m.vector(m.world, F - q.d * m.rate(s), 0))
SYSTEM = m.system()
'''
"""A pendulum on a cart with a force as its input."""

CRANKS = r'''
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall             | 9.81
    r   | m     | cranks                | 0.3
    w   | m     | distance of the pins  | 0.4
    J   | kg m2 | crank, about its axis | 0.04
    m_b | kg    | coupler               | 2
    J_b | kg m2 | coupler               | 0.1
    T   | N m   | torque on the first   | 2
""")
m = Mechanism("own", q, gravity=q.g)
angles = [m.coordinate(f"a{i}", "rad", f"crank {i}") for i in range(3)]
turn = m.coordinate("c", "rad", "coupler")
pivots = [m.point(f"O{i}", m.O, m.world, i * q.w) for i in range(3)]
frames = [m.frame(f"crank{i}", angles[i]) for i in range(3)]
tips = [m.point(f"E{i}", pivots[i], frames[i], q.r) for i in range(3)]
cranks = [m.body(f"crank{i}", frames[i], 0, pivots[i], q.J) for i in range(3)]
frame = m.frame("coupler", turn)
coupler = m.body("coupler", frame, q.m_b, m.point("C", tips[0], frame, q.w), q.J_b)
m.pin("P0", coupler, cranks[0], tips[0])
for i in range(3):
    m.pin(f"A{i}", cranks[i], m.ground, pivots[i])
for i in (1, 2):
    at = m.point(f"Q{i}", tips[0], frame, i * q.w)
    m.pin(f"P{i}", coupler, cranks[i], tips[i])
    m.close(at, tips[i], start={angles[i]: 1.0, turn: 0})
m.torque("drive", cranks[0], m.ground, q.T)
m.begin({angles[0]: 1.0})
SYSTEM = m.system(reported=["kinetic", "potential"])
'''
"""Three equal cranks carry a coupler: one constraint follows from the others."""

RUBBING = r'''
from sympy import cos, sin
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall           | 9.81
    l   | m     | rod                 | 0.4
    m_r | kg    | rod                 | 0.7
    J   | kg m2 | rod, centroid       | 0.01
    M   | kg    | slider              | 1.3
    mu  | 1     | friction of guide   | 0.2
    v_c | m/s   | creep               | 0.05
""")
m = Mechanism("own", q, gravity=q.g)
s, a = m.coordinate("s", "m", "slider"), m.coordinate("a", "rad", "rod")
P = m.point("P", m.O, m.world, s)
F = m.input("F", "N", "push", start=3)
slider = m.body("slider", m.world, q.M, P)
frame = m.frame("rod", a)
rod = m.body("rod", frame, q.m_r, m.point("G", P, frame, q.l / 2), q.J)
m.pin("A", rod, slider, P)
m.slide("floor", slider, m.ground, P, friction=q.mu, creep=q.v_c)
m.force("push", slider, P, m.vector(m.world, F, 0))
m.begin({a: -0.4, m.rate(s): 0.3, m.rate(a): 1.1})
SYSTEM = m.system()
'''
"""Friction of a normal force that the motion decides on."""

CHAIN = r'''
from derive import Mechanism, quantities

q = quantities("""
    g | m/s2  | free fall          | 9.81
    l | m     | rods               | 0.4
    m | kg    | of each rod        | 1
    J | kg m2 | about its centroid | 0.01
""")
m = Mechanism("own", q, gravity=q.g)
end, before, angle = m.O, m.ground, 0
for i in range(LINKS):
    angle = angle + m.coordinate(f"q{i}", "rad", f"relative angle {i}")
    frame = m.frame(f"rod{i}", angle)
    rod = m.body(f"b{i}", frame, q.m, m.point(f"C{i}", end, frame, q.l / 2), q.J)
    m.pin(f"A{i}", rod, before, end)
    end, before = m.point(f"P{i}", end, frame, q.l), rod
SYSTEM = m.system(reported=["kinetic", "potential"])
'''
"""A chain of rods; the word LINKS is their number."""


ODD = r'''
from derive import Mechanism, quantities

q = quantities("""
    g      | m/s2  | free <fall> & "rise" */ \\ ??/ | 9.81
    double | m     | rod, größer                   | 0.5
    u      | kg    | bob                           | 0.3
    x      | kg    | cart                          | 0.7
    p      | N s/m | damping                       | 0.7
""")
m = Mechanism("own", q, gravity=q.g)
s = m.coordinate("t", "m", 'place of\nthe */ cart ???/ \\u0 """ c')
a = m.coordinate("pivot", "rad", "rod")
F = m.input("N", "N", "push")
P = m.point("C", m.O, m.world, s)
cart = m.body("cart", m.world, q.x, P)
rod = m.frame("rod", a)
bob = m.body("bob", rod, q.u, m.point("B", P, rod, q.double))
m.slide("rail", cart, m.ground, P)
m.pin("A", bob, cart, P)
m.force("push", cart, P, m.vector(m.world, F - q.p * m.rate(s), 0))
SYSTEM = m.system()
'''
"""Names that languages use themselves, meanings that would end comments."""


def build_chain(links: int) -> str:
    """Return the statement of a chain."""
    return CHAIN.replace("LINKS", str(links))


def build_tree(links: int) -> Any:
    """Return Pinocchio's model of the same."""
    pin = pytest.importorskip("pinocchio")
    tree = pin.Model()
    tree.gravity.linear = np.array([0, -9.81, 0])
    joint = 0
    for k in range(links):
        place = pin.SE3(np.eye(3), np.array([0.4 * (k > 0), 0, 0]))
        joint = tree.addJoint(joint, pin.JointModelRZ(), place, f"joint {k}")
        inertia = pin.Inertia(1.0, np.array([0.2, 0, 0]), np.diag([0, 0, 0.01]))
        tree.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    return tree
