"""Two masses on springs, one without friction, the other with a damper, each on a track of its own.

The Lagrangian and the Hamiltonian of the second grow in time, so that the friction follows from
them.
"""

from sympy import exp

from derive import Mechanism, quantities

q = quantities("""
    m     | kg   | masses           | 0.7
    k     | N/m  | springs          | 30
    gamma | kg/s | friction         | 0.4
""")

m = Mechanism("oscillator", q)
x, y = m.coordinate("x", "m", "mass without friction"), m.coordinate("y", "m", "mass with friction")
A, B = m.point("A", m.O, m.world, x), m.point("B", m.O, m.world, y)
free, damped = m.body("free", m.world, q.m, A), m.body("damped", m.world, q.m, B)
m.slide("upper", free, m.ground, A)
m.slide("lower", damped, m.ground, B)
pull = m.report("pull", "N", "force on the mass without friction", -q.k * x)
m.force("upper", free, A, m.vector(m.world, pull))
m.force("lower", damped, B, m.vector(m.world, -q.k * y - q.gamma * m.rate(y)))

m.report("E_k", "N m", "kinetic energy of the first", q.m * m.rate(x) ** 2 / 2)
m.report("E_p", "N m", "energy of its spring", q.k * x**2 / 2)
growth = exp(q.gamma * m.time / q.m)
kinetic, elastic = q.m * m.rate(y) ** 2 / 2, q.k * y**2 / 2
m.report("L_damped", "N m", "Lagrangian of the second", growth * (kinetic - elastic))
momentum = m.report(
    "p_damped", "kg m/s", "its momentum by that", (growth * (kinetic - elastic)).diff(m.rate(y))
)
m.report("H_damped", "N m", "its Hamiltonian", momentum * m.rate(y) - growth * (kinetic - elastic))
m.report("E_kdamped", "N m", "kinetic energy of the second", kinetic)
m.report("E_pdamped", "N m", "energy of its spring", elastic)
SYSTEM = m.system()
