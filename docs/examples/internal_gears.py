"""A planet inside a ring, pitch curves not round: the crank of a plunger turns unevenly, at a third on average.

The ring turns by psi = i (phi + e sin phi) while the planet, the driver, turns by phi; the planet's centre stays. Where
the ratio is f = i (1 + e cos phi), the pitch radii are a f / (1 - f) of the planet and a / (1 - f) of the ring, whose
difference is the distance a of the centres (F. L. Litvin, A. Fuentes, Gear geometry and applied theory, chapter 12,
with the sign of an internal pair).
"""

from sympy import cos, sin

from derive import GearContact, Mechanism, quantities, tangent_angle

q = quantities("""
    phi   | rad   | planet angle
    omega | r/min | planet speed                    | 120
    eps   | rad/s2 | acceleration of the planet     | 0
    a     | mm    | distance of the centres         | 60    | 40 80
    i     | 1     | mean ratio of the speeds        | 0.3333333333333333
    e     | 1     | swing of the ratio              | 0.15  | 0 0.4
    m     | kg    | ring with its crank, balanced   | 5
    J     | kg m2 | ring with its crank             | 0.02
    alpha | deg   | pressure angle of the teeth     | 20
    M_r   | N m   | resistance at the ring          | 12
""")
ratio = q.i * (1 + q.e * cos(q.phi))

m = Mechanism(
    "internal_gears",
    q,
    angle=q.phi,
    speed=q.omega,
    acceleration=q.eps,
    source="the example of the guide",
)
psi = m.coordinate("psi", "rad", "ring", equals=q.i * (q.phi + q.e * sin(q.phi)))
r_r = m.name_("r_r", "m", "pitch radius of the ring", q.a / (1 - ratio))
centre = m.point("D", m.O, m.world, q.a)
planet, ring = (
    m.body("planet", m.frame("planet", q.phi)),
    m.body("ring", m.frame("ring", psi), q.m, centre, q.J),
)
m.pin("O", planet, m.ground, m.O)
m.pin("D", ring, m.ground, centre)
radius = q.a * ratio / (1 - ratio)
tangent = tangent_angle(m.motion, m.world, planet.frame, q.phi, radius, radius.diff(q.phi))
m.mesh(
    "P", planet, ring, GearContact(m.world, centre, r_r, q.alpha, tangent=tangent, internal=True)
)
m.torque("plunger", ring, m.ground, -q.M_r)
m.motor("M_in", planet, m.ground, m.O)
SYSTEM = m.system()
