"""A plate cam lifts a slide by a roller: harmonic lift, a return spring, friction in the guide.

The cam pushes along the normal of its pitch curve, which runs from the pole of cam and slide (Q, ds/dphi beside the
axis) to the roller's centre P. N_cam below zero would be a pull: there the roller lifts off.
"""

from sympy import cos, sqrt

from derive import Mechanism, Y, quantities

q = quantities("""
    phi   | rad   | cam angle
    omega | r/min | cam speed                       | 240
    g     | m/s2  | free fall, against the lift     | 9.81
    y_0   | mm    | roller's centre at the lowest   | 38     | 30 60
    h     | mm    | lift                            | 14     | 8 20
    m_s   | kg    | slide with the roller           | 0.65
    k     | N/m   | spring                          | 1800   | 0 6000
    F_0   | N     | spring at the lowest            | 22     | 5 60
    mu    | 1     | friction of the guide           | 0.12
""")

m = Mechanism("cam_follower", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide")
s = m.coordinate("s", "m", "lift", equals=q.h * (1 - cos(q.phi)) / 2)
beside = m.report("beside", "m", "pole of cam and slide, beside the axis", m.rate(s) / q.omega)
long = m.report("long", "m", "normal of the pitch curve, from the pole", sqrt(beside**2 + (q.y_0 + s) ** 2))
P = m.point("P", m.O, m.world, 0, q.y_0 + s)

cam = m.body("cam", m.frame("cam", q.phi))
slide = m.body("slide", m.world, mass=q.m_s, centroid=P)
m.pin("O", cam, m.ground, m.O)
m.contact("cam", slide, cam, P, m.vector(m.world, -beside / long, (q.y_0 + s) / long))
m.slide("guide", slide, m.ground, P, along=Y, friction=q.mu)
spring = m.report("F_spring", "N", "push of the spring", q.F_0 + q.k * s)
m.force("spring", slide, P, m.vector(m.world, 0, -spring))
m.motor("M_in", cam, m.ground, m.O)

SYSTEM = m.system()
