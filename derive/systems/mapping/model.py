"""Design by kinematic mapping as functions in closed form, with the four-bar linkage of two dyads.

A second hinge of the arm keeps its distance from a second fixed hinge, while the crank, which is the first dyad, turns
by ``theta``; the arm is the coupler of the linkage.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import sympy as sp
from sympy import Expr, S

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, displacement
from ...mechanics.frames import Z as UP
from ...model import Let, System, let
from ...quantity import Quantity, Vector
from . import dyads, train
from . import quantities as q
from .dyads import ARM, MOVING_HINGE, ORIGIN, TIP, WORLD
from .subject import ASSUMPTIONS
from .train import tip


def _linkage(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: four-bar linkage of two dyads")


x_f = _linkage("x_f", "m", "follower's moving hinge in the moving frame, x")
y_f = _linkage("y_f", "m", "follower's moving hinge in the moving frame, y")
X_f = _linkage("X_f", "m", "follower's fixed hinge, X")
Y_f = _linkage("Y_f", "m", "follower's fixed hinge, Y")
L_f = _linkage("L_f", "m", "length of the follower")
CRANK = Vector("crank", (q.x, q.y, q.X_c, q.Y_c, q.L1))
FOLLOWER = Vector("follower", (x_f, y_f, X_f, Y_f, L_f))

u = _linkage("u", "m", "from the crank's moving hinge to the follower's, in the moving frame, x")
v = _linkage("v", "m", "from the crank's moving hinge to the follower's, in the moving frame, y")
U = _linkage("U", "m", "from the crank's fixed hinge to the follower's, X")
V = _linkage("V", "m", "from the crank's fixed hinge to the follower's, Y")
GAPS: dict[Quantity, Expr] = {u: x_f - q.x, v: y_f - q.y, U: X_f - q.X_c, V: Y_f - q.Y_c}
"""Coupler and frame: only they enter the loop, not where the hinges lie."""

of_cos = _linkage("of_cos", "m2", "what cos(phi) is multiplied by in the loop")
of_sin = _linkage("of_sin", "m2", "what sin(phi) is multiplied by in the loop")
alone = _linkage("alone", "m2", "the term of the loop without phi")
closure = _linkage("closure", "m2", "square of the distance that the follower bridges, less the square of its length")
by_theta = _linkage("by_theta", "m2", "derivative of the closure in the angle of the crank")
by_phi = _linkage("by_phi", "m2", "derivative of the closure in the angle of the arm")
across = _linkage("across", "m2", "coupler times follower times the sine of the angle from coupler to follower")
along = _linkage("along", "m2", "coupler times follower times the cosine of the angle from coupler to follower")

FOLLOWED = Point("follower's moving hinge", TIP, Vec(ARM, (x_f, y_f, S.Zero)))
PIVOT = Point("follower's fixed hinge", ORIGIN, Vec(WORLD, (X_f, Y_f, S.Zero)))
COS, SIN = sp.Symbol("COS", real=True), sp.Symbol("SIN", real=True)


def _driven(vector: Vec) -> Vec:
    """The vector where the crank holds the tip, by coupler and frame."""
    by_gaps = {x_f: q.x + u, y_f: q.y + v, X_f: q.X_c + U, Y_f: q.Y_c + V}
    x, y, z = (sp.expand(c.xreplace(tip()).xreplace(by_gaps)) for c in vector.components)
    return Vec(vector.frame, (x, y, z))


@cache
def residual() -> Expr:
    """What vanishes where the follower fits."""
    gap = _driven(displacement(PIVOT, FOLLOWED, WORLD))
    return gap.dot(gap) - L_f**2


@cache
def loop() -> dict[Quantity, Expr]:
    """The closure as ``of_cos cos(phi) + of_sin sin(phi) + alone``."""
    named = residual().subs({sp.cos(q.phi): COS, sp.sin(q.phi): SIN})
    poly = sp.Poly(sp.rem(sp.expand(named), SIN**2 + COS**2 - 1, SIN), COS, SIN)
    first, second, last = (sp.factor_terms(sp.trigsimp(poly.coeff_monomial(m))) for m in (COS, SIN, 1))
    rest = poly - sp.Poly(first * COS + second * SIN + last, COS, SIN)
    if sp.simplify(rest.as_expr()) != 0:
        raise ValueError(f"the loop holds {rest.as_expr()} besides")
    return {of_cos: first, of_sin: second, alone: last}


def closed() -> dict[Quantity, Expr]:
    """The closure and its derivatives."""
    parts = loop()
    expr = parts[of_cos] * sp.cos(q.phi) + parts[of_sin] * sp.sin(q.phi) + parts[alone]
    return {closure: expr, by_theta: expr.diff(q.theta), by_phi: expr.diff(q.phi)}


def transmission() -> dict[Quantity, Expr]:
    """Angle between coupler and follower at the hinge that joins them, by its sine and cosine."""
    coupler = _driven(displacement(MOVING_HINGE, FOLLOWED, WORLD))
    follower = _driven(displacement(PIVOT, FOLLOWED, WORLD))
    return {across: coupler.cross(follower)[2], along: coupler.dot(follower)}


SOURCE = "derived (kinematic mapping)"
Named = Mapping[Quantity, Expr]


def _derived(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: kinematic mapping")


POSE = Vector("pose", (q.d1, q.d2, q.phi))
MAPPED = Vector("image", q.MAPPED)
POINT = Vector("point", (q.x, q.y))
DYAD = Vector("dyad", (q.x, q.y, q.X_c, q.Y_c, q.L1))
PLACES = Vector("places", (q.x, q.y, q.X_c, q.Y_c))
COEFFICIENTS = Vector("coefficients", q.COEFFICIENTS)
BASIS = tuple(Vector(f"v_{name}", of) for name, of in zip(("alpha", "beta", "gamma"), q.BASIS, strict=True))

square = _derived("square", "m2", "square of the distance of moving and fixed hinge, less that of the radius")
normal_X = _derived("normal_X", "m", "normal of a slider's line, X, at the scale of the coefficients")
normal_Y = _derived("normal_Y", "m", "normal of a slider's line, Y, at the scale of the coefficients")
offset = _derived("offset", "m2", "what the normal times a place on the line is, at the scale of the coefficients")

dslope = _derived("dslope", "1", "derivative of the slope in the carrier angle")
ddslope = _derived("ddslope", "1", "second derivative of the slope in the carrier angle")
bend = _derived("bend", "rad", "angle at the middle hinge between the centre lines of the two stages")
CURVATURES = tuple(
    _derived(f"kappa{k}", "1/m", f"curvature of the pitch curve of the {gear}, positive where convex")
    for k, gear in enumerate(q.GEARS, start=1)
)
RADII = (q.r1, q.r2, q.r3, q.r4)


def build_mapping_system() -> System:
    """Everything from a pose to the pitch curves of the train."""
    title = "Design of a gear train by kinematic mapping"
    f = Formulas("mapping_exact", title=title, source=SOURCE, assumptions=ASSUMPTIONS, told="{}_out")
    _of_dyads(f)
    _of_linkages(f)
    _of_train(f)
    return f.system()


def _lets(named: Named, text: str) -> tuple[Let, ...]:
    return tuple(let(symbol, expr, text) for symbol, expr in named.items())


def _of_dyads(f: Formulas) -> None:
    half = q.phi / 2
    image = dict(zip(q.MAPPED, dyads.quaternion(sp.cos(half), sp.sin(half)), strict=True))
    at_pose = dict(zip(q.MAPPED_J, q.MAPPED, strict=True))
    row = {entry: form.xreplace(at_pose) for entry, form in dyads.row().items()}
    hinge = dict(zip((q.X, q.Y), dyads.hinge(), strict=True))
    first, second = dyads.conics()
    f.function("image", (POSE,), *_lets(image, "mapping parameters of a pose"))
    f.function("row", (MAPPED,), *_lets(row, "the circle as a linear form"))
    f.function("conics", BASIS, *_lets({**first, **second}, "conditions on the null space"))
    f.function("dyad", (COEFFICIENTS,), *_lets(dyad_by_coefficients(), "dyad of a vector of the null space"))
    f.function("slider", (COEFFICIENTS,), *_lets(slider_by_coefficients(), "fixed hinge at infinity"))
    f.function("swinging", (COEFFICIENTS,), *_lets(swinging_by_coefficients(), "moving hinge at infinity"))
    f.function("hinge", (POSE, POINT), *_lets(hinge, "moving hinge in the fixed frame"))
    f.function(
        "distance", (POSE, DYAD), *_lets({square: _distance()}, "moving hinge on a circle about the fixed hinge")
    )


def _distance() -> Expr:
    """The circle's equation at unit scale, by the hinges."""
    circle = dyads.circle()
    by_hinges = {name: expr.subs(q.a0, S.One) for name, expr in circle.coefficients.items()}
    X, Y = dyads.hinge()
    gap = -circle.residual.subs(q.a0, S.One).xreplace(by_hinges).xreplace({q.X: X, q.Y: Y})
    squares = (X - q.X_c) ** 2 + (Y - q.Y_c) ** 2 - q.L1**2
    if sp.expand(gap - squares) != 0:
        raise ValueError(f"{gap} is no difference of squares")
    return squares


