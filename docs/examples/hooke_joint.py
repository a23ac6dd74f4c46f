"""A Hooke (Cardan) joint between two shafts at an angle: the driven shaft turns unevenly, twice a turn.

The cross joins y of the driving shaft and z of the driven one, which stay perpendicular therefore. The driven shaft
ends in a self-aligning bearing that takes its thrust.
"""

from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    phi   | rad   | driving shaft
    omega | r/min | its speed                      | 540
    beta  | deg   | angle between the shafts       | 30   | 0 45
    a     | mm    | length that scales the closure | 50
    l     | mm    | bearing of the driven shaft    | 400
    J     | kg m2 | driven shaft, about its axis   | 0.05
    m_2   | kg    | driven shaft                   | 6
    T     | N m   | torque that it drives          | 100
""")

m = Mechanism(
    "hooke_joint", q, angle=q.phi, speed=q.omega, spatial=True, source="the example of the guide"
)
psi = m.coordinate("psi", "rad", "driven shaft")
driving, housing = m.frame("driving shaft", q.phi, X), m.frame("housing", q.beta, Z)
driven = m.frame("driven shaft", psi, X, housing)
perpendicular = (
    m.vector(driving, y=1).resolved(m.world).dot(m.vector(driven, z=1).resolved(m.world))
)
m.constrain("cross", q.a * perpendicular, start={psi: 0})

first = m.body("driving shaft", driving)
second = m.body("driven shaft", driven, q.m_2, m.point("C", m.O, housing, q.l / 2), (q.J, 0, 0))
bearing = m.body("bearing", housing)
m.weld("bearing", bearing, m.ground, m.O)
m.cylinder("A", first, m.ground, m.O, X)
m.universal("cross", second, first, m.O, Y, Z)
m.ball("E", second, m.ground, m.point("E", m.O, housing, q.l))
m.torque("work", second, bearing, -q.T, X)
m.motor("M_in", first, m.ground, m.O, X)
SYSTEM = m.system()
