"""Two cranks in a fixed relation place a point: a five-bar whose second crank turns twice as fast, the other way.

Each crank has its motor, and the balances give both torques. The cycle is one turn of the first crank.
"""

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | first crank
    omega | r/min | speed of the first crank           | 60
    ratio | 1     | second crank's speed, by the first | -2
    g     | m/s2  | free fall                          | 9.81
    d     | mm    | distance of the shafts             | 120 | 100 160
    r_1   | mm    | first crank                        | 40  | 30 50
    r_2   | mm    | second crank                       | 30  | 20 40
    l_1   | mm    | rod of the first crank             | 150 | 130 180
    l_2   | mm    | rod of the second crank            | 140 | 130 180
    m_P   | kg    | tool at the common point           | 2
""")

m = Mechanism(
    "geared_five_bar", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
psi = m.coordinate("psi", "rad", "second crank", equals=q.ratio * q.phi)
a, b = (
    m.coordinate("a", "rad", "rod of the first crank"),
    m.coordinate("b", "rad", "rod of the second crank"),
)
cranks = m.frame("crank1", q.phi), m.frame("crank2", psi)
rods = m.frame("rod1", a), m.frame("rod2", b)
shaft = m.point("shaft", m.O, m.world, q.d)
A, B = m.point("A", m.O, cranks[0], q.r_1), m.point("B", shaft, cranks[1], q.r_2)
P, Q = m.point("P", A, rods[0], q.l_1), m.point("Q", B, rods[1], q.l_2)
m.close(P, Q, start={a: 1.2, b: 2.0})

first, second = m.body("crank1", cranks[0]), m.body("crank2", cranks[1])
rod1, rod2 = m.body("rod1", rods[0], q.m_P, P), m.body("rod2", rods[1])
m.pin("O", first, m.ground, m.O)
m.pin("S", second, m.ground, shaft)
m.pin("A", rod1, first, A)
m.pin("B", rod2, second, B)
m.pin("P", rod2, rod1, P)
m.motor("M_1", first, m.ground, m.O)
m.motor("M_2", second, m.ground, shaft)
x, y = m.position(P)[:2]
m.report("x_P", "m", "tool, x", x)
m.report("y_P", "m", "tool, y", y)
SYSTEM = m.system()
