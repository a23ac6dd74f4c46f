"""A crank press whose shaft also lifts an ejector by a cam: ideal at a steady speed, and released.

One function states both. In the released press the pin of the slider is loose and rubs in its bush, the ejector can
lift off its cam, and a motor line with a flywheel drives the shaft. With a stiff pin and cam, no clearance and a stiff
motor the forces are the ideal ones.
"""

from sympy import cos

from derive import LiftingFollower, LoosePin, Mechanism, Release, ReleasedMechanism, Y, quantities

q = quantities("""
    phi   | rad   | crank
    omega | r/min | its speed                         | 600
    g     | m/s2  | free fall                         | 9.81
    r     | mm    | crank                             | 50
    l     | mm    | rod                               | 150
    e     | mm    | offset of the guide               | 12
    m_c   | kg    | crank                             | 2
    c_c   | mm    | its centroid                      | 15
    J_c   | kg m2 | its inertia, centroidal           | 0.005
    m_r   | kg    | rod                               | 0.8
    c_r   | mm    | its centroid                      | 60
    J_r   | kg m2 | its inertia, centroidal           | 0.003
    m_s   | kg    | slider                            | 1.5
    y_0   | mm    | roller's centre at the lowest     | 38
    h     | mm    | lift of the ejector               | 14
    m_e   | kg    | ejector                           | 0.65
    k     | N/m   | its spring                        | 300
    F_0   | N     | its spring at the lowest          | 2
    M_0   | N m   | torque of the motor line at rest  | 600
    W     | r/min | its idle speed                    | 600
    J_f   | kg m2 | flywheel                          | 0.4
    b     | mm    | radial clearance of the pin       | 0.1
    K     | N/m   | stiffness of pin and bush         | 1e7
    C     | N s/m | their damping                     | 800
    mu    | 1     | friction of the pin               | 0.15
    v     | m/s   | speed below which it creeps       | 0.02
    K_e   | N/m   | stiffness of cam and roller       | 1e6
    C_e   | N s/m | their damping                     | 100
""")


def state(m):
    """State the press for a mechanism that an angle drives, or for one that is released."""
    beta, s = m.coordinate("beta", "rad", "rod"), m.coordinate("s", "m", "slider")
    u = m.coordinate("u", "m", "lift of the ejector", equals=q.h * (1 - cos(q.phi)) / 2)
    turned, rod = m.frame("crank", q.phi), m.frame("rod", beta)
    A = m.point("A", m.O, turned, q.r)
    B = m.point("B", A, rod, q.l)
    slot = m.point("slot", m.O, m.world, s, q.e)
    roller = m.point("roller", m.O, m.world, 0, q.y_0 + u)
    m.close(B, slot, start={beta: 0, s: q.l + q.r})

    crank = m.body("crank", turned, q.m_c, m.point("G", m.O, turned, q.c_c), q.J_c)
    link = m.body("rod", rod, q.m_r, m.point("C", A, rod, q.c_r), q.J_r)
    slider = m.body("slider", m.world, q.m_s, slot)
    ejector = m.body("ejector", m.world, q.m_e, roller)
    m.pin("O", crank, m.ground, m.O)
    m.pin("A", link, crank, A)
    m.pin("B", slider, link, slot)
    m.slide("guide", slider, m.ground, slot)
    m.follower("N_cam", ejector, crank, roller, m.O, across=m.vector(m.world, z=-1))
    m.slide("stem", ejector, m.ground, roller, along=Y)
    m.force("spring", ejector, roller, m.vector(m.world, 0, -q.F_0 - q.k * u))
    m.motor("M_in", crank, m.ground, m.O)
    return m


RELEASE = Release(
    motor=lambda speed: q.M_0 * (1 - speed / q.W),
    flywheel=q.J_f,
    pins={
        "B": LoosePin(
            "B", q.b, lambda depth, rate: q.K * depth + q.C * rate, friction=q.mu, creep=q.v
        )
    },
    followers={"N_cam": LiftingFollower("u", lambda depth, rate: q.K_e * depth + q.C_e * rate)},
)
SYSTEMS = (
    lambda: state(Mechanism("ideal_press", q, angle=q.phi, speed=q.omega, gravity=q.g)).system(),
    lambda: state(
        ReleasedMechanism("released_press", q, RELEASE, angle=q.phi, speed=q.omega, gravity=q.g)
    ).system(),
)
