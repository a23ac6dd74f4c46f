"""A spatial four-bar (RSSR): a crank about z and a rocker about x, joined by a light rod with a ball at either end.

The rod pulls or pushes along its length alone; how it spins about itself nothing decides, so that it is no body here.
"""

from sympy import sqrt

from derive import Mechanism, X, Z, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                     | 120
    r     | mm    | crank                           | 40   | 20 50
    c     | mm    | rocker                          | 110  | 90 130
    l     | mm    | rod                             | 210  | 190 230
    x_D   | mm    | shaft of the rocker, x          | 60
    y_D   | mm    | shaft of the rocker, y          | 170
    z_D   | mm    | shaft of the rocker, z          | -30
    J     | kg m2 | rocker, about its shaft         | 0.006
    m_c   | kg    | rocker, balanced                | 0.9
    T     | N m   | torque against the rocker       | 6
""")

m = Mechanism(
    "rssr", q, angle=q.phi, speed=q.omega, spatial=True, source="the example of the guide"
)
psi = m.coordinate("psi", "rad", "rocker")
crank, rocker = m.frame("crank", q.phi, Z), m.frame("rocker", psi, X)
A, D = m.point("A", m.O, crank, q.r), m.point("D", m.O, m.world, q.x_D, q.y_D, q.z_D)
B = m.point("B", D, rocker, 0, 0, q.c)
rod = tuple(b - a for a, b in zip(m.position(A), m.position(B), strict=True))
length = sqrt(sum(component**2 for component in rod))
m.constrain("rod", length - q.l, start={psi: 0})

arm, lever = m.body("crank", crank), m.body("rocker", rocker, q.m_c, D, (q.J, 0, 0))
m.pin("O", arm, m.ground, m.O, Z)
m.pin("D", lever, m.ground, D, X)
m.contact("rod", lever, arm, B, m.vector(m.world, *(component / q.l for component in rod)))
m.torque("work", lever, m.ground, -q.T, X)
m.motor("M_in", arm, m.ground, m.O, Z)
SYSTEM = m.system()
