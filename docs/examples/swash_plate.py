"""A piston of an axial pump: a block turns it about x, a slanted plate that stands still pushes it."""

from sympy import cos, tan

from derive import Mechanism, X, Z, quantities

q = quantities("""
    phi   | rad   | block angle
    omega | r/min | block speed                 | 1500
    R     | mm    | pitch circle of the pistons | 35   | 20 50
    beta  | deg   | tilt of the plate           | 18   | 5 25
    m_p   | kg    | piston                      | 0.08
    F_p   | N     | force of the oil            | 900
""")

m = Mechanism(
    "swash_plate", q, angle=q.phi, speed=q.omega, spatial=True, source="the example of the guide"
)
s = m.coordinate("s", "m", "place of the piston", equals=q.R * tan(q.beta) * cos(q.phi))
block = m.frame("block", q.phi, X)
P = m.point("P", m.O, block, s, q.R)

drum, piston = m.body("block", block), m.body("piston", block, q.m_p, P)
m.pin("O", drum, m.ground, m.O, X)
m.slide("bore", piston, drum, P, along=X)
m.contact("plate", piston, m.ground, P, m.vector(m.frame("plate", -q.beta, Z), 1))
m.force("oil", piston, P, m.vector(m.world, -q.F_p))
m.motor("M_in", drum, m.ground, m.O, X)
SYSTEM = m.system()
