"""Control linkage, engagement and slip of the clutch (shi2021, figs. 7-10), derived.

The arc rack is fixed and centred at the hinge D of the link; the link carries the crank gear. The output shaft is a
beam that overhangs its bearing and bends in one assumed mode; body and shaft end move together while they touch.
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Derivative, Expr, Function, S, cos, pi, sin
from sympy.calculus.euler import euler_equations

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, Z, displacement
from . import quantities as q
from .geometry import SIDES
from .vocabulary import ClutchClaim

WORLD = Frame("frame")
LINK = Frame("link", WORLD, Z, q.alpha)
GEAR = Frame("crank gear", WORLD, Z, q.theta_A)
D = Point("D")
AXIS = Point("A", D, Vec(LINK, (q.r_D + q.r_A, S.Zero, S.Zero)))
MESH = pi / 2 - q.gamma
"""Inclination of the link at which mesh begins."""

SURFACE = Frame("surface", WORLD, Z, -q.theta0)
"""The engaging surface: F_x pulls along it and presses on, F_y presses on and pushes back."""


def gear_rate() -> Expr:
    """Turns of the crank gear per turn of the link: the gear rolls on the fixed rack, its contact point is at rest."""
    turning = sp.Dummy("rate")
    motion = Motion(rates={q.alpha: S.One, q.theta_A: turning})
    axis = motion.derivative(displacement(D, AXIS, LINK))
    to_contact = Vec(LINK, (-q.r_A, S.Zero, S.Zero))
    contact = axis + motion.spin(GEAR).resolved(LINK).cross(to_contact)
    (rate,) = sp.solve(contact[1], turning)
    return sp.expand(rate.subs(q.r_A, q.k * q.r_D))


def turned(rate: Expr) -> Expr:
    """Rotation for an inclination of the link, at a constant rate: none before mesh."""
    angle = sp.Dummy("angle")
    rotation = rate * sp.integrate(1, (angle, MESH, q.alpha))
    return sp.Piecewise((S.Zero, sp.Lt(q.alpha, MESH)), (rotation, sp.Ge(q.alpha, MESH)))


def crank_angle(distance: Expr) -> Expr:
    """Angle between crank AB and guide AC for a distance AC: the loop A-B-C closes."""
    angle = sp.Dummy("angle")
    crank = Frame("crank", WORLD, Z, angle)
    A = Point("A")
    B = Point("B", A, Vec(crank, (q.l_AB, S.Zero, S.Zero)))
    C = Point("C", A, Vec(WORLD, (distance, S.Zero, S.Zero)))
    rod = displacement(B, C, WORLD)
    square = sp.expand(rod.dot(rod)).subs(sin(angle) ** 2, 1 - cos(angle) ** 2)
    (cosine,) = sp.solve(sp.expand(square) - q.l_BC**2, cos(angle))
    return sp.acos(cosine)


def linkage(f: Formulas) -> None:
    """Crank gear, rack and crank slider: section 2.4."""
    rate = gear_rate()
    teeth = 2 * q.r_A / q.m
    f.defines(q.theta_A, turned(rate), ClutchClaim.CRANK_GEAR)
    f.defines(q.theta_AR, turned(rate - 1), ClutchClaim.CRANK_GEAR_ON_LINK)
    f.defines(q.theta_Amax, q.n * 2 * pi / teeth, ClutchClaim.CRANK_BY_TEETH)
    f.defines(q.theta_Amax, crank_angle(q.l_AC) - crank_angle(q.l_AC + q.c), ClutchClaim.CRANK_BY_TRAVEL)
    f.defines(q.t_c, travel_time(), ClutchClaim.SWITCHING_TIME, named=True)


def travel_time() -> Expr:
    """Time after which the sleeve, at its mean speed, has made its travel."""
    time = sp.Dummy("time")
    (found,) = sp.solve(sp.integrate(q.v_c, (time, 0, time)) - q.c, time)
    return found


def equations_of_motion() -> tuple[Expr, Expr]:
    """Stationary action of a beam under a load N at x = l, and of the body that is pushed and gives this load."""
    x, t = sp.symbols("x t", real=True)
    beam, body = Function("beam")(x, t), Function("body")(t)
    bending = q.E * q.I * beam.diff(x, 2) ** 2 / 2
    density = q.rho * q.S * beam.diff(t) ** 2 / 2 - bending + q.N * q.delta_l * beam
    action = q.m1 * body.diff(t) ** 2 / 2 + (q.F_M - q.N) * body
    (of_beam,), (of_body,) = euler_equations(density, [beam], [x, t]), euler_equations(action, [body], [t])
    named = {
        Derivative(beam, (x, 4)): q.y_4x,
        Derivative(beam, (t, 2)): q.a_x,
        Derivative(body, (t, 2)): q.a_l,
    }
    return -of_beam.lhs.subs(named), of_body.lhs.subs(named)


def mode() -> Expr:
    """The assumed shape: a sine from the bearing with its first crest at the contact, of height 1 there."""
    wave = sp.Dummy("wave", positive=True)
    crest = min(s for s in sp.solve(cos(wave), wave) if s > 0)
    return sin(crest * q.x / q.l)


@cache
def modal() -> tuple[Expr, Expr]:
    """Mass and stiffness of the shaft in its mode: the beam's equation projected on the shape."""
    span = sp.Dummy("span", positive=True)
    shape = mode().subs(q.l, span)
    mass = sp.integrate(q.rho * q.S * shape**2, (q.x, 0, span))
    stiffness = sp.integrate(q.E * q.I * shape.diff(q.x, 4) * shape, (q.x, 0, span))
    return mass.subs(span, q.l), stiffness.subs(span, q.l)


