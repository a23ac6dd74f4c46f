"""A plate cam whose lift is a table of a CSV file; it pushes a slide by a roller, against a spring."""

from pathlib import Path

from derive import Mechanism, Y, quantities, read_table

lift = read_table(
    Path(__file__).with_name("tabulated_cam.csv"),
    "phi | deg | cam angle\nlift | mm | lift of the roller",
    periodic=True,
)
q = quantities("""
    phi   | rad   | cam angle
    omega | r/min | cam speed                     | 240
    g     | m/s2  | free fall, against the lift   | 9.81
    y_0   | mm    | roller's centre at the lowest | 38   | 30 60
    m_s   | kg    | slide with the roller         | 0.65
    k     | N/m   | spring                        | 1800
    F_0   | N     | spring at the lowest          | 22   | 5 60
""")

m = Mechanism(
    "tabulated_cam", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
s = m.coordinate("s", "m", "lift", equals=lift(q.phi))
P = m.point("P", m.O, m.world, 0, q.y_0 + s)

cam = m.body("cam", m.frame("cam", q.phi))
slide = m.body("slide", m.world, mass=q.m_s, centroid=P)
m.pin("O", cam, m.ground, m.O)
m.follower("N_cam", slide, cam, P, m.O, across=m.vector(m.world, z=-1))
m.slide("guide", slide, m.ground, P, along=Y)
m.force("spring", slide, P, m.vector(m.world, 0, -q.F_0 - q.k * s))
m.motor("M_in", cam, m.ground, m.O)
SYSTEM = m.system()
