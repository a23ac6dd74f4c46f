"""A heavy top on a ball joint: it may pass any pose, since a unit quaternion describes its attitude.

planter derive docs/examples/spinning_top.py && planter simulate spinning_top.toml --until 2
"""

from derive import Mechanism, X, quantities

q = quantities("""
    g     | m/s2  | free fall                          | 9.81
    m     | kg    | mass of the top                    | 0.5
    l     | m     | centroid from the ball joint       | 0.06
    A     | kg m2 | inertia about the centroid, across | 4e-4
    B     | kg m2 | inertia about the centroid, across | 4e-4
    C     | kg m2 | inertia about the axis             | 6e-4
    theta | deg   | lean at the start                  | 90
    spin  | rad/s | spin about the axis at the start   | 120
""")
m = Mechanism("spinning_top", q, gravity=(0, 0, -q.g), spatial=True)
turned = m.free_frame("top", start=[(X, q.theta)], spin=(0, 0, q.spin))
centroid = m.point("C", m.O, turned, z=q.l)
top = m.body("top", turned, q.m, centroid, (q.A, q.B, q.C))
m.ball("J", top, m.ground, m.O)
m.report("height", "m", "height of the centroid", m.position(centroid)[2])

SYSTEM = m.system()
