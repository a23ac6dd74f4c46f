"""A flat belt between two pulleys of unequal size: elastic spans under preload, which go slack instead of pushing.

The upper span is stretched where the first pulley turns counter-clockwise ahead of the second; the lower one slackens.
"""

from sympy import Max, sqrt

from derive import Mechanism, quantities

q = quantities("""
    r_1   | mm    | first pulley                    | 60    | 40 80
    r_2   | mm    | second pulley                   | 120   | 80 160
    d     | mm    | distance of the shafts          | 400   | 300 500
    J_1   | kg m2 | first pulley and motor          | 0.01
    J_2   | kg m2 | second pulley and load          | 0.2
    m_1   | kg    | first pulley                    | 1.2
    m_2   | kg    | second pulley                   | 4
    k     | N/m   | stiffness of a span             | 50000
    c     | N s/m | damping of a span               | 20
    T_0   | N     | preload of a span               | 300
    M     | N m   | torque of the motor             | 5
""")

m = Mechanism("belt_drive", q, source="the example of the guide")
a_1 = m.coordinate("a_1", "rad", "first pulley")
a_2 = m.coordinate("a_2", "rad", "second pulley")
shaft = m.point("shaft", m.O, m.world, q.d)
first = m.body("first", m.frame("first", a_1), q.m_1, m.O, q.J_1)
second = m.body("second", m.frame("second", a_2), q.m_2, shaft, q.J_2)
m.pin("O", first, m.ground, m.O)
m.pin("S", second, m.ground, shaft)
m.torque("M", first, m.ground, q.M)

stretch = q.r_1 * a_1 - q.r_2 * a_2
pull = q.k * stretch + q.c * m.rate(stretch)
lean = (q.r_1 - q.r_2) / q.d
rise = sqrt(1 - lean**2)
for side, name, sign in (("u", "upper", 1), ("l", "lower", -1)):
    tension = m.name_(f"T_{side}", "N", f"tension of the {name} span", Max(q.T_0 + sign * pull, 0))
    span_force = m.vector(m.world, tension * rise, -sign * tension * lean)
    ends = [
        m.point(f"{side}_{i}", base, m.world, radius * lean, sign * radius * rise)
        for i, base, radius in ((1, m.O, q.r_1), (2, shaft, q.r_2))
    ]
    m.force(f"{name}_1", first, ends[0], span_force)
    m.force(f"{name}_2", second, ends[1], -span_force)
SYSTEM = m.system()
