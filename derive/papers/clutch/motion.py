"""Control linkage, engagement and slip of the clutch (shi2021, figs. 7-10), and the slider crank
over its travel.

The arc rack is fixed and centred at the hinge D of the link; the link carries the crank gear. The
output shaft is a beam that overhangs its bearing and bends in one assumed mode; body and shaft end
move together while they touch. The x axis of the slider crank is the guide AC, from the crank's
axis A to the sleeve's pin C.
"""

from __future__ import annotations

from functools import cache, partial

import sympy as sp
from sympy import Derivative, Expr, Function, S, cos, pi, sin, sqrt
from sympy.calculus.euler import euler_equations

from ...formulas import Formulas
from ...functions import clip
from ...mechanics.frames import Frame, Motion, Point, Vec, Z, displacement
from ...model import let
from ...quantity import Quantity, Vector
from . import quantities as q
from .geometry import SIDES

WORLD = Frame("frame")
LINK = Frame("link", WORLD, Z, q.alpha)
GEAR = Frame("crank gear", WORLD, Z, q.theta_A)
D = Point("D")
AXIS = Point("A", D, Vec(LINK, (q.r_D + q.r_A, S.Zero, S.Zero)))
MESH = pi / 2 - q.gamma
"""Inclination of the link at the start of mesh."""

SURFACE = Frame("surface", WORLD, Z, -q.theta0)
"""The engaging surface: F_x acts along and into it, F_y into it and backwards."""


def gear_rate() -> Expr:
    """Return the rate of the crank gear per rate of the link: the contact point on the fixed rack
    is at rest.
    """
    turning = sp.Dummy("rate")
    motion = Motion(rates={q.alpha: S.One, q.theta_A: turning})
    axis = motion.derivative(displacement(D, AXIS, LINK))
    to_contact = Vec(LINK, (-q.r_A, S.Zero, S.Zero))
    contact = axis + motion.spin(GEAR).resolved(LINK).cross(to_contact)
    (rate,) = sp.solve(contact[1], turning)
    return sp.expand(rate.subs(q.r_A, q.k * q.r_D))


def gear_rotation(rate: Expr) -> Expr:
    """Return the rotation at an inclination of the link, for a constant rate; zero before mesh."""
    angle = sp.Dummy("angle")
    rotation = rate * sp.integrate(1, (angle, MESH, q.alpha))
    return sp.Piecewise((S.Zero, sp.Lt(q.alpha, MESH)), (rotation, sp.Ge(q.alpha, MESH)))


def _place_links(angle: Expr, distance: Expr) -> tuple[Vec, Vec]:
    """Return the crank AB at an angle, and the rod from C on the guide at a distance of A to B."""
    A = Point("A")
    B = Point("B", A, Vec(Frame("crank", WORLD, Z, angle), (q.l_AB, S.Zero, S.Zero)))
    C = Point("C", A, Vec(WORLD, (distance, S.Zero, S.Zero)))
    return displacement(A, B, WORLD), displacement(C, B, WORLD)


def crank_angle(distance: Expr) -> Expr:
    """Return the angle between crank AB and guide AC for a distance AC, from the closed loop
    A-B-C.
    """
    angle = sp.Dummy("angle")
    _, rod = _place_links(angle, distance)
    square = sp.expand(rod.dot(rod)).subs(sin(angle) ** 2, 1 - cos(angle) ** 2)
    (cosine,) = sp.solve(sp.expand(square) - q.l_BC**2, cos(angle))
    return sp.acos(cosine)


def add_linkage(f: Formulas) -> None:
    """Add the equations of crank gear, rack and crank slider: section 2.4."""
    rate = gear_rate()
    teeth = 2 * q.r_A / q.m
    f.defines(q.theta_A, gear_rotation(rate), "rotation of the crank gear with the link")
    f.defines(
        q.theta_AR, gear_rotation(rate - 1), "rotation of the crank gear relative to the link"
    )
    f.defines(
        q.theta_Amax, q.n * 2 * pi / teeth, "rotation of the crank gear for a number of teeth"
    )
    turned = crank_angle(q.l_AC) - crank_angle(q.l_AC + q.c)
    f.defines(q.theta_Amax, turned, "rotation of the crank for the travel of the sleeve")
    f.defines(q.t_c, travel_time(), "time to switch", named=True)


def travel_time() -> Expr:
    """Return the time of the sleeve's travel at its mean speed."""
    time = sp.Dummy("time")
    (duration,) = sp.solve(sp.integrate(q.v_c, (time, 0, time)) - q.c, time)
    return duration


