"""An aircraft in a vertical plane: two forces fixed to the body, weight, and drag on its
centroid.
"""

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2   | free fall                                     | 9.8
    m   | kg     | mass                                          | 4
    J   | kg m2  | inertia about the centroid                    | 0.0475
    r   | m      | first force below the centroid                | 0.25
    c   | N s/m  | drag                                          | 0.05
    F_1 | N      | first force, across the body                  | 3
    F_2 | N      | second force, up the body                     | 30
""")

m = Mechanism("pvtol", q, gravity=q.g)
x, y = (
    m.coordinate("x", "m", "place of the centroid, across"),
    m.coordinate("y", "m", "height of the centroid"),
)
theta = m.coordinate("theta", "rad", "roll, anticlockwise")
turned = m.frame("turned", theta)
C = m.point("C", m.O, m.world, x, y)
aircraft = m.body("aircraft", turned, q.m, C, q.J)
m.force("first", aircraft, m.point("N", C, turned, 0, -q.r), m.vector(turned, q.F_1))
m.force("second", aircraft, C, m.vector(turned, 0, q.F_2))
m.force("drag", aircraft, C, m.vector(m.world, -q.c * m.rate(x), -q.c * m.rate(y)))

# Linearised where the second force bears the weight.
states = (x, y, theta, m.rate(x), m.rate(y), m.rate(theta))
hovering = {**dict.fromkeys(states, 0), q.F_1: 0, q.F_2: q.m * q.g}
UNITS = (("1/s2", "1/s2", "m/s2", "1/s", "1/s", "m/s"),) * 2 + (
    ("1/m/s2", "1/m/s2", "1/s2", "1/m/s", "1/m/s", "1/s"),
)
for i, acceleration in enumerate(m.accelerations(), 4):
    for j, state in enumerate(states, 1):
        entry = acceleration.diff(state).subs(hovering)
        m.report(f"A_{i}{j}", UNITS[i - 4][j - 1], "entry of the state matrix", entry)

SYSTEM = m.system()
