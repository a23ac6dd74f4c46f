"""Reuleaux pentagon, hexagonal hole, teeth and taper of the clutch (shi2021, figs. 3-6), derived.

The pentagon is held by vertex A on the upper side of the hexagon and vertex B on the next side;
where C then goes follows from closing the loop. Lengths of the path are found for width 1 and
scaled.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import sympy as sp
from sympy import Expr, Matrix, S, cos, pi, sin

from ...formulas import Formulas
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from . import quantities as q

TURN = 2 * pi
VERTICES = 5
SIDES = 6
PLANE = Frame("xOy")
TURNED = Frame("XOY", PLANE, Z, TURN / SIDES)
ALONG_AC = Frame("AC", PLANE, Z, -q.theta)
ALONG_BC = Frame("BC", TURNED, Z, -q.beta)
ARM = (q.R, S.Zero, S.Zero)
O = Point("O")  # noqa: E741
A = Point("A", O, Vec(PLANE, (q.x_A, q.y_A, S.Zero)))
B = Point("B", O, Vec(TURNED, (q.X_B, q.Y_B, S.Zero)))
C_FROM_A = Point("C", A, Vec(ALONG_AC, ARM))
C_FROM_B = Point("C", B, Vec(ALONG_BC, ARM))
C = Point("C", O, Vec(PLANE, (q.x_C, q.y_C, S.Zero)))
POLAR_C, POLAR_A, POLAR_B = S.Zero, 2 * TURN / VERTICES, 3 * TURN / VERTICES
LEAD = sp.Dummy("lead", real=True)
"""beta - theta, and below it half the arc of a diagonal: kept as names, for cos(24 deg) to stay
cos(24 deg).
"""
HALF_ARC = sp.Dummy("half arc", real=True)


def hexagon_apothem(side: Expr) -> Expr:
    """Return the distance of a hexagon's sides from its centre [m]."""
    return side / (2 * sp.tan(pi / SIDES))


def polar_unit_vector(angle: Expr) -> Matrix:
    """Return the unit vector (2,) in a polar direction."""
    return Matrix([cos(angle), sin(angle)])


def chord_direction(start: Expr, end: Expr) -> Expr:
    """Return the direction of the chord between two points of a circle, from the smaller polar
    angle to the greater.
    """
    return (start + end) / 2 + pi / 2


def substitute_angles(expr: Expr) -> Expr:
    """Insert the angles of the pentagon without evaluating their sines and cosines."""
    angles = {LEAD: lead_angle(), HALF_ARC: (POLAR_A - POLAR_C) / 2}

    def fixed(part: Expr) -> bool:
        return isinstance(part, sin | cos) and part.free_symbols <= angles.keys()

    return expr.replace(
        fixed, lambda part: part.func(part.args[0].subs(angles), evaluate=False)
    ).subs(angles)


def pentagon_diagonal(radius: Expr) -> Expr:
    """Return the diagonal of a pentagon with a circumradius: the width of its Reuleaux polygon
    [m].
    """
    return radius * (polar_unit_vector(HALF_ARC) - polar_unit_vector(-HALF_ARC))[1]


def reuleaux_circumradius(width: Expr) -> Expr:
    """Return the circumradius of the pentagon whose Reuleaux polygon has a width [m]."""
    return width / pentagon_diagonal(S.One)


@dataclass(frozen=True)
class VertexPath:
    """The path of C while A and B slide, for width 1 and origin O: centre + cos(theta) u +
    sin(theta) v.
    """

    centre: Matrix
    u: Matrix
    v: Matrix
    side: Expr

    def at(self, theta: Expr) -> Matrix:
        """Return the point at the angle theta."""
        return self.centre + cos(theta) * self.u + sin(theta) * self.v


def lead_angle() -> Expr:
    """Return beta - theta: both diagonals from C belong to one rigid pentagon; XOY is turned."""
    return chord_direction(POLAR_C, POLAR_A) - chord_direction(POLAR_C, POLAR_B) + TURNED.angle