def equations_of_motion() -> tuple[Expr, Expr]:
    """Return the equations of a beam with a load N at x = l, and of the driven body that exerts it.

    Both follow from stationary action.
    """
    x, t = sp.symbols("x t", real=True)
    beam, body = Function("beam")(x, t), Function("body")(t)
    bending = q.E * q.I * beam.diff(x, 2) ** 2 / 2
    density = q.rho * q.S * beam.diff(t) ** 2 / 2 - bending + q.N * q.delta_l * beam
    action = q.m1 * body.diff(t) ** 2 / 2 + (q.F_M - q.N) * body
    (of_beam,), (of_body,) = (
        euler_equations(density, [beam], [x, t]),
        euler_equations(action, [body], [t]),
    )
    named = {
        Derivative(beam, (x, 4)): q.y_4x,
        Derivative(beam, (t, 2)): q.a_x,
        Derivative(body, (t, 2)): q.a_l,
    }
    return -of_beam.lhs.subs(named), of_body.lhs.subs(named)


def assumed_mode() -> Expr:
    """Return the assumed shape: a sine from the bearing with its first crest, of height 1, at the
    contact.
    """
    wave = sp.Dummy("wave", positive=True)
    crest = min(s for s in sp.solve(cos(wave), wave) if s > 0)
    return sin(crest * q.x / q.l)


@cache
def modal_coefficients() -> tuple[Expr, Expr]:
    """Return mass and stiffness of the shaft in its mode: the beam's equation projected on the
    shape.
    """
    span = sp.Dummy("span", positive=True)
    shape = assumed_mode().subs(q.l, span)
    mass = sp.integrate(q.rho * q.S * shape**2, (q.x, 0, span))
    stiffness = sp.integrate(q.E * q.I * shape.diff(q.x, 4) * shape, (q.x, 0, span))
    return mass.subs(span, q.l), stiffness.subs(span, q.l)


@cache
def contact_motion() -> Expr:
    """Return the deflection at the contact: (M_1 + m1) y'' + K_1 y = F_M, from zero with the body's
    speed.
    """
    time, frequency = sp.Symbol("time", real=True), sp.Symbol("frequency", positive=True)
    deflection = Function("deflection")
    motion = sp.Eq(deflection(time).diff(time, 2) + frequency**2 * deflection(time), q.B2)
    start = {deflection(0): 0, deflection(time).diff(time).subs(time, 0): q.Delta_omega * q.r1}
    return sp.expand(sp.dsolve(motion, deflection(time), ics=start).rhs).subs(
        {time: q.t, frequency: q.B1}
    )


def contact_speed() -> Expr:
    """Return the speed of the body's contact point relative to the output shaft."""
    angle = sp.Dummy("angle")
    arm = Vec(Frame("body", WORLD, Z, angle), (q.r1, S.Zero, S.Zero))
    return Motion(rates={angle: q.Delta_omega}).derivative(arm)[1]


def common_speed() -> Expr:
    """Return the common speed of body and shaft after the impact, which conserves the momentum of
    the body.
    """
    speed, (mass, _) = sp.Dummy("speed"), modal_coefficients()
    (common,) = sp.solve((q.m1 + mass) * speed - q.m1 * contact_speed(), speed)
    return common


def bearing_conditions(deflection: Expr) -> dict[str, Expr]:
    """Return the expressions that must vanish at the bearing: the deflection, and the balance of
    moments.

    The virtual work of bending has the term -E I y'' on the slope at x = 0; a bearing with
    rotational stiffness k adds k y', so that k y' = E I y''. With the fixity c = k l/(k l + E I)
    this is c y' = (1 - c) l y'': the end is clamped for c = 1, hinged for c = 0, and elastic in
    between.
    """
    slope, curvature = (deflection.diff(q.x, order).subs(q.x, 0) for order in (1, 2))
    return {
        "deflection at the bearing": deflection.subs(q.x, 0),
        "slope at the bearing": q.fixity * slope - (1 - q.fixity) * q.l * curvature,
    }


