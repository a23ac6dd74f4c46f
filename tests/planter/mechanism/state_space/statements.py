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


FOUR_BAR = r'''
from derive import Mechanism, quantities

q = quantities("""
    g | m/s2  | free fall           | 9.81
    a | m     | crank               | 0.1
    b | m     | coupler             | 0.3
    c | m     | rocker              | 0.25
    d | m     | frame               | 0.28
    m | kg    | of each bar         | 0.8
    J | kg m2 | of each, centroidal | 0.005
""")
m = Mechanism("own", q, gravity=q.g)
names = ("crank", "coupler", "rocker")
angles = [m.coordinate(name, "rad", name) for name in names]
T = m.input("T", "N m", "torque on the crank", start=2, low=-5, high=5)
frames = [m.frame(name, angle) for name, angle in zip(names, angles)]
B = m.point("B", m.O, m.world, q.d)
A = m.point("A", m.O, frames[0], q.a)
C = m.point("C", A, frames[1], q.b)
D = m.point("D", B, frames[2], q.c)
m.close(C, D, start={angles[0]: 1.0, angles[1]: 0.5, angles[2]: 1.5})
places = [(m.O, q.a), (A, q.b), (B, q.c)]
bars = [
    m.body(name, frame, q.m, m.point(f"G_{name}", start, frame, length / 2), q.J)
    for name, frame, (start, length) in zip(names, frames, places)
]
m.pin("O", bars[0], m.ground, m.O)
m.pin("A", bars[1], bars[0], A)
m.pin("C", bars[2], bars[1], C)
m.pin("B", bars[2], m.ground, B)
m.torque("drive", bars[0], m.ground, T)
m.begin({angles[0]: 1.0, m.rate(angles[0]): 3})
SYSTEM = m.system()
'''
"""A four-bar linkage whose crank a torque drives."""

PLATFORM = r'''
from derive import Mechanism, quantities

q = quantities("""
    g | m/s2  | free fall           | 9.81
    w | m     | feet                | 1
    r | m     | platform            | 0.25
    m | kg    | platform            | 5
    J | kg m2 | platform            | 0.2
    n | kg    | of each leg         | 0.5
    I | kg m2 | of each leg         | 0.02
    k | N/m   | of each leg         | 4000
    l | m     | its length at rest  | 0.8
""")
m = Mechanism("own", q, gravity=q.g)
x, y, turn = (m.coordinate(n, u, "platform") for n, u in (("x", "m"), ("y", "m"), ("c", "rad")))
frame = m.frame("platform", turn)
centre = m.point("centre", m.O, m.world, x, y)
platform = m.body("platform", frame, q.m, centre, q.J)
for i, (foot, side) in enumerate(((-1, -1), (0, 1), (1, 1))):
    angle = m.coordinate(f"a{i}", "rad", f"leg {i}")
    length = m.coordinate(f"s{i}", "m", f"length of leg {i}")
    F = m.input(f"F{i}", "N", f"push of leg {i}", start=20)
    start = m.point(f"O{i}", m.O, m.world, foot * q.w / 2)
    leg = m.frame(f"leg{i}", angle)
    end = m.point(f"E{i}", start, leg, length)
    corner = m.point(f"P{i}", centre, frame, side * q.r)
    body = m.body(f"leg{i}", leg, q.n, m.point(f"G{i}", start, leg, length / 2), q.I)
    m.force(f"push{i}", platform, corner, (F - q.k * (length - q.l)) * m.vector(leg, 1, 0), body)
    m.close(end, corner, start={angle: 1.5 - 0.3 * foot, length: 0.8, x: 0, y: 0.75, turn: 0})
m.begin({m.rate(x): 0.3, m.rate(turn): 0.5})
SYSTEM = m.system(reported=["kinetic", "potential"])
'''
"""A platform on three legs, each of which pushes: three loops."""


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