def sliding_coordinate() -> Expr:
    """Return the x of A for which A and B are both on their sides."""
    from_A = displacement(O, C_FROM_A, TURNED)[1]
    from_B = displacement(O, C_FROM_B, TURNED)[1]
    on_sides = {q.y_A: hexagon_apothem(q.a), q.Y_B: hexagon_apothem(q.a), q.beta: q.theta + LEAD}
    (x_A,) = sp.solve((from_A - from_B).subs(on_sides), q.x_A)
    return x_A


def split_by_theta(expr: Expr) -> tuple[Expr, Expr, Expr]:
    """Return the constant part of an expression, and the coefficients of cos(theta) and
    sin(theta).
    """
    opened = expr.expand(trig=True).expand()
    cosine, sine = opened.coeff(cos(q.theta)), opened.coeff(sin(q.theta))
    return sp.expand(opened - cosine * cos(q.theta) - sine * sin(q.theta)), cosine, sine


def hexagon_side() -> Expr:
    """Return the side of the hexagon with opposite sides at a distance of the polygon's width."""
    (side,) = sp.solve(2 * hexagon_apothem(q.a) - q.R, q.a)
    return side


@cache
def derive_vertex_path() -> VertexPath:
    """Return the path of C."""
    on_sides = {q.x_A: sliding_coordinate(), q.y_A: hexagon_apothem(q.a)}
    position = displacement(O, C_FROM_A, PLANE)
    side = hexagon_side().subs(q.R, 1)
    scale = {q.a: side, q.R: S.One}
    x, y = (
        [part.subs(scale).simplify() for part in split_by_theta(position[i].subs(on_sides))]
        for i in (0, 1)
    )
    centre, u, v = (Matrix(pair) for pair in zip(x, y, strict=True))
    return VertexPath(centre, u, v, side)


@dataclass(frozen=True)
class PathEllipse:
    """Centre, squared semi-axes and slope of the major axis."""

    centre: Matrix
    major: Expr
    minor: Expr
    slope: Expr


@cache
def derive_path_ellipse() -> PathEllipse:
    """Return the axes of the path of C: eigenvalues of u u' + v v'."""
    path = derive_vertex_path()
    squares = sp.expand(path.u * path.u.T + path.v * path.v.T)
    form = squares.subs(sin(LEAD) ** 2, 1 - cos(LEAD) ** 2).expand()
    mean = form.trace() / 2
    spread = sp.sqrt(sp.factor(mean**2 - form.det())).replace(
        sp.Abs, lambda e: e * sp.sign(e.subs(LEAD, lead_angle()))
    )
    major, minor = sp.factor(mean + spread), sp.factor(mean - spread)
    return PathEllipse(path.centre, major, minor, sp.factor((major - form[0, 0]) / form[0, 1]))


def tangency_curvature() -> Expr:
    """Return the radius of curvature of the path of C, width 1, where it is tangent to the side:
    x'^2 / |y''|.
    """
    point = derive_vertex_path().at(q.theta)
    (lowest,) = (
        s
        for s in sp.solve(point[1].diff(q.theta), q.theta)
        if point[1].diff(q.theta, 2).subs(q.theta, s) > 0
    )
    dx, ddy = (
        point[0].diff(q.theta).subs(q.theta, lowest),
        point[1].diff(q.theta, 2).subs(q.theta, lowest),
    )
    return dx**2 / sp.Abs(ddy)


def least_fillet() -> Expr:
    """Return the smallest fillet, width 1, on a hexagon of that width that the path of C clears.

    Compared are the extents of path and fillet in directions close to the side's normal, measured
    from the corner's diagonal; both touch the side itself, so that the first derivative decides.
    """
    path, turn, half = derive_path_ellipse(), sp.Dummy("turn"), pi / SIDES
    corner, centre = derive_vertex_path().side, path.centre.norm()
    reach = -centre * cos(turn) + sp.sqrt(path.major * cos(turn) ** 2 + path.minor * sin(turn) ** 2)
    inset = 1 / cos(half)
    missing, gained = corner * cos(turn) - reach, inset * cos(turn) - 1
    return sp.simplify((missing.diff(turn) / gained.diff(turn)).subs(turn, half))


