"""A rigid body in the plane, by the place of a reference point that is not its centroid, and by its
angle.
"""

from sympy import cos, sin

from derive import Mechanism, quantities

q = quantities("""
    m     | kg    | mass                                                  | 2
    J     | kg m2 | inertia about the reference point                     | 1.5
    c_x   | m     | centroid from the reference point, along the body     | 0.3
    c_y   | m     | centroid from the reference point, across the body    | 0.2
    b_0   | m     | point where a force acts, along the body              | 0.4
    b_1   | m     | point where a force acts, across the body             | -0.5
    f_0   | N     | force along x                                         | 3
    f_1   | N     | force along y                                         | -2
    tau_2 | N m   | torque                                                | 0.7
""")

m = Mechanism("rigid_body", q)
q_0, q_1 = (
    m.coordinate("q_0", "m", "reference point, x"),
    m.coordinate("q_1", "m", "reference point, y"),
)
psi_0 = m.coordinate("psi_0", "rad", "angle of the body")
turned = m.frame("turned", psi_0)
P = m.point("P", m.O, m.world, q_0, q_1)
C = m.point("C", P, turned, q.c_x, q.c_y)
F = m.point("F", P, turned, q.b_0, q.b_1)
body = m.body("body", turned, q.m, C, q.J - q.m * (q.c_x**2 + q.c_y**2))
m.force("load", body, P, m.vector(m.world, q.f_0, q.f_1))
m.torque("load", body, m.ground, q.tau_2)

b_x = m.report(
    "b_x", "m", "centroid from the reference point, x", q.c_x * cos(psi_0) - q.c_y * sin(psi_0)
)
b_y = m.report(
    "b_y", "m", "centroid from the reference point, y", q.c_x * sin(psi_0) + q.c_y * cos(psi_0)
)

# The mass matrix is the second derivative of the kinetic energy, the Jacobian the derivative of the
# point's place.
places = (q_0, q_1, psi_0)
rates = tuple(map(m.rate, places))
energy = q.m * sum(v**2 for v in m.velocity(C).components) / 2
energy += (q.J - q.m * (q.c_x**2 + q.c_y**2)) * rates[2] ** 2 / 2
m.report("G_x", "kg m", "entry of the mass matrix, x and angle", energy.diff(rates[0], rates[2]))
m.report("G_y", "kg m", "entry of the mass matrix, y and angle", energy.diff(rates[1], rates[2]))
m.report(
    "P_x", "m", "derivative of the point's place by the angle, x", m.position(F)[0].diff(psi_0)
)
m.report(
    "P_y", "m", "derivative of the point's place by the angle, y", m.position(F)[1].diff(psi_0)
)

SYSTEM = m.system()
