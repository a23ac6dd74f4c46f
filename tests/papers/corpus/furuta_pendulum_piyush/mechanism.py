"""A rotary pendulum: an arm that a motor turns about the vertical, and a thin rod that swings at
its end.
"""

from derive import Mechanism, X, quantities

q = quantities("""
    g   | m/s2  | free fall                                        | 9.81
    tau | N m   | torque of the motor                              | 0.02
    J_1 | kg m2 | arm about the axis of the motor                  | 0.0007
    J_p | kg m2 | swinging rod about its centroid, across it       | 1e-5
    m_p | kg    | swinging rod                                     | 0.012
    L_r | m     | arm                                              | 0.19
    l_p | m     | centroid of the rod from its hinge               | 0.088
""")

m = Mechanism("furuta_pendulum", q, gravity=(0, 0, -q.g), spatial=True)
theta = m.coordinate("theta", "rad", "angle of the arm")
alpha = m.coordinate("alpha", "rad", "rod from the vertical upwards, towards the motion of the arm")
arm = m.frame("arm", theta)
rod = m.frame("rod", -alpha, X, arm)
H = m.point("H", m.O, arm, q.L_r)
P = m.point("P", H, rod, z=q.l_p)

turning = m.body("arm", arm, 0, m.O, (0, 0, q.J_1))
swinging = m.body("rod", rod, q.m_p, P, (q.J_p, q.J_p, 0))
m.pin("O", turning, m.ground, m.O)
m.pin("H", swinging, turning, H, X, arm)
m.torque("motor", turning, m.ground, q.tau)
m.begin({alpha: 0.3})

turns = m.motion.spin(rod).resolved(rod)
m.report("T_rot", "J", "rotational energy of the rod", q.J_p * (turns[0] ** 2 + turns[1] ** 2) / 2)

# Linearised about the upright rod at rest without torque.
states = (theta, alpha, m.rate(theta), m.rate(alpha), q.tau)
upright = dict.fromkeys(states, 0)
for name, acceleration in zip(("theta", "alpha"), m.accelerations(), strict=True):
    linear = sum(acceleration.diff(state).subs(upright) * state for state in states)
    m.report(f"{name}_ddot_near", "rad/s2", "angular acceleration, linearised", linear)

SYSTEM = m.system()
