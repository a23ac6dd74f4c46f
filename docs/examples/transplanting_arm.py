"""A four-bar that moves a transplanting arm: the coupler carries the arm with its tip, a spring returns the rocker."""

from sympy import Rational

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                          | 90
    eps   | rad/s2 | acceleration of the crank           | 0
    g     | m/s2  | free fall                            | 9.81
    a     | mm    | crank                                | 45     | 35 60
    b     | mm    | coupler                              | 130    | 110 160
    c     | mm    | rocker                               | 105    | 80 130
    d     | mm    | frame                                | 150    | 130 180
    p     | mm    | tip of the arm, along the coupler    | 240    | 200 280
    n     | mm    | tip of the arm, across the coupler   | -90    | -140 -40
    m_a   | kg    | crank with its shaft                 | 0.35
    J_a   | kg m2 | crank, about its centroid            | 0.0002
    m_b   | kg    | coupler with the arm                 | 0.82
    s_b   | mm    | its centroid, along                  | 110
    t_b   | mm    | its centroid, across                 | -30
    J_b   | kg m2 | coupler with the arm, centroidal     | 0.0052
    m_c   | kg    | rocker                               | 0.31
    J_c   | kg m2 | rocker, about its centroid           | 0.00035
    k     | N/m   | return spring                        | 650    | 0 2000
    l_0   | mm    | its length without load              | 70
    x_k   | mm    | its anchor in the frame, along       | 260
    y_k   | mm    | its anchor in the frame, across      | 40
""")

m = Mechanism(
    "transplanting_arm",
    q,
    angle=q.phi,
    speed=q.omega,
    acceleration=q.eps,
    gravity=q.g,
    source="the example of the guide",
)
beta = m.coordinate("beta", "rad", "angle of the coupler")
gamma = m.coordinate("gamma", "rad", "angle of the rocker")
crank, coupler, rocker = m.frame("crank", q.phi), m.frame("coupler", beta), m.frame("rocker", gamma)
A, D = m.point("A", m.O, crank, q.a), m.point("D", m.O, m.world, q.d)
B, end = m.point("B", A, coupler, q.b), m.point("end", D, rocker, q.c)
tip = m.point("tip", A, coupler, q.p, q.n)
m.close(B, end, start={beta: Rational(7, 10), gamma: Rational(8, 5)})

one = m.body("crank", crank, q.m_a, m.point("C1", m.O, crank, q.a / 2), q.J_a)
two = m.body("coupler", coupler, q.m_b, m.point("C2", A, coupler, q.s_b, q.t_b), q.J_b)
three = m.body("rocker", rocker, q.m_c, m.point("C3", D, rocker, q.c / 2), q.J_c)
m.pin("O", one, m.ground, m.O)
m.pin("A", two, one, A)
m.pin("B", three, two, end)
m.pin("D", three, m.ground, D)
m.spring(
    "return", three, m.ground, (end, m.point("anchor", m.O, m.world, q.x_k, q.y_k)), q.k, q.l_0
)
m.motor("M_in", one, m.ground, m.O)

m.report("x_tip", "m", "tip of the arm, x", m.position(tip)[0])
m.report("y_tip", "m", "tip of the arm, y", m.position(tip)[1])
SYSTEM = m.system()
