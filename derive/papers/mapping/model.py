"""Design by kinematic mapping as functions in closed form, with the four-bar linkage of two dyads.

A second hinge of the arm has a constant distance from a second fixed hinge, while the crank, which
is the first dyad, turns by ``theta``; the arm is the coupler of the linkage.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

import sympy as sp
from sympy import Expr, S

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, displacement
from ...mechanics.frames import Z as UP
from ...model import Let, System, let, let_all
from ...quantity import Quantity, Vector, read_quantities
from . import geometry
from . import quantities as q
from .geometry import ARM, MOVING_HINGE, ORIGIN, TIP, WORLD, tip_position
from .subject import ASSUMPTIONS

_linkage = partial(Quantity, source="derived: four-bar linkage of two dyads")


t = read_quantities(
    """
derived: four-bar linkage of two dyads
x_f | m | follower's moving hinge in the moving frame, x
y_f | m | follower's moving hinge in the moving frame, y
X_f | m | follower's fixed hinge, X
Y_f | m | follower's fixed hinge, Y
L_f | m | length of the follower
u | m | from the crank's moving hinge to the follower's, in the moving frame, x
v | m | from the crank's moving hinge to the follower's, in the moving frame, y
U | m | from the crank's fixed hinge to the follower's, X
V | m | from the crank's fixed hinge to the follower's, Y
of_cos | m2 | factor of cos(phi) in the loop
of_sin | m2 | factor of sin(phi) in the loop
alone | m2 | the term of the loop without phi
closure | m2 | square of the distance between the follower's hinges minus the square of its length
by_theta | m2 | derivative of the closure in the angle of the crank
by_phi | m2 | derivative of the closure in the angle of the arm
across | m2 | coupler times follower times the sine of the angle from coupler to follower
along | m2 | coupler times follower times the cosine of the angle from coupler to follower

derived: kinematic mapping
square | m2 | square of the distance of moving and fixed hinge minus that of the radius
normal_X | m | normal of a slider's line, X, at the scale of the coefficients
normal_Y | m | normal of a slider's line, Y, at the scale of the coefficients
offset | m2 | product of the normal and a point on the line, at the scale of the coefficients
dslope | 1 | derivative of the slope in the carrier angle
ddslope | 1 | second derivative of the slope in the carrier angle
bend | rad | angle at the middle hinge between the centre lines of the two stages
"""
)
"""Quantities of this module."""


CRANK = Vector("crank", q.TABLE.select("x y X_c Y_c L1"))
FOLLOWER = Vector("follower", t.select("x_f y_f X_f Y_f L_f"))


GAPS: dict[Quantity, Expr] = {
    t.u: t.x_f - q.x,
    t.v: t.y_f - q.y,
    t.U: t.X_f - q.X_c,
    t.V: t.Y_f - q.Y_c,
}
"""Vectors of coupler and frame: the loop depends on them, not on the positions of the hinges."""


FOLLOWED = Point("follower's moving hinge", TIP, Vec(ARM, (t.x_f, t.y_f, S.Zero)))
PIVOT = Point("follower's fixed hinge", ORIGIN, Vec(WORLD, (t.X_f, t.Y_f, S.Zero)))
COS, SIN = sp.Symbol("COS", real=True), sp.Symbol("SIN", real=True)


def _constrain_tip(vector: Vec) -> Vec:
    """Return a vector with the tip's position by the crank, in terms of coupler and frame."""
    by_gaps = {t.x_f: q.x + t.u, t.y_f: q.y + t.v, t.X_f: q.X_c + t.U, t.Y_f: q.Y_c + t.V}
    x, y, z = (sp.expand(c.xreplace(tip_position()).xreplace(by_gaps)) for c in vector.components)
    return Vec(vector.frame, (x, y, z))


@cache
def loop_residual() -> Expr:
    """Return the residual of the loop, zero if the follower fits."""
    gap = _constrain_tip(displacement(PIVOT, FOLLOWED, WORLD))
    return gap.dot(gap) - t.L_f**2