def add_engagement(f: Formulas) -> None:
    """Add the equations of the contact of tooth and output shaft: section 3.1."""
    of_beam, of_body = equations_of_motion()
    mass, stiffness = modal_coefficients()
    section = sp.Polygon(*sp.RegularPolygon((0, 0), 1, SIDES).vertices)
    moving = (mass + q.m1).subs(q.rho, q.m2 / (q.S * q.l))
    shape, path = assumed_mode(), contact_motion()
    acceleration = path.diff(q.t, 2)
    load = sp.expand(sp.solve(of_body.subs(q.a_l, acceleration), q.N)[0])
    swing = load.coeff(sin(q.B1 * q.t)) ** 2 + load.coeff(cos(q.B1 * q.t)) ** 2
    frequency, push = sp.sqrt(stiffness / moving), q.F_M / moving
    inside = sp.expand(swing / q.m1**2).subs(q.B1, frequency).subs(q.B2, push)
    f.holds("force on the engaging body", of_body)
    f.holds("force on the output shaft", of_beam)
    f.defines(q.v_0, contact_speed(), "speed of the contact point at the start")
    f.defines(
        q.v_0, common_speed(), "speed of body and shaft at the start, when they move together"
    )
    f.defines(q.y, q.y_max * shape, "deflection of the shaft in its mode")
    f.defines(q.y, path * shape, "deflection of the shaft over time")
    f.defines(q.y_max, path, "deflection at the contact over time")
    f.defines(q.S, section.area * q.a1**2, "section of the shaft")
    f.defines(q.I, section.second_moment_of_area()[0] * q.a1**4, "second moment of the shaft")
    f.defines(q.M_1, mass, "modal mass of the shaft")
    f.defines(q.K_1, stiffness, "modal stiffness of the shaft")
    f.defines(q.m2, q.rho * q.S * q.l, "mass of the overhanging shaft")
    f.defines(q.B1, frequency, "circular frequency in contact")
    f.defines(q.B2, push, "acceleration by the driving force")
    f.defines(q.a_l, acceleration, "acceleration of the shaft at the contact")
    f.defines(q.a_x, acceleration * shape, "acceleration of the shaft")
    f.defines(q.y_4x, path * shape.diff(q.x, 4), "fourth derivative of the deflection")
    f.defines(q.delta_l, q.rho * q.S * shape / mass, "Dirac's delta in the mode")
    f.defines(q.N, load, "contact load over time")
    f.defines(q.N_max, q.F_M + q.m1 * sp.sqrt(inside), "largest contact load")


def add_slip(f: Formulas) -> None:
    """Add the equations of the forces on the tooth along the surface and across it: section 3.2."""
    reaction = Vec(WORLD, (q.F_x, q.F_y, S.Zero)).resolved(SURFACE)
    contact = Vec(SURFACE, (-q.f0, -q.N, S.Zero))
    total = reaction + contact
    inertia = q.m1 * q.a0
    (pull,) = sp.solve(total[1], q.F_x)
    (acceleration,) = sp.solve(total[0].subs(q.F_x, pull) - inertia, q.a0)
    acceleration = sp.trigsimp(sp.simplify(acceleration))
    at_rest = contact.resolved(WORLD)[1] + q.F_y
    (threshold,) = sp.solve(at_rest, q.N)
    f.holds("forces on the tooth across the surface", q.N - reaction[1])
    f.holds("forces on the tooth along the surface", total[0] - inertia)
    f.defines(q.a0, acceleration, "acceleration of the slip")
    f.holds("load at which the tooth slips", q.N - sp.expand(threshold), ">")
    f.holds("forces on the tooth without slip", q.F_y - (q.F_y - at_rest))


_slider = partial(Quantity, source="derived: clutch")


CRANK = Vector("crank", (q.l_AB, q.l_BC, q.l_AC))
SHIFT = _slider("shift", "m", "displacement of the sleeve from its engaged position")
ANGLE = _slider("crank_angle", "rad", "angle of the crank from the guide AC")
X_B = _slider("pin_x", "m", "crank pin B, along the guide")
Y_B = _slider("pin_y", "m", "crank pin B, across the guide")
ROD = _slider("rod_angle", "rad", "angle of the rod with the guide")
LEVER = _slider("lever", "m", "displacement of the sleeve per rotation of the crank")
TOOTH = _slider(
    "tooth_force", "N", "tangential force of the rack on the crank gear while the sleeve is pushed"
)
SIDE = _slider("side_force", "N", "force of the guide on the sleeve, perpendicular to its travel")
SPAN = _slider(
    "span", "m", "distance of the crank gear's axis from the hinge of the link: both pitch radii"
)
LIFT = _slider("lift", "rad", "rotation of the link during the sleeve's travel")
LIMIT = _slider("alpha_max", "rad", "inclination of the link at the end of the sleeve's travel")
SHARE = _slider(
    "share", "1", "travel as a share of the largest travel of this crank in that rotation"
)
RODS = (
    _slider("l_BC_1", "m", "rod, first solution"),
    _slider("l_BC_2", "m", "rod, second solution"),
)