def third_overlap() -> Expr:
    """Return the overlap with the side right of the upper one, width 1: by a vertex there, or on
    the opposite side.
    """
    path, rho = derive_vertex_path(), reuleaux_circumradius(S.One)
    turned = -q.theta - pi - chord_direction(POLAR_C, POLAR_A) + TURN
    centroid = path.at(q.theta) - rho * polar_unit_vector(turned)
    beyond = []
    for polar, normal in (
        (TURN / VERTICES, pi / 2 - TURN / SIDES),
        (-TURN / VERTICES, 3 * pi / 2 - TURN / SIDES),
    ):
        vertex = centroid + rho * polar_unit_vector(turned + polar)
        beyond.append(vertex.dot(polar_unit_vector(normal)) - hexagon_apothem(path.side))
    middle = pi / 2 - lead_angle() / 2
    return sp.Piecewise((beyond[0], sp.Le(q.theta, middle)), (-beyond[1], sp.Gt(q.theta, middle)))


def add_polygon(f: Formulas) -> None:
    """Add the equations of the pentagon in the hexagon: section 2.1 of the paper."""
    from_A, from_B = displacement(O, C_FROM_A, PLANE), displacement(O, C_FROM_B, TURNED)
    turned = displacement(O, C, TURNED)
    rest, cosine, sine = split_by_theta(sliding_coordinate() + q.R * cos(q.theta))
    A1, A2 = (sp.simplify(part / q.R) for part in (sine, cosine))
    oval = derive_path_ellipse()
    intercept = sp.simplify(oval.centre[1] - oval.slope * oval.centre[0])
    eccentric = sp.sqrt((oval.major - oval.minor) / (1 + oval.slope**2))
    f.defines(q.x_C, from_A[0], "vertex C from vertex A, x")
    f.defines(q.y_C, from_A[1], "vertex C from vertex A, y")
    f.defines(q.X_C, from_B[0], "vertex C from vertex B, X")
    f.defines(q.Y_C, from_B[1], "vertex C from vertex B, Y")
    f.defines(q.X_C, turned[0], "coordinates of C in the turned frame, X")
    f.defines(q.Y_C, turned[1], "coordinates of C in the turned frame, Y")
    f.defines(q.beta, q.theta + LEAD, "direction of BC from that of AC")
    f.defines(q.y_A, hexagon_apothem(q.a), "side that A slides on")
    f.defines(q.Y_B, hexagon_apothem(q.a), "side that B slides on")
    f.defines(q.x_A, sliding_coordinate(), "vertex A while A and B slide")
    f.defines(q.x_C, rest + q.R * (q.A1 * sin(q.theta) + q.A2 * cos(q.theta)), "path of C, x")
    f.defines(q.y_C, from_A[1].subs(q.y_A, hexagon_apothem(q.a)), "path of C, y")
    f.defines(q.A1, A1, "coefficient of the sine in the path of C")
    f.defines(q.A2, A2, "coefficient of the cosine in the path of C")
    f.defines(q.a, hexagon_side(), "side of the hexagon that fits the polygon's width")
    f.defines(q.x_E, q.R * oval.centre[0], "centre of the ellipse, x")
    f.defines(q.y_E, q.R * oval.centre[1], "centre of the ellipse, y")
    f.defines(q.x_F, q.R * (oval.centre[0] + eccentric), "focus of the ellipse, x")
    f.defines(q.y_F, oval.slope * q.x_F + q.R * intercept, "line of the foci")
    f.defines(q.s_1, q.R * sp.sqrt(oval.major), "semi-major axis of the ellipse")
    f.defines(q.s_2, q.R * sp.sqrt(oval.minor), "semi-minor axis of the ellipse")
    f.defines(q.rho_C, q.R * tangency_curvature(), "curvature of the path where it leaves the side")
    f.defines(q.e_3, q.R * third_overlap(), "overlap with the third pair of sides")
    f.defines(
        q.rho_t,
        tip_width() * tangency_curvature(),
        "curvature of the tip path where it leaves the flat",
    )
    f.holds("fillet that the tooth tips clear", q.r - tip_width() * least_fillet(), ">=")


