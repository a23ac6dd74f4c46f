"""A plate cam lifts a slide by a roller: harmonic lift, a return spring, friction in the guide.

The cam pushes along the normal of the path that the roller's centre P takes on it. N_cam below zero would be a pull:
there the roller lifts off.
"""

from sympy import cos

from derive import Mechanism, Y, quantities

q = quantities("""
    phi   | rad   | cam angle
    omega | r/min | cam speed                       | 240
    eps   | rad/s2 | acceleration of the cam        | 0
    g     | m/s2  | free fall, against the lift     | 9.81
    y_0   | mm    | roller's centre at the lowest   | 38     | 30 60
    h     | mm    | lift                            | 14     | 8 20
    m_s   | kg    | slide with the roller           | 0.65
    k     | N/m   | spring                          | 1800   | 0 6000
    F_0   | N     | spring at the lowest            | 22     | 5 60
    mu    | 1     | friction of the guide           | 0.12
""")

m = Mechanism(
    "cam_follower",
    q,
    angle=q.phi,
    speed=q.omega,
    acceleration=q.eps,
    gravity=q.g,
    source="the example of the guide",
)
s = m.coordinate("s", "m", "lift", equals=q.h * (1 - cos(q.phi)) / 2)
P = m.point("P", m.O, m.world, 0, q.y_0 + s)

cam = m.body("cam", m.frame("cam", q.phi))
slide = m.body("slide", m.world, mass=q.m_s, centroid=P)
m.pin("O", cam, m.ground, m.O)
m.follower("N_cam", slide, cam, P, m.O, across=m.vector(m.world, z=-1))
m.slide("guide", slide, m.ground, P, along=Y, friction=q.mu)
spring = m.report("F_spring", "N", "push of the spring", q.F_0 + q.k * s)
m.force("spring", slide, P, m.vector(m.world, 0, -spring))
m.motor("M_in", cam, m.ground, m.O)

SYSTEM = m.system()
