"""A cart that carries two rods, one above the other, with friction; mass matrix and Coriolis terms
by energies.
"""

import sympy as sp

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall                                          | 9.81
    u   | N     | force on the cart                                  | 2
    M   | kg    | cart                                               | 1.0
    m_1 | kg    | lower rod                                          | 0.1
    m_2 | kg    | upper rod                                          | 0.1
    L_1 | m     | lower rod                                          | 0.5
    L_2 | m     | upper rod                                          | 0.5
    I_1 | kg m2 | lower rod about its centroid                       | 0.0083
    I_2 | kg m2 | upper rod about its centroid                       | 0.0083
    b_1 | N m s | friction of the lower rod                          | 0.01
    b_2 | N m s | friction of the upper rod                          | 0.01
    b_c | N s/m | friction of the cart                               | 0.1
""")

m = Mechanism("double_inverted_pendulum", q, gravity=q.g)
theta_1 = m.coordinate("theta_1", "rad", "lower rod from the vertical, clockwise")
theta_2 = m.coordinate("theta_2", "rad", "upper rod from the vertical, clockwise")
x = m.coordinate("x", "m", "place of the cart")
lower, upper = m.frame("lower", -theta_1), m.frame("upper", -theta_2)

P = m.point("P", m.O, m.world, x)
C1, E = m.point("C1", P, lower, 0, q.L_1 / 2), m.point("E", P, lower, 0, q.L_1)
C2 = m.point("C2", E, upper, 0, q.L_2 / 2)

cart = m.body("cart", m.world, q.M, P)
lower_rod = m.body("lower rod", lower, q.m_1, C1, q.I_1)
upper_rod = m.body("upper rod", upper, q.m_2, C2, q.I_2)
m.slide("track", cart, m.ground, P)
m.pin("P", lower_rod, cart, P)
m.pin("E", upper_rod, lower_rod, E)
m.force("push", cart, P, m.vector(m.world, q.u - q.b_c * m.rate(x)))
m.torque("friction 1", lower_rod, m.ground, q.b_1 * m.rate(theta_1))
m.torque("friction 2", upper_rod, m.ground, q.b_2 * m.rate(theta_2))
m.begin({theta_1: 0.3, theta_2: -0.5})

# The mass matrix is the second derivative of the kinetic energy, the Coriolis matrix that of
# Christoffel's symbols.
places = (theta_1, theta_2, x)
rates = tuple(m.rate(place) for place in places)
masses = ((q.M, P, 0, 0), (q.m_1, C1, q.I_1, rates[0]), (q.m_2, C2, q.I_2, rates[1]))
energy = sum(
    (mass * sum(v**2 for v in m.velocity(point).components) + inertia * spin**2) / 2
    for mass, point, inertia, spin in masses
)
height = sum(mass * q.g * m.position(point)[1] for mass, point, _, _ in masses)
mass_matrix = sp.Matrix(3, 3, lambda i, j: sp.simplify(sp.diff(energy, rates[i], rates[j])))
UNITS = (("kg m2", "kg m2", "kg m"), ("kg m2", "kg m2", "kg m"), ("kg m", "kg m", "kg"))


def coriolis_entry(i: int, j: int) -> sp.Expr:
    """Return the entry of the Coriolis matrix by Christoffel's symbols of the first kind."""
    return sum(
        (
            mass_matrix[i, j].diff(places[k])
            + mass_matrix[i, k].diff(places[j])
            - mass_matrix[j, k].diff(places[i])
        )
        * rates[k]
        / 2
        for k in range(3)
    )


for i in range(3):
    m.report(
        f"G_{i + 1}",
        "N" if i == 2 else "N m",
        "derivative of the potential energy",
        height.diff(places[i]),
    )
    for j in range(3):
        m.report(f"M_{i + 1}{j + 1}", UNITS[i][j], "entry of the mass matrix", mass_matrix[i, j])
        m.report(
            f"C_{i + 1}{j + 1}",
            f"{UNITS[i][j]}/s",
            "entry of the Coriolis matrix",
            coriolis_entry(i, j),
        )
m.report("V_0", "J", "potential energy upright", height.subs({theta_1: 0, theta_2: 0}))
for i in range(3):
    for j in range(3):
        upright = mass_matrix[i, j].subs({theta_1: 0, theta_2: 0})
        m.report(f"M0_{i + 1}{j + 1}", UNITS[i][j], "entry of the mass matrix, upright", upright)

SYSTEM = m.system()
