"""A slider-crank: a crank at constant speed, a rod with mass, a slider in a guide. One side, nothing composed."""

from sympy import S, asin, sin

from derive import (
    Body,
    Frame,
    Kinematics,
    Lane,
    Mechanism,
    Part,
    Pin,
    Point,
    Quantity,
    System,
    Vec,
    Vector,
    Z,
    ordered,
    unit,
    zero,
)


def given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "drawing")


phi, omega = given("phi", "rad", "crank angle"), given("omega", "rad/s", "crank speed")
r, L, c = given("r", "m", "crank"), given("L", "m", "rod"), given("c", "m", "centroid of the rod, from the crank pin")
m, J, M = given("m", "kg", "rod"), given("J", "kg m2", "rod, about its centroid"), given("M", "kg", "slider")
psi = (given("psi", "rad", "rod"), given("psi_dot", "rad/s", "rod"), given("psi_ddot", "rad/s2", "rod"))
x_B, y_B = given("x_B", "m", "slider, along"), given("y_B", "m", "slider, across")
F_Bx = Quantity("F_Bx", "N", "force of the rod on the slider, along", "derived")
F_Ax = Quantity("F_Ax", "N", "force of the crank on the rod, along", "derived")
N_B = Quantity("N_B", "N", "force of the guide on the slider", "derived")
M_O = Quantity("M_O", "N m", "torque of the motor on the crank", "derived")

WORLD = Frame("frame")
CRANK, ROD = Frame("crank", WORLD, Z, phi), Frame("rod", WORLD, Z, -psi[0])
O = Point("O")  # noqa: E741
A = Point("A", O, Vec(CRANK, (r, S.Zero, S.Zero)))
B = Point("B", A, Vec(ROD, (L, S.Zero, S.Zero)))
C = Point("C", A, Vec(ROD, (c, S.Zero, S.Zero)))


def slider_crank() -> System:
    k = Kinematics.along(phi, omega)
    k.coordinate(psi, asin(r / L * sin(phi)))
    k.name_place(B, O, WORLD, (x_B, y_B))

    mech = Mechanism(k.motion, gravity=zero(WORLD))
    frame = mech.add(Body("frame", WORLD))
    crank = mech.add(Body("crank", CRANK, (), Pin(O, WORLD, planar=True)))
    rod = mech.add(Body("rod", ROD, (Part(m, C, (S.Zero, S.Zero, J)),), Pin(A, WORLD, planar=True)))
    slider = mech.add(Body("slider", WORLD, (Part(M, B, (S.Zero, S.Zero, S.Zero)),), Pin(B, WORLD, planar=True)))
    mech.joint("F_O", crank, frame, O, WORLD, free=Z)
    mech.joint("F_A", rod, crank, A, WORLD, free=Z)
    mech.joint("F_B", slider, rod, B, WORLD, free=Z)
    guide = mech.unknown("N_B", "N", "force of the guide on the slider")
    mech.act("N_B", slider, frame, B, Vec(WORLD, (S.Zero, guide, S.Zero)))
    mech.torque("M_O", crank, frame, O, unit(WORLD, Z), "torque of the motor on the crank")

    wanted = (F_Ax, F_Bx, N_B, M_O)
    steps = (*k.steps, *ordered(mech.equations(), mech.unknowns, wanted).lets())
    data = Vector("data", (omega, r, L, c, m, J, M))
    lane = Lane(phi, (data,), steps, Vector("forces", (x_B, psi[0], *wanted)))
    return System("slider_crank", "Slider-crank", "derived", ("rigid bodies", "no friction", "constant speed"), lane)


SYSTEMS = (slider_crank,)