def add_slider(f: Formulas) -> None:
    """Add the linkage over its travel, the forces to push the sleeve, its gears, and its rod for a
    required travel.
    """
    pin, rod = _place_links(ANGLE, q.l_AC + SHIFT)
    angle = crank_angle(q.l_AC + SHIFT)
    pose = (
        let(ANGLE, angle, "the loop A-B-C closes"),
        let(X_B, pin[0], "the loop A-B-C closes"),
        let(Y_B, pin[1], "the loop A-B-C closes"),
        let(ROD, sp.atan2(rod[1], -rod[0]), "the loop A-B-C closes"),
        let(LEVER, -1 / angle.diff(SHIFT), "the loop A-B-C closes"),
    )
    torque = sp.Dummy("torque")
    (needed,) = sp.solve(torque - q.F1 * LEVER, torque)
    push = (
        *pose,
        let(TOOTH, needed / q.r_A, "virtual work of rack and sleeve"),
        let(SIDE, q.F1 * sp.tan(ROD), "balance of the sleeve: the rod pulls along itself"),
    )
    f.function("slider", (SHIFT, CRANK), *pose)
    f.function("push", (SHIFT, CRANK, q.F1, q.r_A), *push, gives=(LEVER, ROD, TOOTH, SIDE))
    _add_drive(f)
    _add_rod(f)


def pin_distance(angle: Expr) -> Expr:
    """Return the distance of the sleeve's pin C from the crank's axis A at a crank angle, from the
    loop A-B-C.
    """
    distance = sp.Dummy("distance")
    A = Point("A")
    B = Point("B", A, Vec(Frame("crank", WORLD, Z, angle), (q.l_AB, S.Zero, S.Zero)))
    rod = displacement(B, Point("C", A, Vec(WORLD, (distance, S.Zero, S.Zero))), WORLD)
    ends = sp.solve(sp.expand(rod.dot(rod)) - q.l_BC**2, distance)
    return next(end for end in ends if end.subs({q.l_AB: 1, q.l_BC: 2, angle: pi / 2}) > 0)


def _add_drive(f: Formulas) -> None:
    """Add the pitch radii for a ratio at a fixed distance of axes, and the link's rotation for one
    of the crank.
    """
    radii = sp.solve([q.r_A + q.r_D - SPAN, q.r_A - q.k * q.r_D], (q.r_A, q.r_D))
    (alpha,) = sp.solve((gear_rate() - 1) * (q.alpha - MESH) - q.theta_Amax, q.alpha)
    steps = (
        let(q.r_A, radii[q.r_A], "both pitch circles touch"),
        let(q.r_D, radii[q.r_D], "both pitch circles touch"),
        let(LIMIT, alpha, "rotation of the crank gear relative to the link"),
        let(LIFT, sp.expand(alpha - MESH), "rotation of the crank gear relative to the link"),
    )
    f.function("drive", (q.k, SPAN, q.gamma, q.theta_Amax), *steps)


def _add_rod(f: Formulas) -> None:
    """Add both rods with which the crank gives a travel in a rotation: the distance of B and C is
    the same after it.

    P cos(angle) + Q sin(angle) = K in the engaged position; the two solutions are symmetric to the
    direction of (P, Q).
    """
    start = sp.Dummy("start", real=True)

    def squared(angle: Expr, distance: Expr) -> Expr:
        return (distance - q.l_AB * cos(angle)) ** 2 + (q.l_AB * sin(angle)) ** 2

    gap = squared(start, q.l_AC) - squared(start - q.theta_Amax, q.l_AC + q.c)
    opened = sp.expand(sp.expand(gap, trig=True))
    opened = sp.expand(
        opened.subs(sin(start) ** 2, 1 - cos(start) ** 2).subs(
            sin(q.theta_Amax) ** 2, 1 - cos(q.theta_Amax) ** 2
        )
    )
    P, Q = opened.coeff(cos(start)), opened.coeff(sin(start))
    K = -sp.expand(opened - P * cos(start) - Q * sin(start))
    if K.has(start):
        raise ValueError("the condition on the rod is not linear in the crank's direction")
    share = K / sqrt(P**2 + Q**2)
    deviation = sp.acos(clip(SHARE, S.NegativeOne, S.One))
    rods = (
        let(
            symbol,
            sqrt(squared(sp.atan2(Q, P) + sign * deviation, q.l_AC)),
            "rod for a travel in a rotation",
        )
        for symbol, sign in zip(RODS, (1, -1), strict=True)
    )
    steps = (let(SHARE, share, "rod for a travel in a rotation"), *rods)
    f.function("rod", q.TABLE.select("l_AB l_AC c theta_Amax"), *steps)
