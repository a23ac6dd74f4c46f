"""The lift of a mounted planter: a hydraulic cylinder raises a loaded arm and lowers it, by a law of time.

phi is the phase of a cycle of raising and lowering; the cylinder's length is l_0 + h (1 - cos phi) / 2.
"""

from sympy import cos, sqrt

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | phase of the cycle
    omega | r/min | cycles                            | 6
    g     | m/s2  | free fall                         | 9.81
    x_c   | mm    | cylinder's foot, before the pin   | 120   | 100 160
    y_c   | mm    | cylinder's foot, below the pin    | 450   | 400 500
    c     | mm    | cylinder on the arm, from the pin | 300   | 250 340
    l_0   | mm    | cylinder, retracted               | 520   | 510 540
    h     | mm    | stroke                            | 160   | 120 180
    l     | mm    | load on the arm, from the pin     | 800
    m_l   | kg    | load                              | 180
    J     | kg m2 | load                              | 12
""")

m = Mechanism(
    "lift_arm", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
theta = m.coordinate("theta", "rad", "arm")
arm = m.frame("arm", theta)
foot, eye = m.point("foot", m.O, m.world, q.x_c, -q.y_c), m.point("eye", m.O, arm, q.c)
x, y = (a - b for a, b in zip(m.position(eye)[:2], m.position(foot)[:2], strict=True))
m.constrain("cylinder", sqrt(x**2 + y**2) - q.l_0 - q.h * (1 - cos(q.phi)) / 2, start={theta: 0.1})

boom = m.body("boom", arm, q.m_l, m.point("load", m.O, arm, q.l), q.J)
m.pin("O", boom, m.ground, m.O)
m.actuator("F_cylinder", boom, m.ground, (eye, foot))
SYSTEM = m.system()
