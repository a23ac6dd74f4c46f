"""The planting device of Wang et al. (2017), ideal at a steady speed, and released: loose teeth, a motor, a mount.

The built-in machine with closed nozzles: two sides, half a turn apart. The sun's radius is a table of a CSV file.
"""

from pathlib import Path

from sympy import cos, pi, sin

from derive import (
    ElasticTeeth,
    FrameMount,
    GearContact,
    Mechanism,
    Release,
    ReleasedMechanism,
    gear_pair,
    quantities,
    read_gear_pair,
    tangent_angle,
)

SUN = read_gear_pair(
    Path(__file__).with_name("released_device.csv"),
    "t | deg | polar angle on the sun\nr | mm | its pitch radius",
)
q = quantities(f"""
    phi     | rad    | carrier
    omega   | r/min  | its speed                                 | 40
    g       | m/s2   | free fall                                 | 9.81
    a_1     | m      | shafts of sun and middle gears            | {SUN.distance}
    A_6     | mm     | half the long axis of gear 6              | 30.694
    k_6     | 1      | its eccentricity                          | 0.031
    m_61    | 1      | its deformation                           | 1.26
    alpha_3 | deg    | sun, at the contact                       | 25.467
    beta_6  | deg    | gear 6, at the contact                    | 1.375
    gamma   | deg    | centre lines, the outer against the inner | 30.834
    theta   | deg    | nozzle, from the carrier                  | 65.744
    m_1     | kg     | sun                                       | 0.4
    m_4     | kg     | carrier, balanced                         | 3.975
    m_2     | kg     | middle gears                              | 0.6
    rho_2   | mm     | their centroid                            | 3
    eta_2   | deg    | their centroid, at the start              | 200
    J_2     | kg m2  | their inertia, centroidal                 | 3.946e-4
    m_3     | kg     | planet with its nozzle                    | 2.2
    x_3     | mm     | its centroid, along the nozzle            | 51.8727
    y_3     | mm     | its centroid, across the nozzle           | -2.6182
    J_3     | kg m2  | its inertia, centroidal                   | 6.687e-3
    alpha_n | deg    | pressure angle                            | 20
    M_0     | N m    | motor line at rest                        | 200
    W       | r/min  | its idle speed                            | 40
    J_f     | kg m2  | flywheel                                  | 0.5
    b       | mm     | backlash along the line of action         | 0.2
    K       | N/m    | stiffness of the teeth                    | 1e7
    D       | N s/m  | their damping                             | 300
    m_f     | kg     | frame                                     | 8
    K_f     | N/m    | stiffness of the mount                    | 1e6
    C_f     | N s/m  | its damping                               | 400
""")


def state(m):
    """State the device for a mechanism that an angle drives, or for one that is released."""
    carrier = m.frame("carrier", q.phi)
    sun, arm = m.body("sun", m.world, q.m_1, m.O), m.body("carrier", carrier, q.m_4, m.O)
    m.weld("sun", sun, m.ground, m.O)
    m.pin("O", arm, m.ground, m.O)
    for side, ahead in (("1", 0), ("2", pi)):
        t1 = m.coordinate(
            f"t1_{side}", "rad", "sun, at the contact", equals=q.alpha_3 + q.phi + ahead
        )
        turn, first, begun = q.phi + ahead, *(SUN.pair(t, q.a_1) for t in (t1, q.alpha_3))
        psi = m.coordinate(
            f"psi_{side}", "rad", "middle gears, on the carrier", equals=first.turned - begun.turned
        )
        t2 = m.coordinate(f"t2_{side}", "rad", "gear 6, at the contact", equals=q.beta_6 + psi)
        second, begun = (gear_pair("ellipse", t, q.m_61, A=q.A_6, k=q.k_6) for t in (t2, q.beta_6))
        chi = m.coordinate(
            f"chi_{side}", "rad", "planet, on the carrier", equals=begun.turned - second.turned
        )
        inward, outward = (
            m.frame(f"inward {side}", turn + pi / 2),
            m.frame(f"outward {side}", turn + pi / 2 + q.gamma),
        )
        middle, planet = (
            m.frame(f"middle {side}", turn + psi),
            m.frame(f"planet {side}", turn + chi + q.theta - pi),
        )
        A = m.point(f"A{side}", m.O, inward, q.a_1)
        B = m.point(f"B{side}", A, outward, second.distance)
        CA = m.point(f"CA{side}", A, middle, q.rho_2 * cos(q.eta_2), q.rho_2 * sin(q.eta_2))
        gears = m.body(f"middle gears {side}", middle, q.m_2, CA, q.J_2)
        nozzle = m.body(
            f"planet {side}", planet, q.m_3, m.point(f"C{side}", B, planet, q.x_3, q.y_3), q.J_3
        )
        m.pin(f"A{side}", gears, arm, A)
        m.pin(f"B{side}", nozzle, arm, B)
        meshes = (
            ("P", sun, gears, inward, A, t1, m.world, first),
            ("Q", gears, nozzle, outward, B, t2, middle, second),
        )
        for mesh, inner, outer, line, centre, t, gear, pair in meshes:
            tangent = tangent_angle(m.motion, line, gear, t, pair.radius, pair.slope)
            teeth = GearContact(
                line, centre, pair.distance - pair.radius, q.alpha_n, tangent=tangent
            )
            m.mesh(mesh + side, inner, outer, teeth)
    m.motor("M_in", arm, m.ground, m.O)
    return m


MESHES = {"P1": "psi_1", "Q1": "chi_1", "P2": "psi_2", "Q2": "chi_2"}
TEETH = {
    mesh: ElasticTeeth(at, lambda depth, rate: q.K * depth + q.D * rate, q.b)
    for mesh, at in MESHES.items()
}
RELEASE = Release(
    lambda speed: q.M_0 * (1 - speed / q.W), q.J_f, TEETH, mount=FrameMount(q.m_f, q.K_f, q.C_f)
)
IDEAL = Mechanism("ideal_device", q, angle=q.phi, speed=q.omega, gravity=q.g)
RELEASED = ReleasedMechanism("released_device", q, RELEASE, angle=q.phi, speed=q.omega, gravity=q.g)
SYSTEMS = (
    lambda: state(IDEAL).system(["F_sunx", "F_suny", "F_Ox", "F_Oy"]),
    lambda: state(RELEASED).system(
        ["F_mountx", "F_mounty", "M_in", *(f"F_N{mesh}" for mesh in MESHES)]
    ),
)