@cache
def loop_terms() -> dict[Quantity, Expr]:
    """Return the factors of cos(phi) and sin(phi) in the closure, and its constant term.

    Raises ValueError if the loop has further terms.
    """
    named = loop_residual().subs({sp.cos(q.phi): COS, sp.sin(q.phi): SIN})
    poly = sp.Poly(sp.rem(sp.expand(named), SIN**2 + COS**2 - 1, SIN), COS, SIN)
    first, second, last = (
        sp.factor_terms(sp.trigsimp(poly.coeff_monomial(m))) for m in (COS, SIN, 1)
    )
    rest = poly - sp.Poly(first * COS + second * SIN + last, COS, SIN)
    if sp.simplify(rest.as_expr()) != 0:
        raise ValueError(f"the loop has further terms: {rest.as_expr()}")
    return {t.of_cos: first, t.of_sin: second, t.alone: last}


def loop_closure() -> dict[Quantity, Expr]:
    """Return the closure and its derivatives."""
    terms = loop_terms()
    expr = terms[t.of_cos] * sp.cos(q.phi) + terms[t.of_sin] * sp.sin(q.phi) + terms[t.alone]
    return {t.closure: expr, t.by_theta: expr.diff(q.theta), t.by_phi: expr.diff(q.phi)}


def transmission_angle() -> dict[Quantity, Expr]:
    """Return sine and cosine of the angle between coupler and follower, times both lengths."""
    coupler = _constrain_tip(displacement(MOVING_HINGE, FOLLOWED, WORLD))
    follower = _constrain_tip(displacement(PIVOT, FOLLOWED, WORLD))
    return {t.across: coupler.cross(follower)[2], t.along: coupler.dot(follower)}


SOURCE = "derived (kinematic mapping)"
Named = Mapping[Quantity, Expr]


_derived = partial(Quantity, source="derived: kinematic mapping")


POSE = Vector("pose", (q.d1, q.d2, q.phi))
MAPPED = Vector("image", q.MAPPED)
POINT = Vector("point", (q.x, q.y))
DYAD = Vector("dyad", q.TABLE.select("x y X_c Y_c L1"))
PLACES = Vector("places", q.TABLE.select("x y X_c Y_c"))
COEFFICIENTS = Vector("coefficients", q.COEFFICIENTS)
BASIS = tuple(
    Vector(f"v_{name}", vector)
    for name, vector in zip(("alpha", "beta", "gamma"), q.BASIS, strict=True)
)


CURVATURES = tuple(
    _derived(
        f"kappa{k}", "1/m", f"curvature of the pitch curve of the {gear}, positive where convex"
    )
    for k, gear in enumerate(q.GEARS, start=1)
)
RADII = q.TABLE.select("r1 r2 r3 r4")


def build_mapping_system() -> System:
    """Build the model from a pose to the pitch curves of the train."""
    title = "Design of a gear train by kinematic mapping"
    f = Formulas(
        "mapping_exact", title=title, source=SOURCE, assumptions=ASSUMPTIONS, told="{}_out"
    )
    _add_dyads(f)
    _add_linkages(f)
    _add_train(f)
    return f.system()


def _lets(named: Named, text: str) -> tuple[Let, ...]:
    return let_all(named.keys(), named.values(), text)


def _add_dyads(f: Formulas) -> None:
    half = q.phi / 2
    image = dict(zip(q.MAPPED, geometry.pose_quaternion(sp.cos(half), sp.sin(half)), strict=True))
    at_pose = dict(zip(q.MAPPED_J, q.MAPPED, strict=True))
    row = {entry: form.xreplace(at_pose) for entry, form in geometry.matrix_row().items()}
    hinge = dict(zip((q.X, q.Y), geometry.hinge_by_pose(), strict=True))
    first, second = geometry.conic_coefficients()
    f.function("image", (POSE,), *_lets(image, "mapping parameters of a pose"))
    f.function("row", (MAPPED,), *_lets(row, "the circle as a linear form"))
    f.function("conics", BASIS, *_lets({**first, **second}, "conditions on the null space"))
    f.function(
        "dyad",
        (COEFFICIENTS,),
        *_lets(dyad_by_coefficients(), "dyad of a vector of the null space"),
    )
    f.function(
        "slider", (COEFFICIENTS,), *_lets(slider_by_coefficients(), "fixed hinge at infinity")
    )
    f.function(
        "swinging", (COEFFICIENTS,), *_lets(swinging_by_coefficients(), "moving hinge at infinity")
    )
    f.function("hinge", (POSE, POINT), *_lets(hinge, "moving hinge in the fixed frame"))
    f.function(
        "distance",
        (POSE, DYAD),
        *_lets({t.square: _distance()}, "moving hinge on a circle about the fixed hinge"),
    )


