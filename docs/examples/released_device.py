"""The planting device of Wang et al. (2017), ideal at a steady speed, and released: loose teeth, a motor, a mount.

Gears, masses and speed are those of the built-in machine, with both nozzles closed: two sides, half a turn apart, on
one sun and carrier. The pitch radius of the sun is a table of `released_device.csv`. In the released device the teeth
have backlash, so that F_mounty, the force under its frame, may rattle.
"""

from pathlib import Path

from sympy import Rational, cos, pi, sin

from derive import (
    ElasticTeeth,
    FrameMount,
    GearContact,
    Mechanism,
    Part,
    Release,
    ReleasedMechanism,
    gear_pair,
    quantities,
    read_gear_pair,
    tangent_angle,
)

SUN = read_gear_pair(
    Path(__file__).with_name("released_device.csv"), "t | deg | polar angle on the sun\nr | mm | its pitch radius"
)
q = quantities(f"""
    phi     | rad   | carrier
    omega   | r/min | its speed                             | 40
    g       | m/s2  | free fall                             | 9.81
    a_1     | m     | shafts of sun and middle gear         | {SUN.distance}
    A_6     | mm    | half the long axis of gear 6          | 30.694
    k_6     | 1     | its eccentricity                      | 0.031
    m_61    | 1     | its deformation                       | 1.26
    alpha_3 | deg   | sun, at the contact                   | 25.467
    beta_6  | deg   | gear 6, at the contact                | 1.375
    gamma   | deg   | centre lines, the outer against the inner | 30.834
    theta   | deg   | nozzle, from the carrier              | 65.744
    m_1     | kg    | sun                                   | 0.4
    rho_1   | mm    | its centroid                          | 4
    eta_1   | deg   | its centroid, from the horizontal     | 64.5
    m_4     | kg    | carrier, balanced                     | 3.975
    J_4     | kg m2 | its inertia                           | 0.02
    m_2     | kg    | middle gears                          | 0.6
    rho_2   | mm    | their centroid                        | 3
    eta_2   | deg   | their centroid, at the start          | 200
    J_2     | kg m2 | their inertia, centroidal             | 3.946e-4
    m_3     | kg    | planet                                | 1.2
    x_3     | mm    | its centroid, along the nozzle        | 20
    y_3     | mm    | its centroid, across the nozzle       | -6
    J_3     | kg m2 | its inertia, centroidal               | 9.768e-4
    m_C1    | kg    | both rockers                          | 0.16
    x_C1    | mm    | their centroid, along the nozzle      | 12
    y_C1    | mm    | their centroid, across the nozzle     | 30
    J_C1    | kg m2 | their inertia                         | 8e-5
    m_C2    | kg    | both halves of the nozzle             | 0.84
    x_C2    | mm    | their centroid, along the nozzle      | 105
    y_C2    | mm    | their centroid, across the nozzle     | -4
    J_C2    | kg m2 | their inertia                         | 1.6e-3
    alpha_n | deg   | pressure angle                        | 20
    M_0     | N m   | motor line at rest                    | 200
    W       | r/min | its idle speed                        | 41
    J_f     | kg m2 | flywheel                              | 0.5
    b       | mm    | backlash along the line of action     | 0.2
    K       | N/m1.5 | stiffness of the teeth               | 1e9
    D       | s/m   | their damping                         | 0.5
    m_f     | kg    | frame                                 | 8
    K_f     | N/m   | stiffness of the mount                | 1e6
    C_f     | N s/m | its damping                           | 600
""")


def state(m):
    """State the device for a mechanism that an angle drives, or for one that is released."""
    carrier = m.frame("carrier", q.phi)
    sun = m.body("sun", m.world, q.m_1, m.point("CO", m.O, m.world, q.rho_1 * cos(q.eta_1), q.rho_1 * sin(q.eta_1)))
    arm = m.body("carrier", carrier, q.m_4, m.O, q.J_4)
    m.weld("sun", sun, m.ground, m.O)
    m.pin("O", arm, m.ground, m.O)
    for side, ahead in (("1", 0), ("2", pi)):
        state_side(m, side, ahead, carrier, (sun, arm))
    m.motor("M_in", arm, m.ground, m.O)
    return m


