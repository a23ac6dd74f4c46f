"""A planetary train of elliptic gears: ideal at a steady speed, and released, on a motor with loose teeth and a mount.

One function states both. The sun is fixed, the carrier is driven, and the planet carries a planting arm. The released
train has backlash in both meshes, a motor line with a flywheel, and a frame on an elastic mount with the force F_mount.
Without backlash, with stiff teeth, motor and mount, that force is the sum of the ideal forces of the ground.
"""

from derive import (
    ElasticTeeth,
    FrameMount,
    GearContact,
    Mechanism,
    Release,
    ReleasedMechanism,
    gear_pair,
    quantities,
    tangent_angle,
)

q = quantities("""
    phi   | rad   | carrier angle
    omega | r/min | carrier speed                              | 60
    g     | m/s2  | free fall                                  | 9.81
    A     | mm    | half the long axis of the ellipses         | 21
    k     | 1     | their eccentricity                         | 0.14
    t_0   | deg   | sun, from its long side to the middle gear | 20
    bend  | deg   | centre lines, the outer against the inner  | -50
    arm_0 | deg   | arm, from the carrier, at the start        | -60
    s     | mm    | centroid of planet and arm                 | 42
    m_c   | kg    | carrier                                    | 0.5
    J_c   | kg m2 | carrier, about its shaft                   | 0.0004
    m_m   | kg    | middle gear                                | 0.21
    m_p   | kg    | planet with its arm                        | 0.64
    J_m   | kg m2 | middle gear, about its shaft               | 0.00004
    J_p   | kg m2 | planet with its arm, centroidal            | 0.0011
    alpha | deg   | pressure angle of the teeth                | 20
    M_0   | N m   | torque of the motor line at rest           | 600
    W     | r/min | its idle speed                             | 60
    J_f   | kg m2 | flywheel                                   | 0.1
    b     | mm    | backlash along the line of action          | 0.2
    K     | N/m   | stiffness of the teeth                     | 1e6
    C     | N s/m | their damping                              | 100
    m_f   | kg    | frame                                      | 5
    K_f   | N/m   | stiffness of the mount                     | 1e6
    C_f   | N s/m | its damping                                | 2000
""")


def state(m):
    """State the train for a mechanism that an angle drives, or for one that is released."""
    sun_turned = gear_pair("ellipse", q.t_0, A=q.A, k=q.k).turned
    middle_turned = gear_pair("ellipse", q.bend - sun_turned, A=q.A, k=q.k).turned
    t1 = m.coordinate(
        "t1", "rad", "sun, from its long side to the middle gear", equals=q.t_0 + q.phi
    )
    inner_pair = gear_pair("ellipse", t1, A=q.A, k=q.k)
    psi = m.coordinate(
        "psi", "rad", "middle gear, on the carrier", equals=inner_pair.turned - sun_turned
    )
    t2 = m.coordinate(
        "t2",
        "rad",
        "middle gear, from its long side to the planet",
        equals=q.bend - sun_turned - psi,
    )
    outer_pair = gear_pair("ellipse", t2, A=q.A, k=q.k)
    chi = m.coordinate(
        "chi", "rad", "planet, on the carrier", equals=outer_pair.turned - middle_turned
    )

    carrier, outwards = m.frame("carrier", q.phi), m.frame("outwards", q.phi + q.bend)
    middle, planet = m.frame("middle", q.phi + psi), m.frame("planet", q.phi + chi + q.arm_0)
    B = m.point("B", m.O, carrier, 2 * q.A)
    C = m.point("C", B, outwards, 2 * q.A)
    sun, arm = m.body("sun", m.world), m.body("carrier", carrier, q.m_c, m.O, q.J_c)
    gear = m.body("middle gear", middle, q.m_m, B, q.J_m)
    plants = m.body("planet", planet, q.m_p, m.point("centroid", C, planet, q.s), q.J_p)
    m.weld("sun", sun, m.ground, m.O)
    m.pin("O", arm, m.ground, m.O)
    m.pin("B", gear, arm, B)
    m.pin("C", plants, arm, C)
    for tag, inner, outer, line, centre, t, turning, pair in (
        ("P", sun, gear, carrier, B, t1, m.world, inner_pair),
        ("Q", gear, plants, outwards, C, t2, middle, outer_pair),
    ):
        tangent = tangent_angle(m.motion, line, turning, t, pair.radius, pair.slope)
        m.mesh(
            tag,
            inner,
            outer,
            GearContact(line, centre, pair.distance - pair.radius, q.alpha, tangent=tangent),
        )
    m.motor("M_in", arm, m.ground, m.O)
    return m


def push(depth, rate):
    """Return the normal force of teeth."""
    return q.K * depth + q.C * rate


RELEASE = Release(
    motor=lambda speed: q.M_0 * (1 - speed / q.W),
    flywheel=q.J_f,
    teeth={"P": ElasticTeeth("psi", push, q.b), "Q": ElasticTeeth("chi", push, q.b)},
    mount=FrameMount(q.m_f, q.K_f, q.C_f),
)
SYSTEMS = (
    lambda: state(Mechanism("ideal_train", q, angle=q.phi, speed=q.omega, gravity=q.g)).system(),
    lambda: state(
        ReleasedMechanism("released_train", q, RELEASE, angle=q.phi, speed=q.omega, gravity=q.g)
    ).system(),
)