def _distance() -> Expr:
    """Return the circle's equation at unit scale, by the hinges.

    Raises ValueError if it is another one.
    """
    circle = geometry.hinge_circle()
    by_hinges = {name: expr.subs(q.a0, S.One) for name, expr in circle.coefficients.items()}
    X, Y = geometry.hinge_by_pose()
    gap = -circle.residual.subs(q.a0, S.One).xreplace(by_hinges).xreplace({q.X: X, q.Y: Y})
    squares = (X - q.X_c) ** 2 + (Y - q.Y_c) ** 2 - q.L1**2
    if sp.expand(gap - squares) != 0:
        raise ValueError(f"{gap} is not the expected difference of squares")
    return squares


def dyad_by_coefficients() -> Named:
    """Return moving and fixed hinge from the first five coefficients."""
    named = geometry.dyad_coefficients()
    unknown = [q.a0, q.x, q.y, q.a1, q.a2]
    dyad = sp.solve([named[p] - p for p in q.COEFFICIENTS[:5]], unknown, dict=True)[0]
    centre = {c: geometry.fixed_hinge()[c].xreplace(dyad) for c in (q.X_c, q.Y_c)}
    return {q.x: dyad[q.x], q.y: dyad[q.y], **centre}


def slider_by_coefficients() -> Named:
    """Return the dyad of a moving hinge on a straight line: the circle with a0 = 0."""
    named = {p: expr.subs(q.a0, S.Zero) for p, expr in geometry.dyad_coefficients().items()}
    on_line = geometry.hinge_circle().residual.subs(q.a0, S.Zero) / 2
    dyad = sp.solve(
        [named[p] - p for p in q.TABLE.select("p4 p5 p6 p7 p8")],
        [q.a1, q.a2, q.a3, q.x, q.y],
        dict=True,
    )[0]
    normal = {
        name: on_line.coeff(c).xreplace(dyad) for name, c in ((t.normal_X, q.X), (t.normal_Y, q.Y))
    }
    rest = -on_line.subs({q.X: S.Zero, q.Y: S.Zero}).xreplace(dyad)
    return {q.x: dyad[q.x], q.y: dyad[q.y], **normal, t.offset: rest}


def swinging_by_coefficients() -> Named:
    """Return the dyad of a line of the body through a fixed hinge: the moving hinge is at infinity
    on its normal.

    In the body's frame the fixed hinge is on a circle about the moving one.
    """
    circle = geometry.hinge_circle().coefficients
    direction = {q.x: q.p2 / q.a0, q.y: q.p3 / q.a0}
    named = {
        p: expr.xreplace(circle).xreplace(direction)
        for p, expr in geometry.dyad_coefficients().items()
    }
    limits = [sp.limit(sp.expand(named[p]), q.a0, 0) - p for p in (q.p6, q.p7)]
    centre = sp.solve(limits, [q.X_c, q.Y_c], dict=True)[0]
    (radius,) = sp.solve(named[q.p8] - q.p8, q.L1**2)
    u, v = sp.symbols("u v", real=True)
    seen = sp.expand(((u - direction[q.x]) ** 2 + (v - direction[q.y]) ** 2 - radius) * -q.a0 / 2)
    line = sp.Poly(sp.limit(seen, q.a0, 0), u, v)
    normal = {t.normal_X: line.coeff_monomial(u), t.normal_Y: line.coeff_monomial(v)}
    return {**centre, **normal, t.offset: -line.coeff_monomial(1)}


