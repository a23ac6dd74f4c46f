"""A four-bar whose coupler point shall follow the points of coupler_path.csv: lengths and shafts are to be found.

The points are of another four-bar, so that the path can be met; the values here are a first guess.
"""

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                      | 60
    a     | mm    | crank                            | 44   | 30 60
    b     | mm    | coupler                          | 108  | 90 140
    c     | mm    | rocker                           | 112  | 90 140
    x_D   | mm    | shaft of the rocker, x           | 130  | 100 160
    y_D   | mm    | shaft of the rocker, y           | 12   | -30 30
    u     | mm    | point P, along the coupler       | 70   | 40 100
    v     | mm    | point P, beside the coupler      | 42   | 20 80
    m_b   | kg    | coupler, centroid at P           | 0.6
    J_b   | kg m2 | coupler                          | 0.001
    g     | m/s2  | free fall                        | 9.81
""")

m = Mechanism(
    "coupler_path", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
beta, gamma = m.coordinate("beta", "rad", "coupler"), m.coordinate("gamma", "rad", "rocker")
crank, coupler, rocker = m.frame("crank", q.phi), m.frame("coupler", beta), m.frame("rocker", gamma)
A, D = m.point("A", m.O, crank, q.a), m.point("D", m.O, m.world, q.x_D, q.y_D)
B, C, P = (
    m.point("B", A, coupler, q.b),
    m.point("C", D, rocker, q.c),
    m.point("P", A, coupler, q.u, q.v),
)
m.close(B, C, start={beta: 0.9, gamma: 1.6})

arm, rod, lever = (
    m.body("crank", crank),
    m.body("coupler", coupler, q.m_b, P, q.J_b),
    m.body("rocker", rocker),
)
m.pin("O", arm, m.ground, m.O)
m.pin("A", rod, arm, A)
m.pin("B", lever, rod, B)
m.pin("D", lever, m.ground, D)
m.motor("M_in", arm, m.ground, m.O)

x_P = m.report("x_P", "m", "coupler point, x", m.position(P)[0])
y_P = m.report("y_P", "m", "coupler point, y", m.position(P)[1])
SYSTEM = m.system()