def tip_width() -> Expr:
    """Return the distance of the shaft's opposite flats: the smallest width of a tooth tips'
    polygon that can turn.
    """
    return 2 * hexagon_apothem(q.a1)


def face_sine(tip: Expr, flat: Expr) -> Expr:
    """Return the sine of the angle between a tooth's axis and a face, whose line is an apothem from
    the centroid.
    """
    radius, half = Matrix([tip, S.Zero]), sp.Dummy("half")
    face = polar_unit_vector(half)
    distance = radius[0] * face[1] - radius[1] * face[0]
    (sine,) = sp.solve(distance - flat, sin(half))
    return sine


def face_angle() -> Expr:
    """Return the full angle between the faces [rad]."""
    return 2 * sp.asin(face_sine(q.b1, hexagon_apothem(q.a1)))


def add_tooth(f: Formulas) -> None:
    """Add the equations of the teeth on the output shaft: section 2.2."""
    (least_tip,) = sp.solve(pentagon_diagonal(q.b1) - tip_width(), q.b1)
    inset = sp.Dummy("inset")
    (fillet_centre,) = sp.solve(inset * cos(pi / SIDES) - (hexagon_apothem(q.a1) - q.r), inset)
    at_least = face_angle().subs(q.b1, least_tip).subs(HALF_ARC, (POLAR_A - POLAR_C) / 2)
    f.holds("tooth tips go round the shaft", q.b1 - least_tip, ">=")
    f.holds("tooth roots clear the shaft's corners", q.b2 - sp.expand(fillet_centre + q.r), ">=")
    f.defines(q.xi, face_angle(), "angle between the faces of a tooth")
    f.defines(q.xi, sp.simplify(at_least), "angle between the faces at the least tip distance")


def add_taper(f: Formulas) -> None:
    """Add the equations of travel and taper (section 2.3): the outline must clear the sides; the
    sleeve must slide.
    """
    steepness, advance, force = sp.Dummy("tan phi"), sp.Dummy("advance"), sp.Dummy("force")
    free = advance * steepness - (q.b - hexagon_apothem(q.a))
    (travel,), (flattest,) = sp.solve(free, advance), sp.solve(free.subs(advance, q.c), steepness)
    surface = Frame("surface", PLANE, Z, q.phi)
    tangential, normal = Vec(PLANE, (force, S.Zero, S.Zero)).resolved(surface).components[:2]
    friction = q.mu * q.F_N
    margin = sp.expand((tangential - friction.subs(q.F_N, -normal)) / force)
    steepest = -margin.coeff(cos(q.phi)) / margin.coeff(sin(q.phi))
    driving, pressing = (e.subs(force, q.F1 - q.F2) for e in (tangential, -normal))
    f.defines(
        q.b, reuleaux_circumradius(2 * hexagon_apothem(q.a)), "largest outline radius of the body"
    )
    f.defines(q.c_min, travel.subs(steepness, sp.tan(q.phi)), "least travel of the sleeve")
    f.holds("travel of the sleeve", q.c - q.c_min, ">=", named=True)
    f.holds("sleeve slides along the taper", driving - q.f, ">=")
    f.holds("sleeve on the taper, force across it", pressing - q.F_N)
    f.defines(q.f, friction, "friction of body and sleeve")
    f.defines(q.phi, sp.atan((q.R1 - q.R2) / q.d), "axial angle from the outline radii")
    f.holds(
        "material between tooth roots and outline", (q.R1 - q.R2) / q.d - (q.R1 - q.b2) / q.d, "<"
    )
    f.holds("least axial angle for a travel", sp.atan(flattest) - q.phi, "<=")
    f.holds("largest axial angle at which the sleeve slides", q.phi - sp.atan(steepest), "<=")