def _add_linkages(f: Formulas) -> None:
    crank, follower = CRANK, FOLLOWER
    positions = {**geometry.tip_position(), **_carried_hinge()}
    angle, angles = (q.theta,), (q.theta, q.phi)
    f.function(
        "arm",
        (*angles, crank),
        *_lets(positions, "tip and moving hinge by the angles of carrier and arm"),
    )
    for name, angles_in, closure_terms in (
        ("loop", angle, loop_terms()),
        ("closed", angles, loop_closure()),
        ("transmission", angles, transmission_angle()),
    ):
        steps = (*_lets(GAPS, "coupler and frame"), *_lets(closure_terms, "closed loop"))
        f.function(name, (*angles_in, crank, follower), *steps, gives=closure_terms)


def _carried_hinge() -> Named:
    """Return the moving hinge, by the carrier's angle."""
    position = displacement(geometry.ORIGIN, geometry.CARRIED_HINGE, geometry.WORLD)
    return {q.X: position[0], q.Y: position[1]}


def _add_train(f: Formulas) -> None:
    ratios: dict[Quantity, Expr] = {q.i: geometry.ratio_by_slope(), **geometry.split_ratios()}
    radii = {
        **dict(zip(RADII[:2], geometry.pitch_radii(q.i1, q.r1), strict=True)),
        **dict(zip(RADII[2:], geometry.pitch_radii(q.i2, q.r3), strict=True)),
    }
    rates = dict(zip(q.POLAR_RATES, geometry.polar_rates(), strict=True))
    by_slope = {**ratios, **radii, **rates}
    steps = _lets(by_slope, "ratios, pitch radii and rates of the polar angles")
    f.function("gears", (q.slope, q.x_s, q.a), *steps)
    f.function(
        "curvature",
        (q.slope, t.dslope, t.ddslope, q.x_s, q.a),
        *_lets(_curvatures(by_slope), "curvature"),
    )
    f.function("bend", (q.L1, q.a), let(t.bend, bend_of_carrier(), "three hinges of the carrier"))


def _curvatures(by_slope: Named) -> Named:
    """Return the curvature of each pitch curve, with polar angle and radius as functions of the
    carrier angle.
    """

    def by_carrier_angle(expr: Expr) -> Expr:
        while expr.free_symbols & by_slope.keys():
            expr = expr.xreplace(dict(by_slope))
        return expr

    pairs = zip(CURVATURES, RADII, q.POLAR_RATES, strict=True)
    return {
        name: _curvature(by_carrier_angle(radius), by_carrier_angle(rate))
        for name, radius, rate in pairs
    }


def _curvature(radius: Expr, rate: Expr) -> Expr:
    """Return the curvature of the path of a point at ``radius`` in a frame with the ``rate`` per
    carrier angle.
    """
    psi = sp.Dummy("psi", real=True)
    polar = Frame("polar", geometry.WORLD, UP, psi)
    motion = Motion(rates={psi: rate, q.slope: t.dslope, t.dslope: t.ddslope})
    velocity = motion.derivative(Vec(polar, (radius, S.Zero, S.Zero)))
    turning = velocity.cross(motion.derivative(velocity))[2]
    return turning / sp.sqrt(velocity.dot(velocity)) ** 3


def bend_of_carrier() -> Expr:
    """Return the angle in the triangle of the carrier's hinges: two sides of one length, and the
    carrier's.
    """
    angle = sp.Dummy("angle", real=True)
    sides = (Frame("first side", geometry.WORLD), Frame("second side", geometry.WORLD, UP, angle))
    first, second = (Vec(side, (q.a, S.Zero, S.Zero)).resolved(geometry.WORLD) for side in sides)
    gap = first - second
    cosine = sp.Dummy("cosine", real=True)
    (solution,) = sp.solve(
        sp.trigsimp(sp.expand(gap.dot(gap))).subs(sp.cos(angle), cosine) - q.L1**2, cosine
    )
    return sp.acos(sp.expand(solution))


SYSTEMS = (build_mapping_system,)
