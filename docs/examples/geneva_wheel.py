"""An inverse Geneva wheel of three slots: a crank pin turns the wheel by a third of a turn, and lets it rest.

While the pin is in a slot, the slot follows it; psi is the slot's angle, and begins anew with the next slot.
"""

from sympy import Ge, Piecewise, atan2, cos, pi, sin, sqrt

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle, from the wheel's shaft
    omega | r/min | crank speed                  | 60
    L     | mm    | distance of the shafts       | 80
    J     | kg m2 | wheel                        | 0.004
    m_w   | kg    | wheel                        | 1.5
""")
share = sqrt(3) / 2  # crank over the distance of the shafts, so that the pin enters along the slot
R = share * q.L


def engaged(inside, outside):
    """What is so while the pin is in a slot, and else."""
    return Piecewise((inside, Ge(share - cos(q.phi), 0)), (outside, True))


m = Mechanism("geneva_wheel", q, angle=q.phi, speed=q.omega, source="the example of the guide")
rest = Piecewise((-pi / 3, Ge(sin(q.phi), 0)), (pi / 3, True))
psi = m.coordinate(
    "psi", "rad", "wheel", equals=engaged(atan2(-share * sin(q.phi), 1 - share * cos(q.phi)), rest)
)
crank, wheel = m.frame("crank", q.phi), m.frame("wheel", psi)
A, B = m.point("A", m.O, crank, R), m.point("B", m.O, m.world, q.L)

arm, disc = m.body("crank", crank), m.body("wheel", wheel, q.m_w, B, q.J)
m.pin("O", arm, m.ground, m.O)
m.pin("B", disc, m.ground, B)
x, y = R * cos(q.phi) - q.L, R * sin(q.phi)
m.contact("slot", disc, arm, A, m.vector(m.world, -y / sqrt(x**2 + y**2), x / sqrt(x**2 + y**2)))
m.motor("M_in", arm, m.ground, m.O)
SYSTEM = m.system()