@cache
def contact_motion() -> Expr:
    """Deflection at the contact over time: (M_1 + m1) y'' + K_1 y = F_M, from rest in place, with the body's speed."""
    time, frequency = sp.Symbol("time", real=True), sp.Symbol("frequency", positive=True)
    deflection = Function("deflection")
    motion = sp.Eq(deflection(time).diff(time, 2) + frequency**2 * deflection(time), q.B2)
    start = {deflection(0): 0, deflection(time).diff(time).subs(time, 0): q.Delta_omega * q.r1}
    return sp.expand(sp.dsolve(motion, deflection(time), ics=start).rhs).subs({time: q.t, frequency: q.B1})


def contact_speed() -> Expr:
    """Speed of the contact point of the body as seen from the output shaft."""
    angle = sp.Dummy("angle")
    arm = Vec(Frame("body", WORLD, Z, angle), (q.r1, S.Zero, S.Zero))
    return Motion(rates={angle: q.Delta_omega}).derivative(arm)[1]


def common_speed() -> Expr:
    """Speed at which body and shaft leave the impact together: it keeps the momentum that the body alone brings."""
    speed, (mass, _) = sp.Dummy("speed"), modal()
    brought = q.m1 * contact_speed()
    (found,) = sp.solve((q.m1 + mass) * speed - brought, speed)
    return found


def held_at_bearing(deflection: Expr) -> dict[str, Expr]:
    """What must vanish at the bearing: the deflection, and what is left of the moments there.

    The virtual work of bending leaves -E I y'' on the slope at x = 0, and a bearing of the stiffness k against turning
    adds k y': k y' = E I y''. With the fixity c = k l/(k l + E I) this is c y' = (1 - c) l y'', of a clamped end where
    c is 1, of a hinged one where c is 0, of an elastic one between.
    """
    slope, curvature = (deflection.diff(q.x, order).subs(q.x, 0) for order in (1, 2))
    return {
        "deflection at the bearing": deflection.subs(q.x, 0),
        "slope at the bearing": q.fixity * slope - (1 - q.fixity) * q.l * curvature,
    }