def dyad_by_coefficients() -> Named:
    """Moving and fixed hinge: the first five coefficients, solved for them."""
    named = dyads.coefficients()
    unknown = [q.a0, q.x, q.y, q.a1, q.a2]
    found = sp.solve([named[p] - p for p in q.COEFFICIENTS[:5]], unknown, dict=True)[0]
    centre = {c: dyads.fixed_hinge()[c].xreplace(found) for c in (q.X_c, q.Y_c)}
    return {q.x: found[q.x], q.y: found[q.y], **centre}


def slider_by_coefficients() -> Named:
    """A moving hinge on a straight line: the circle whose a0 is zero."""
    named = {p: expr.subs(q.a0, S.Zero) for p, expr in dyads.coefficients().items()}
    on_line = dyads.circle().residual.subs(q.a0, S.Zero) / 2
    found = sp.solve([named[p] - p for p in (q.p4, q.p5, q.p6, q.p7, q.p8)], [q.a1, q.a2, q.a3, q.x, q.y], dict=True)[0]
    normal = {name: on_line.coeff(c).xreplace(found) for name, c in ((normal_X, q.X), (normal_Y, q.Y))}
    rest = -on_line.subs({q.X: S.Zero, q.Y: S.Zero}).xreplace(found)
    return {q.x: found[q.x], q.y: found[q.y], **normal, offset: rest}


