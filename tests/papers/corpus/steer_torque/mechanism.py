"""A bicycle's rear frame in any motion, and its handlebar, which turns about the steering axis
under torques.
"""

from derive import Mechanism, Vec, X, Y, Z, quantities

q = quantities("""
    d     | m     | steering axis to centroid of the handlebar    | 0.05
    d_s1  | m     | accelerometer to steering axis, across        | 0.4
    d_s3  | m     | accelerometer to steering axis, along         | -0.3
    m_G   | kg    | handlebar                                     | 3
    I_G11 | kg m2 | handlebar, across the steering axis           | 0.05
    I_G22 | kg m2 | handlebar, across its plane                   | 0.03
    I_G33 | kg m2 | handlebar, along the steering axis            | 0.04
    I_G31 | kg m2 | handlebar, product                            | 0.004
    T_U   | N m   | friction of the upper bearing                 | 0.3
    T_M   | N m   | measured torque                               | 2
    r_R   | m     | radius of the rear wheel                      | 0.34
    I_HF  | kg m2 | fork and handlebar about the steering axis    | 0.2
""")

m = Mechanism("steer_torque", q, spatial=True)
x, y, z = (m.coordinate(name, "m", f"accelerometer, {name}") for name in "xyz")
q3, q4, q5 = (
    m.coordinate(f"q_{i}", "rad", name) for i, name in ((3, "yaw"), (4, "roll"), (5, "pitch"))
)
q6, delta = (
    m.coordinate("q_6", "rad", "rear wheel against the frame"),
    m.coordinate("delta", "rad", "steer"),
)

B = m.frame("B", q5, Y, m.frame("roll", q4, X, m.frame("yaw", q3)))
G = m.frame("G", delta, Z, B)
v = m.point("v", m.O, m.world, x, y, z)
s = m.point("s", v, B, q.d_s1, 0, q.d_s3)
g_o = m.point("g_o", s, G, q.d)

spin_1, spin_2, spin_3 = m.motion.spin(G).components
momentum = Vec(
    G, (q.I_G11 * spin_1 + q.I_G31 * spin_3, q.I_G22 * spin_2, q.I_G31 * spin_1 + q.I_G33 * spin_3)
)
inertia_force = q.m_G * m.motion.acceleration(g_o, G)
moment = m.motion.derivative(momentum) + m.vector(G, q.d).cross(inertia_force)
for i, component in enumerate(m.motion.acceleration(v, B).components):
    m.name_(
        f"a_v{i + 1}", "m/s2", "acceleration of the accelerometer along the rear frame", component
    )
m.name_("T_delta", "N m", "torque of the rider on the handlebar", moment[2] + q.T_U + q.T_M)