def engagement(f: Formulas) -> None:
    """Contact of tooth and output shaft: section 3.1."""
    of_beam, of_body = equations_of_motion()
    mass, stiffness = modal()
    section = sp.Polygon(*sp.RegularPolygon((0, 0), 1, SIDES).vertices)
    moving = (mass + q.m1).subs(q.rho, q.m2 / (q.S * q.l))
    shape, path = mode(), contact_motion()
    acceleration = path.diff(q.t, 2)
    load = sp.expand(sp.solve(of_body.subs(q.a_l, acceleration), q.N)[0])
    swing = load.coeff(sin(q.B1 * q.t)) ** 2 + load.coeff(cos(q.B1 * q.t)) ** 2
    frequency, push = sp.sqrt(stiffness / moving), q.F_M / moving
    inside = sp.expand(swing / q.m1**2).subs(q.B1, frequency).subs(q.B2, push)
    f.holds(ClutchClaim.BODY_FORCE, of_body)
    f.holds(ClutchClaim.SHAFT_FORCE, of_beam)
    f.defines(q.v_0, contact_speed(), ClutchClaim.CONTACT_SPEED)
    f.defines(q.v_0, common_speed(), ClutchClaim.COMMON_SPEED)
    f.defines(q.y, q.y_max * shape, ClutchClaim.MODAL_DEFLECTION)
    f.defines(q.y, path * shape, ClutchClaim.SHAFT_DEFLECTION)
    f.defines(q.y_max, path, ClutchClaim.CONTACT_DEFLECTION)
    f.defines(q.S, section.area * q.a1**2, ClutchClaim.SHAFT_SECTION)
    f.defines(q.I, section.second_moment_of_area()[0] * q.a1**4, ClutchClaim.SECOND_MOMENT)
    f.defines(q.M_1, mass, ClutchClaim.MODAL_MASS)
    f.defines(q.K_1, stiffness, ClutchClaim.MODAL_STIFFNESS)
    f.defines(q.m2, q.rho * q.S * q.l, ClutchClaim.OVERHANG_MASS)
    f.defines(q.B1, frequency, ClutchClaim.CONTACT_FREQUENCY)
    f.defines(q.B2, push, ClutchClaim.DRIVING_ACCELERATION)
    f.defines(q.a_l, acceleration, ClutchClaim.CONTACT_ACCELERATION)
    f.defines(q.a_x, acceleration * shape, ClutchClaim.SHAFT_ACCELERATION)
    f.defines(q.y_4x, path * shape.diff(q.x, 4), ClutchClaim.FOURTH_DERIVATIVE)
    f.defines(q.delta_l, q.rho * q.S * shape / mass, ClutchClaim.MODAL_DELTA)
    f.defines(q.N, load, ClutchClaim.CONTACT_LOAD)
    f.defines(q.N_max, q.F_M + q.m1 * sp.sqrt(inside), ClutchClaim.LARGEST_LOAD)


def slip(f: Formulas) -> None:
    """Forces on the tooth along the surface and across it: section 3.2."""
    reaction = Vec(WORLD, (q.F_x, q.F_y, S.Zero)).resolved(SURFACE)
    contact = Vec(SURFACE, (-q.f0, -q.N, S.Zero))
    total = reaction + contact
    inertia = q.m1 * q.a0
    (pull,) = sp.solve(total[1], q.F_x)
    (acceleration,) = sp.solve(total[0].subs(q.F_x, pull) - inertia, q.a0)
    acceleration = sp.trigsimp(sp.simplify(acceleration))
    at_rest = contact.resolved(WORLD)[1] + q.F_y
    (threshold,) = sp.solve(at_rest, q.N)
    f.holds(ClutchClaim.TOOTH_ACROSS, q.N - reaction[1])
    f.holds(ClutchClaim.TOOTH_ALONG, total[0] - inertia)
    f.defines(q.a0, acceleration, ClutchClaim.SLIP_ACCELERATION)
    f.holds(ClutchClaim.SLIP_LOAD, q.N - sp.expand(threshold), ">")
    f.holds(ClutchClaim.TOOTH_AT_REST, q.F_y - (q.F_y - at_rest))
