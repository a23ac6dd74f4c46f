"""The plunger of a hay baler: an offset slider-crank that presses a charge of hay on its way forward.

The hay resists from where the plunger meets it, by the cube of how far it is pressed, and does not spring back.
"""

from sympy import Ge, Piecewise, sin

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed, strokes a minute             | 90
    g     | m/s2  | free fall, across the chamber             | 9.81
    r     | mm    | crank                                     | 360  | 300 400
    l     | mm    | rod                                       | 1000 | 900 1200
    e     | mm    | offset of the chamber                     | -60  | -100 100
    m_r   | kg    | rod                                       | 32
    c     | mm    | centroid of the rod, from the crank pin   | 420
    J_r   | kg m2 | rod, about its centroid                   | 3.1
    m_p   | kg    | plunger                                   | 120
    s_0   | mm    | place of the plunger where it meets hay   | 1000
    h     | mm    | length over which the hay is pressed      | 350
    F_h   | N     | force of the hay, pressed by this length  | 60000
""")

m = Mechanism(
    "hay_baler", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
beta, s = m.coordinate("beta", "rad", "rod"), m.coordinate("s", "m", "place of the plunger")
crank, rod = m.frame("crank", q.phi), m.frame("rod", beta)
A, P = m.point("A", m.O, crank, q.r), m.point("P", m.O, m.world, s, q.e)
B, C = m.point("B", A, rod, q.l), m.point("C", A, rod, q.c)
m.close(B, P, start={beta: 0, s: q.r + q.l})

wheel, link = m.body("crank", crank), m.body("rod", rod, q.m_r, C, q.J_r)
plunger = m.body("plunger", m.world, q.m_p, P)
m.pin("O", wheel, m.ground, m.O)
m.pin("A", link, wheel, A)
m.pin("P", plunger, link, P)
m.slide("chamber", plunger, m.ground, P)
pressed = Piecewise((q.F_h * ((s - q.s_0) / q.h) ** 3, Ge(s, q.s_0)), (0, True))
hay = m.report(
    "F_hay", "N", "force of the hay", Piecewise((pressed, Ge(sin(beta - q.phi), 0)), (0, True))
)
m.force("hay", plunger, P, m.vector(m.world, -hay))
m.motor("M_in", wheel, m.ground, m.O)
SYSTEM = m.system()
