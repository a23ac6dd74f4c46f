"""Two gears with play between their teeth, driven by an unsteady torque: the teeth part, and touch on either flank."""

from sympy import Abs, Piecewise, cos, sin

from derive import Mechanism, quantities

q = quantities("""
    r_1 | m     | pitch radius of the pinion    | 0.03
    r_2 | m     | pitch radius of the wheel     | 0.06
    m_1 | kg    | pinion                        | 0.6
    m_2 | kg    | wheel                         | 1.5
    J_1 | kg m2 | pinion                        | 4e-4
    J_2 | kg m2 | wheel                         | 3e-3
    a   | rad   | pressure angle                | 0.35
    b   | m     | half the play, along the line of action | 5e-5
    K   | N/m   | stiffness of the teeth        | 2e6
    T   | N m   | mean torque of the drive      | 2
    U   | N m   | amplitude of the torque       | 8
    w   | rad/s | its frequency                 | 120
    D   | N m s | drag of the wheel             | 0.02
""")
m = Mechanism("gear_rattle", q)
a_1, a_2 = (
    m.coordinate("a_1", "rad", "angle of the pinion"),
    m.coordinate("a_2", "rad", "angle of the wheel"),
)
P, M = m.point("P", m.O, m.world, q.r_1), m.point("M", m.O, m.world, q.r_1 + q.r_2)
pinion = m.body("pinion", m.frame("pinion", a_1), q.m_1, m.O, q.J_1)
wheel = m.body("wheel", m.frame("wheel", a_2), q.m_2, M, q.J_2)
m.pin("O", pinion, m.ground, m.O)
m.pin("M", wheel, m.ground, M)

ahead = m.name_(
    "ahead",
    "m",
    "lead of the pinion, along the line of action",
    (q.r_1 * a_1 + q.r_2 * a_2) * cos(q.a),
)
push = m.name_(
    "F_teeth",
    "N",
    "force of the teeth, positive where the pinion drives",
    q.K
    * Piecewise(
        (ahead - q.b, ahead > q.b),
        (ahead + q.b, ahead < -q.b),
        (0, True),
    ),
)
m.force("teeth", pinion, P, m.vector(m.world, -Abs(push) * sin(q.a), -push * cos(q.a)), wheel)
m.torque("drive", pinion, m.ground, q.T + q.U * sin(q.w * m.time))
m.torque("drag", wheel, m.ground, -q.D * m.rate(a_2))
SYSTEM = m.system()
