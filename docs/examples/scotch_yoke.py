"""A scotch yoke: a crank pin in a block that slides across a yoke, whose motion is harmonic."""

from sympy import cos

from derive import Mechanism, X, Y, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed            | 240
    r     | mm    | crank                  | 40  | 20 60
    m_y   | kg    | yoke                   | 1.2
    F_l   | N     | load against the yoke  | 80
""")

m = Mechanism("scotch_yoke", q, angle=q.phi, speed=q.omega, source="the example of the guide")
s = m.coordinate("s", "m", "place of the yoke", equals=q.r * cos(q.phi))
crank = m.frame("crank", q.phi)
A, P = m.point("A", m.O, crank, q.r), m.point("P", m.O, m.world, s)

wheel, block = m.body("crank", crank), m.body("block", m.world)
yoke = m.body("yoke", m.world, q.m_y, P)
m.pin("O", wheel, m.ground, m.O)
m.pin("A", block, wheel, A)
m.slide("slot", block, yoke, A, along=Y, origin=P)
m.slide("guide", yoke, m.ground, P, along=X)
m.force("load", yoke, P, m.vector(m.world, -q.F_l))
m.motor("M_in", wheel, m.ground, m.O)
SYSTEM = m.system()
