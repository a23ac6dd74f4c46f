"""A planetary train that plants: a fixed sun, a middle gear and a planet with the planting arm, on a turning carrier.

Sun, middle gear and planet are equal ellipses that turn about a focus each: as one turns by t from its long side, its
mate, whose short side met it, turns by t + 2 atan2(k sin t, 1 - k cos t). The middle gear meshes with the sun and with
the planet; so the planet turns back by one turn while the carrier goes round, unevenly, and the arm's tip draws a loop.
"""

from sympy import atan2, cos, sin

from derive import GearContact, Mechanism, quantities, tangent_angle

q = quantities("""
    phi   | rad   | carrier angle
    omega | r/min | carrier speed                              | 60
    eps   | rad/s2 | acceleration of the carrier               | 0
    g     | m/s2  | free fall                                  | 9.81
    A     | mm    | half the long axis of the ellipses         | 21     | 18 26
    k     | 1     | their eccentricity                         | 0.14   | 0 0.3
    t_0   | deg   | sun, from its long side to the middle gear | 20     | -180 180
    bend  | deg   | centre lines, the outer against the inner  | -50    | -90 0
    arm_0 | deg   | arm, from the carrier, at the start        | -60    | -180 180
    l     | mm    | tip of the arm, from the planet's shaft    | 150    | 120 180
    s     | mm    | centroid of planet and arm                 | 42
    m_m   | kg    | middle gear                                | 0.21
    m_p   | kg    | planet with its arm                        | 0.64
    J_m   | kg m2 | middle gear, about its shaft               | 0.00004
    J_p   | kg m2 | planet with its arm, centroidal            | 0.0011
    alpha | deg   | pressure angle of the teeth                | 20
    rho   | deg   | angle of friction of the teeth             | 5
""")


def turned(t):
    """How far the mate of an ellipse has turned."""
    return t + 2 * atan2(q.k * sin(t), 1 - q.k * cos(t))


def radius(t):
    return q.A * (1 - q.k**2) / (1 - q.k * cos(t))


m = Mechanism(
    "planetary_train",
    q,
    angle=q.phi,
    speed=q.omega,
    acceleration=q.eps,
    gravity=q.g,
    source="the example of the guide",
)
t1 = m.coordinate("t1", "rad", "sun, from its long side to the middle gear", equals=q.t_0 + q.phi)
psi = m.coordinate("psi", "rad", "middle gear, on the carrier", equals=turned(t1) - turned(q.t_0))
t2 = m.coordinate(
    "t2", "rad", "middle gear, from its long side to the planet", equals=q.bend - turned(t1)
)
chi = m.coordinate(
    "chi", "rad", "planet, on the carrier", equals=turned(t2) - turned(q.bend - turned(q.t_0))
)

carrier, outwards = m.frame("carrier", q.phi), m.frame("outwards", q.phi + q.bend)
middle, planet = m.frame("middle", q.phi + psi), m.frame("planet", q.phi + chi + q.arm_0)
B = m.point("B", m.O, carrier, 2 * q.A)
C = m.point("C", B, outwards, 2 * q.A)
tip = m.point("tip", C, planet, q.l)

sun = m.body("sun", m.world)
arm = m.body("carrier", carrier)
gear = m.body("middle gear", middle, q.m_m, B, q.J_m)
plants = m.body("planet", planet, q.m_p, m.point("centroid", C, planet, q.s), q.J_p)
m.weld("sun", sun, m.ground, m.O)
m.pin("O", arm, m.ground, m.O)
m.pin("B", gear, arm, B)
m.pin("C", plants, arm, C)
for tag, inner, outer, line, centre, t, turning in (
    ("P", sun, gear, carrier, B, t1, m.world),
    ("Q", gear, plants, outwards, C, t2, middle),
):
    r = m.name_(f"r_{tag}", "m", f"pitch radius of the {inner}", radius(t))
    tangent = tangent_angle(m.motion, line, turning, t, r, radius(t).diff(t))
    m.mesh(tag, inner, outer, GearContact(line, centre, 2 * q.A - r, q.alpha, q.rho, tangent))
m.motor("M_in", arm, m.ground, m.O)

m.report("x_tip", "m", "tip of the arm, x", m.position(tip)[0])
m.report("y_tip", "m", "tip of the arm, y", m.position(tip)[1])
SYSTEM = m.system()
