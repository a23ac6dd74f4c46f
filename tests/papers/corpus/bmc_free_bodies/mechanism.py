"""Five bodies in a vertical plane: a thrown ball, a bar that hangs, one that stands, a person, and
a bar that rocks.

The ball is dragged back and its spin is braked; both bars turn about one of their ends; the person
turns about the ankles, which the muscles bend; the rocking bar has a round end that rolls on the
ground without slip.
"""

from sympy import Expr

from derive import Mechanism, Quantity, quantities
from derive.mechanics.frames import Point

q = quantities("""
    g    | m/s2    | free fall                              | 9.81
    m    | kg      | ball, each of the bars                 | 1.4
    R    | m       | radius of the ball, of the round end   | 0.11
    b_l  | kg/s    | drag on the ball                       | 0.3
    b_r  | kg m2/s | brake on its spin                      | 0.02
    l    | m       | bars with a fixed end                  | 0.8
    m_B  | kg      | person                                 | 70
    h_G  | m       | centroid of the person above the ankle | 0.9
    T_A  | N m     | torque of the muscles                  | 20
    L    | m       | length of the rocking bar              | 0.9
""")

m = Mechanism("free_bodies", q, gravity=q.g)

# The ball: a full sphere would have another inertia; this one is a disc.
x, y = m.coordinate("x", "m", "ball, across"), m.coordinate("y", "m", "ball, up")
spin = m.coordinate("spin", "rad", "turn of the ball")
C = m.point("C", m.O, m.world, x, y)
ball = m.body("ball", m.frame("ball", spin), q.m, C, q.m * q.R**2 / 2)
m.force("drag", ball, C, m.vector(m.world, -q.b_l * m.rate(x), -q.b_l * m.rate(y)))
m.torque("brake", ball, m.ground, -q.b_r * m.rate(spin))


def report_moments(
    name: str, centroid: Point, pole: Point, mass: Expr, inertia: Expr, turn: Quantity
) -> None:
    """Report the angular momentum of a body about a pole at rest and the moment of its weight about
    that.
    """
    arm = m.position(centroid) - m.position(pole)
    m.report(
        f"H_{name}",
        "N m s",
        "angular momentum",
        inertia * m.rate(turn) + mass * arm.cross(m.velocity(centroid))[2],
    )
    m.report(f"M_{name}", "N m", "moment of the weight", -mass * q.g * arm[0])


# Bars with a fixed end, whose angles are from the vertical, down and up.
hang, stand = (
    m.coordinate("hang", "rad", "hanging bar"),
    m.coordinate("stand", "rad", "standing bar"),
)
down, up = m.frame("down", hang), m.frame("up", stand)
D, U = m.point("D", m.O, down, 0, -q.l / 2), m.point("U", m.O, up, 0, q.l / 2)
for name, frame, at, turn in (("hanging", down, D, hang), ("standing", up, U, stand)):
    bar = m.body(name, frame, q.m, at, q.m * q.l**2 / 12)
    m.pin(name, bar, m.ground, m.O)
    report_moments(name, at, m.O, q.m, q.m * q.l**2 / 12, turn)

# The person, from the vertical.
theta_A = m.coordinate("theta_A", "rad", "person from the vertical")
erect = m.frame("erect", theta_A)
G = m.point("G", m.O, erect, 0, q.h_G)
person = m.body("person", erect, q.m_B, G, q.m_B * q.h_G**2 / 3)
m.pin("ankle", person, m.ground, m.O)
m.torque("muscles", person, m.ground, q.T_A)
report_moments("person", G, m.O, q.m_B, q.m_B * q.h_G**2 / 3, theta_A)

# The rocking bar: the middle of its round end stays at the height of the radius and goes back as
# the bar turns.
theta = m.coordinate("theta", "rad", "rocking bar from the vertical")
leaning = m.frame("leaning", theta)
E = m.point("E", m.O, m.world, -q.R * theta, q.R)
S = m.point("S", E, leaning, 0, q.L / 2 - q.R)
contact = m.point("contact", E, m.world, 0, -q.R)
rocker = m.body("rocker", leaning, q.m, S, q.m * q.L**2 / 12)
m.pin("C", rocker, m.ground, contact)
report_moments("rocker", S, contact, q.m, q.m * q.L**2 / 12, theta)
SYSTEM = m.system()