def state_side(m, side, ahead, carrier, shared):
    """State a side, whose carrier angle is ahead by an angle, on sun and carrier."""
    sun, arm = shared

    def angle(name, meaning, equals):
        return m.coordinate(f"{name}_{side}", "rad", f"{meaning}, side {side}", equals=equals)

    start = SUN.pair(q.alpha_3, q.a_1).turned
    t1 = angle("t1", "sun, at the contact", q.alpha_3 + q.phi + ahead)
    first = SUN.pair(t1, q.a_1)
    psi = angle("psi", "middle gears, on the carrier", first.turned - start)
    t2 = angle("t2", "gear 6, at the contact", q.beta_6 + psi)
    ellipse = {"deformation": q.m_61, "A": q.A_6, "k": q.k_6}
    second = gear_pair("ellipse", t2, **ellipse)
    chi = angle("chi", "planet, on the carrier", gear_pair("ellipse", q.beta_6, **ellipse).turned - second.turned)

    turn = q.phi + ahead
    inward, outward = m.frame(f"inward {side}", turn + pi / 2), m.frame(f"outward {side}", turn + pi / 2 + q.gamma)
    middle = m.frame(f"middle {side}", turn + psi)
    planet = m.frame(f"planet {side}", turn + chi + q.theta - pi)
    A = m.point(f"A{side}", m.O, inward, q.a_1)
    B = m.point(f"B{side}", A, outward, second.distance)
    shifted = m.point(f"CA{side}", A, middle, q.rho_2 * cos(q.eta_2), q.rho_2 * sin(q.eta_2))
    gears = m.body(f"middle gears {side}", middle, q.m_2, shifted, q.J_2)
    halves = [
        Part(mass, m.point(f"{name}{side}", B, planet, x, y), (0, 0, inertia))
        for name, mass, x, y, inertia in (
            ("C1", q.m_C1, q.x_C1, q.y_C1, q.J_C1), ("C2", q.m_C2, q.x_C2, q.y_C2, q.J_C2),
        )
    ]  # fmt: skip
    nozzle = m.body(f"planet {side}", planet, q.m_3, m.point(f"CB{side}", B, planet, q.x_3, q.y_3), q.J_3, parts=halves)
    m.pin(f"A{side}", gears, arm, A)
    m.pin(f"B{side}", nozzle, arm, B)
    for tag, inner, outer, line, centre, t, turning, pair in (
        ("P", sun, gears, inward, A, t1, m.world, first),
        ("Q", gears, nozzle, outward, B, t2, middle, second),
    ):
        tangent = tangent_angle(m.motion, line, turning, t, pair.radius, pair.slope)
        teeth = GearContact(line, centre, pair.distance - pair.radius, q.alpha_n, tangent=tangent)
        m.mesh(f"{tag}{side}", inner, outer, teeth)


def push(depth, rate):
    """Return the force of teeth by the law of Hunt and Crossley (1975)."""
    return q.K * depth ** Rational(3, 2) * (1 + q.D * rate)


RELEASE = Release(
    motor=lambda speed: q.M_0 * (1 - speed / q.W),
    flywheel=q.J_f,
    teeth={
        f"{tag}{side}": ElasticTeeth(f"{coordinate}_{side}", push, q.b)
        for side in "12"
        for tag, coordinate in (("P", "psi"), ("Q", "chi"))
    },
    mount=FrameMount(q.m_f, q.K_f, q.C_f),
)
SYSTEMS = (
    lambda: state(Mechanism("ideal_device", q, angle=q.phi, speed=q.omega, gravity=q.g)).system(),
    lambda: state(ReleasedMechanism("released_device", q, RELEASE, angle=q.phi, speed=q.omega, gravity=q.g)).system(),
)
