"""A rotary transplanter on a motor whose torque is an input: an arm behind two pairs of elliptic gears.

The sun is fixed and meshes with the first gear of a middle shaft; the second one meshes with the planet, which carries
the arm. Gears are balanced discs of steel. Their sizes, eccentricities and phases are design values, and the carrier
goes as the torque lets it.
"""

from sympy import pi

from derive import GearContact, Mechanism, gear_pair, quantities, tangent_angle

q = quantities("""
    g     | m/s2  | free fall                                  | 9.81
    A_1   | mm    | half the long axis, first stage            | 21   | 18 26
    k_1   | 1     | eccentricity, first stage                  | 0.14 | 0 0.3
    A_2   | mm    | half the long axis, second stage           | 21   | 18 26
    k_2   | 1     | eccentricity, second stage                 | 0.14 | 0 0.3
    t_1   | deg   | sun, from its long side to the first gear  | 20   | -40 80
    t_2   | deg   | second gear, from its long side to the planet | -88 | -150 -30
    bend  | deg   | centre lines, the outer against the inner  | -50  | -90 -10
    arm_0 | deg   | arm, from the carrier, at the start        | -60  | -120 -10
    l     | mm    | tip of the arm, from the planet's shaft    | 150  | 120 180
    s     | mm    | centroid of the arm                        | 42
    m_a   | kg    | arm                                        | 0.5
    J_a   | kg m2 | arm, centroidal                            | 0.001
    rho   | kg/m3 | steel                                      | 7850
    w     | mm    | width of the gears                         | 10
    alpha | deg   | pressure angle of the teeth                | 20
    J_c   | kg m2 | carrier with the motor, about its shaft    | 0.004
    c     | N m s | friction of the carrier                    | 0.02
    phi_0 | deg   | carrier at the start                       | 150
    omega | r/min | its speed at the start                     | 100
""")
m = Mechanism("rotary_transplanter", q, gravity=q.g)
phi = m.coordinate("phi", "rad", "carrier")
T = m.input("T", "N m", "torque of the motor on the carrier")
t1 = m.coordinate("t1", "rad", "sun, at the contact", equals=q.t_1 + phi)
inner, begun = (gear_pair("ellipse", t, A=q.A_1, k=q.k_1) for t in (t1, q.t_1))
psi = m.coordinate("psi", "rad", "middle, on the carrier", equals=inner.turned - begun.turned)
t2 = m.coordinate("t2", "rad", "second gear, at the contact", equals=q.t_2 - psi)
outer, begun = (gear_pair("ellipse", t, A=q.A_2, k=q.k_2) for t in (t2, q.t_2))
chi = m.coordinate("chi", "rad", "planet, on the carrier", equals=outer.turned - begun.turned)

inward, outward = m.frame("carrier", phi), m.frame("outward", phi + q.bend)
middle, turned = m.frame("middle", phi + psi), m.frame("arm", phi + chi + q.arm_0)
B = m.point("B", m.O, inward, 2 * q.A_1)
C = m.point("C", B, outward, 2 * q.A_2)
centroid, tip = (m.point(name, C, turned, at) for name, at in (("G", q.s), ("tip", q.l)))
m_1, m_2 = (q.rho * q.w * pi * A**2 for A in (q.A_1, q.A_2))
J_1, J_2 = m_1 * q.A_1**2 / 2, m_2 * q.A_2**2 / 2

sun, carrier = m.body("sun", m.world), m.body("carrier", inward, 0, m.O, q.J_c)
gears, planet = (
    m.body("gears", middle, m_1 + m_2, B, J_1 + J_2),
    m.body("planet", turned, m_2, C, J_2),
)
arm = m.body("arm", turned, q.m_a, centroid, q.J_a)
m.weld("sun", sun, m.ground, m.O)
m.pin("O", carrier, m.ground, m.O)
m.pin("B", gears, carrier, B)
m.pin("C", planet, carrier, C)
m.weld("arm", arm, planet, C)
for tag, a, b, line, centre, t, turning, pair in (
    ("P", sun, gears, inward, B, t1, m.world, inner),
    ("Q", gears, planet, outward, C, t2, middle, outer),
):
    tangent = tangent_angle(m.motion, line, turning, t, pair.radius, pair.slope)
    teeth = GearContact(line, centre, pair.distance - pair.radius, q.alpha, tangent=tangent)
    m.mesh(tag, a, b, teeth)
m.torque("motor", carrier, m.ground, T - q.c * m.rate(phi))
m.begin({phi: q.phi_0, m.rate(phi): q.omega})
m.report("x_tip", "m", "tip of the arm, x", m.position(tip)[0])
m.report("y_tip", "m", "tip of the arm, y", m.position(tip)[1])
SYSTEM = m.system()
