"""A rotary transplanter with eccentric gears: round involute gears that turn about a point beside their centres.

Sun, middle gear and planet are equal. Two involute gears turn as if a string, crossed between their base circles, wound
off one and onto the other, also while the distance of their centres varies; teeth press along the straight part of this
string. The gears mesh without backlash where their centres are nearest, and nowhere tighter; a negative force of the
teeth says that the other flank would bear.
"""

from sympy import atan2, cos, sin, sqrt

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | carrier angle
    omega | r/min | carrier speed                              | 60
    g     | m/s2  | free fall                                  | 9.81
    a     | mm    | distance of neighbouring shafts            | 42     | 36 52
    e     | mm    | centre of a gear, from its shaft           | 3      | 0 5
    alpha | deg   | pressure angle where centres are nearest   | 20     | 15 25
    t_0   | deg   | sun, from its long side to the middle gear | 20     | -180 180
    bend  | deg   | centre lines, the outer against the inner  | -50    | -90 0
    arm_0 | deg   | arm, from the long side of the planet      | -30    | -180 180
    l     | mm    | tip of the arm, from the planet's shaft    | 150    | 120 180
    s     | mm    | centroid of planet and arm                 | 42
    m_m   | kg    | middle gear                                | 0.21
    m_p   | kg    | planet with its arm                        | 0.64
    J_m   | kg m2 | middle gear, about its shaft               | 0.00004
    J_p   | kg m2 | planet with its arm, centroidal            | 0.0011
""")

m = Mechanism(
    "eccentric_train", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
psi = m.coordinate("psi", "rad", "middle gear, its long side from the inner line")
chi = m.coordinate("chi", "rad", "planet, its long side from the outer line")

carrier, outwards = m.frame("carrier", q.phi), m.frame("outwards", q.phi + q.bend)
sun, middle = m.frame("sun", q.t_0), m.frame("middle", q.phi + psi)
planet = m.frame("planet", q.phi + q.bend + chi)
arm = m.frame("arm", q.arm_0, parent=planet)
B = m.point("B", m.O, carrier, q.a)
C = m.point("C", B, outwards, q.a)
tip = m.point("tip", C, arm, q.l)

fixed, spider = m.body("sun", sun), m.body("carrier", carrier)
gear = m.body("middle gear", middle, q.m_m, B, q.J_m)
plants = m.body("planet", planet, q.m_p, m.point("centroid", C, arm, q.s), q.J_p)
m.weld("sun", fixed, m.ground, m.O)
m.pin("O", spider, m.ground, m.O)
m.pin("B", gear, spider, B)
m.pin("C", plants, spider, C)


def mesh(tag, inner, outer, line, shaft, angles, frame, start):
    """State that teeth of two gears touch, at angles of their long sides from the line of shafts, and press."""
    first, second = angles
    base = q.a / 2 * cos(q.alpha)
    x, y = q.a + q.e * (cos(second) - cos(first)), q.e * (sin(second) - sin(first))
    string = sqrt(x**2 + y**2 - 4 * base**2)
    normal = atan2(y, x) + atan2(string, 2 * base)
    slack = string - q.a * sin(q.alpha) - base * (2 * normal - 2 * q.alpha - first - second)
    m.constrain(tag, slack, start=start)
    centre = m.point(f"centre {tag}", shaft, frame, q.e)
    touch = m.point(f"touch {tag}", centre, line, base * cos(normal), base * sin(normal))
    m.contact(tag, outer, inner, touch, m.vector(line, sin(normal), -cos(normal)))


mesh("P", fixed, gear, carrier, m.O, (q.t_0 - q.phi, psi), sun, {psi: -q.t_0})
mesh("Q", gear, plants, outwards, B, (psi - q.bend, chi), middle, {chi: q.bend + q.t_0})
m.motor("M_in", spider, m.ground, m.O)

m.report("x_tip", "m", "tip of the arm, x", m.position(tip)[0])
m.report("y_tip", "m", "tip of the arm, y", m.position(tip)[1])
SYSTEM = m.system()