def swinging_by_coefficients() -> Named:
    """A line of the body through a fixed hinge: the limit in which the moving hinge leaves along the line's normal.

    The same circle is seen from the body: the fixed hinge lies on it, about the moving one.
    """
    circle = dyads.circle().coefficients
    direction = {q.x: q.p2 / q.a0, q.y: q.p3 / q.a0}
    named = {p: expr.xreplace(circle).xreplace(direction) for p, expr in dyads.coefficients().items()}
    limits = [sp.limit(sp.expand(named[p]), q.a0, 0) - p for p in (q.p6, q.p7)]
    centre = sp.solve(limits, [q.X_c, q.Y_c], dict=True)[0]
    (radius,) = sp.solve(named[q.p8] - q.p8, q.L1**2)
    u, v = sp.symbols("u v", real=True)
    seen = sp.expand(((u - direction[q.x]) ** 2 + (v - direction[q.y]) ** 2 - radius) * -q.a0 / 2)
    line = sp.Poly(sp.limit(seen, q.a0, 0), u, v)
    normal = {normal_X: line.coeff_monomial(u), normal_Y: line.coeff_monomial(v)}
    return {**centre, **normal, offset: -line.coeff_monomial(1)}


def _of_linkages(f: Formulas) -> None:
    crank, follower = CRANK, FOLLOWER
    place = {**train.tip(), **_carried()}
    angle, angles = (q.theta,), (q.theta, q.phi)
    f.function("arm", (*angles, crank), *_lets(place, "tip and moving hinge by the angles of carrier and arm"))
    for name, angles_in, closure_terms in (
        ("loop", angle, loop()),
        ("closed", angles, closed()),
        ("transmission", angles, transmission()),
    ):
        steps = (*_lets(GAPS, "coupler and frame"), *_lets(closure_terms, "closed loop"))
        f.function(name, (*angles_in, crank, follower), *steps, gives=closure_terms)


