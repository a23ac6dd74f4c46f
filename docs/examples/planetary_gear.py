"""A planetary gear of round wheels that drives a seed drum: sun, three planets and a fixed ring under constant load.

The sun turns the carrier (z_s + z_r) / z_s times slower. Balances alone do not say how three rigid planets share the
load, so each bears a third of it, as planets do that float a little.
"""

from sympy import Rational, pi

from derive import GearContact, Mechanism, quantities

q = quantities("""
    phi   | rad   | sun angle
    omega | r/min | sun speed                        | 300
    m     | mm    | module                           | 2
    z_s   | 1     | teeth of the sun                 | 18    | 12 30
    z_p   | 1     | teeth of a planet                | 27    | 15 40
    alpha | deg   | pressure angle of the teeth      | 20
    M_d   | N m   | torque of the drum on the carrier | 24
""")
z_r = q.z_s + 2 * q.z_p
r_s, r_p, r_r = q.m * q.z_s / 2, q.m * q.z_p / 2, q.m * z_r / 2

m = Mechanism("planetary_gear", q, angle=q.phi, speed=q.omega, source="the example of the guide")
turn = m.coordinate("psi", "rad", "carrier", equals=q.phi * q.z_s / (q.z_s + z_r))
spin = m.coordinate("chi", "rad", "planets, against the world", equals=turn * (1 - z_r / q.z_p))

sun, arm = m.body("sun", m.frame("sun", q.phi)), m.body("carrier", m.frame("carrier", turn))
ring = m.body("ring", m.world)
m.weld("ring", ring, m.ground, m.O)
m.pin("O", sun, m.ground, m.O)
m.pin("D", arm, m.ground, m.O)
first = None
for number in range(3):
    line = m.frame(f"line {number}", turn + number * 2 * pi * Rational(1, 3))
    inwards = m.frame(f"line {number}, inwards", pi, parent=line)
    centre = m.point(f"P{number}", m.O, line, r_s + r_p)
    planet = m.body(
        f"planet {number}", m.frame(f"planet {number}", spin + number * 2 * pi * Rational(1, 3))
    )
    m.pin(f"P{number}", planet, arm, centre)
    moment = m.mesh(
        f"S{number}", sun, planet, GearContact(line, centre, r_p, q.alpha), equal_to=first
    )
    m.mesh(f"R{number}", planet, ring, GearContact(inwards, m.O, r_r, q.alpha, internal=True))
    first = first or moment
m.torque("drum", arm, m.ground, -q.M_d)
m.motor("M_in", sun, m.ground, m.O)
SYSTEM = m.system()
