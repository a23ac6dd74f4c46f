"""A double pendulum with geared motors at both joints, whose rotors have inertia, and with
friction.

The second motor sits on the first link; its rotor turns against the second link.
"""

from sympy import atan

from derive import Mechanism, quantities

q = quantities("""
    g    | m/s2  | free fall                                       | 9.81
    m_1  | kg    | first link                                      | 0.6
    m_2  | kg    | second link                                     | 0.6
    l_1  | m     | first link                                      | 0.3
    r_1  | m     | centroid of the first link                      | 0.275
    r_2  | m     | centroid of the second link                     | 0.166
    I_1  | kg m2 | first link about the shoulder                   | 0.053
    I_2  | kg m2 | second link about the elbow                     | 0.024
    I_r  | kg m2 | rotor of a motor                                | 0.0001
    g_r  | 1     | gear ratio                                      | 6
    b_1  | N m s | viscous friction of the shoulder                | 0.01
    b_2  | N m s | viscous friction of the elbow                   | 0.02
    c_f1 | N m   | Coulomb's friction of the shoulder, by 2/pi     | 0.08
    c_f2 | N m   | Coulomb's friction of the elbow, by 2/pi        | 0.06
    k    | s     | sharpness of Coulomb's friction                 | 100
    u_1  | N m   | torque at the shoulder                          | 0.3
    u_2  | N m   | torque at the elbow                             | -0.2
""")

m = Mechanism("double_pendulum", q, gravity=q.g)
q_1 = m.coordinate("q_1", "rad", "first link from hanging")
q_2 = m.coordinate("q_2", "rad", "second link from the first one")
first = m.frame("first", q_1)
second = m.frame("second", q_2, parent=first)
rotor_1, rotor_2 = m.frame("rotor_1", q.g_r * q_1), m.frame("rotor_2", q_1 - q.g_r * q_2)
C1, E = m.point("C1", m.O, first, 0, -q.r_1), m.point("E", m.O, first, 0, -q.l_1)
C2 = m.point("C2", E, second, 0, -q.r_2)

upper = m.body("upper", first, q.m_1, C1, q.I_1 - q.m_1 * q.r_1**2)
lower = m.body("lower", second, q.m_2, C2, q.I_2 - q.m_2 * q.r_2**2)
shoulder_rotor = m.body("shoulder rotor", rotor_1, 0, m.O, q.I_r)
elbow_rotor = m.body("elbow rotor", rotor_2, 0, E, q.I_r)
m.pin("O", upper, m.ground, m.O)
m.pin("E", lower, upper, E)
m.pin("S", shoulder_rotor, m.ground, m.O)
m.pin("R", elbow_rotor, upper, E)
m.torque("gear 1", upper, m.ground, -q.g_r * m.motor("tau_1", shoulder_rotor, m.ground, m.O))
m.torque("gear 2", lower, upper, q.g_r * m.motor("tau_2", elbow_rotor, upper, E))
for number, (on, by, rate) in enumerate(
    ((upper, m.ground, m.rate(q_1)), (lower, upper, m.rate(q_2))), 1
):
    friction = q[f"b_{number}"] * rate + q[f"c_f{number}"] * atan(q.k * rate)
    m.torque(f"drive {number}", on, by, q[f"u_{number}"] - friction)
m.begin({q_1: 1.0, q_2: 0.5})

# The mass matrix is the second derivative of the kinetic energy, the gravity vector that of the
# work of weight.
rates = (m.rate(q_1), m.rate(q_2))
spins = (rates[0], rates[0] + rates[1], q.g_r * rates[0], rates[0] - q.g_r * rates[1])
inertias = (q.I_1 - q.m_1 * q.r_1**2, q.I_2 - q.m_2 * q.r_2**2, q.I_r, q.I_r)
energy = sum(inertia * spin**2 / 2 for inertia, spin in zip(inertias, spins, strict=True))
for mass, centroid in ((q.m_1, C1), (q.m_2, C2)):
    energy += mass * sum(v**2 for v in m.velocity(centroid).components) / 2
work = -sum(mass * q.g * m.position(centroid)[1] for mass, centroid in ((q.m_1, C1), (q.m_2, C2)))
for i in range(2):
    m.report(f"G_{i + 1}", "N m", "moment of weight", work.diff((q_1, q_2)[i]))
    for j in range(2):
        m.report(
            f"M_{i + 1}{j + 1}",
            "kg m2",
            "entry of the mass matrix",
            energy.diff(rates[i], rates[j]),
        )

SYSTEM = m.system()
