"""An arm on a damped bearing with a motor; a long spring pulls a point of it with a force that
hardly changes.
"""

from derive import Mechanism, quantities

q = quantities("""
    J     | kg m2 | arm about its bearing          | 100
    b     | N m s | damping of the bearing         | 10
    k     | N     | pull of the spring             | 1
    r     | m     | spring from the bearing        | 1
    tau_m | N m   | torque of the motor            | 0.3
""")

m = Mechanism("servomechanism", q)
theta = m.coordinate("theta", "rad", "arm from the line of the spring")
turned = m.frame("turned", theta)
A = m.point("A", m.O, turned, q.r)
arm = m.body("arm", turned, 0, m.O, q.J)
m.pin("O", arm, m.ground, m.O)
m.force("spring", arm, A, m.vector(m.world, q.k))
m.torque("motor", arm, m.ground, q.tau_m - q.b * m.rate(theta))
m.begin({theta: 0.5})

SYSTEM = m.system()