def _carried() -> Named:
    """The moving hinge, by the carrier's angle."""
    held = displacement(dyads.ORIGIN, train.CARRIED_HINGE, dyads.WORLD)
    return {q.X: held[0], q.Y: held[1]}


def _of_train(f: Formulas) -> None:
    ratios: dict[Quantity, Expr] = {q.i: train.ratio_by_slope(), **train.split()}
    radii = {**dict(zip(RADII[:2], train.pitch_radii(q.i1, q.r1), strict=True)),
             **dict(zip(RADII[2:], train.pitch_radii(q.i2, q.r3), strict=True))}  # fmt: skip
    rates = dict(zip(q.POLAR_RATES, train.polar_rates(), strict=True))
    by_slope = {**ratios, **radii, **rates}
    steps = _lets(by_slope, "ratios, pitch radii and rates of the polar angles")
    f.function("gears", (q.slope, q.x_s, q.a), *steps)
    f.function("curvature", (q.slope, dslope, ddslope, q.x_s, q.a), *_lets(_curvatures(by_slope), "curvature"))
    f.function("bend", (q.L1, q.a), let(bend, bend_of_carrier(), "three hinges of the carrier"))


def _curvatures(by_slope: Named) -> Named:
    """Curvature of each pitch curve, its polar angle and radius moving with the carrier angle."""

    def along(expr: Expr) -> Expr:
        while expr.free_symbols & by_slope.keys():
            expr = expr.xreplace(dict(by_slope))
        return expr

    pairs = zip(CURVATURES, RADII, q.POLAR_RATES, strict=True)
    return {name: _curvature(along(radius), along(rate)) for name, radius, rate in pairs}


def _curvature(radius: Expr, rate: Expr) -> Expr:
    """Curvature of the path of a point at ``radius`` in a frame that turns by ``rate``, per carrier angle."""
    psi = sp.Dummy("psi", real=True)
    polar = Frame("polar", dyads.WORLD, UP, psi)
    motion = Motion(rates={psi: rate, q.slope: dslope, dslope: ddslope})
    velocity = motion.derivative(Vec(polar, (radius, S.Zero, S.Zero)))
    turning = velocity.cross(motion.derivative(velocity))[2]
    return turning / sp.sqrt(velocity.dot(velocity)) ** 3


def bend_of_carrier() -> Expr:
    """From the triangle of the carrier's hinges: two sides of one length, the third being the carrier's."""
    angle = sp.Dummy("angle", real=True)
    sides = (Frame("first side", dyads.WORLD), Frame("second side", dyads.WORLD, UP, angle))
    first, second = (Vec(side, (q.a, S.Zero, S.Zero)).resolved(dyads.WORLD) for side in sides)
    gap = first - second
    cosine = sp.Dummy("cosine", real=True)
    (found,) = sp.solve(sp.trigsimp(sp.expand(gap.dot(gap))).subs(sp.cos(angle), cosine) - q.L1**2, cosine)
    return sp.acos(sp.expand(found))


SYSTEMS = (build_mapping_system,)
