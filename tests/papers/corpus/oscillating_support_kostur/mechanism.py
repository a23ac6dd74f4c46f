"""Pendulums whose supports swing: one from side to side, one up and down; each is a mass on a rod.

The kinetic and potential energies are those of the first, for a unit of mass. The second has a
damper.
"""

from sympy import cos, sin

from derive import Mechanism, quantities

q = quantities("""
    g     | m/s2  | free fall                      | 9.81
    l     | m     | rods                           | 0.6
    a     | m     | how far the supports swing     | 0.1
    omega | rad/s | how fast they swing            | 5
    M     | kg    | masses                         | 0.8
    gamma | 1/s   | half the damping per inertia   | 0.3
""")

m = Mechanism("oscillating_support", q, gravity=q.g)
swing = q.omega * m.time

phi = m.coordinate("phi", "rad", "first rod from the vertical")
A = m.point("A", m.O, m.world, q.a * sin(swing))
rod = m.frame("rod", phi)
P = m.point("P", A, rod, 0, -q.l)
mass = m.body("mass", rod, q.M, P)
m.pin("A", mass, m.ground, A)
m.report(
    "E_k", "m2/s2", "kinetic energy per mass", sum(part**2 for part in m.velocity(P).components) / 2
)
m.report("E_p", "m2/s2", "potential energy per mass", q.g * m.position(P)[1])

psi = m.coordinate("psi", "rad", "second rod from the vertical")
B = m.point("B", m.O, m.world, 0, -q.a * cos(swing))
other = m.frame("other", psi)
S = m.point("S", B, other, 0, -q.l)
hung = m.body("hung", other, q.M, S)
m.pin("B", hung, m.ground, B)
m.torque("damper", hung, m.ground, -2 * q.gamma * q.M * q.l**2 * m.rate(psi))
SYSTEM = m.system()
