"""Reuleaux pentagon, hexagonal hole, teeth and taper of the clutch (shi2021, figs. 3-6), derived.

The pentagon is held by vertex A on the upper side of the hexagon and vertex B on the next side; where C then goes
follows from closing the loop. Lengths of the path are found for width 1 and scaled.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import sympy as sp
from sympy import Expr, Matrix, S, cos, pi, sin

from ...formulas import Formulas
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from . import quantities as q
from .quantities import ClutchClaim

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
"""beta - theta, and below it half the arc of a diagonal: kept as names, for cos(24 deg) to stay cos(24 deg)."""
HALF_ARC = sp.Dummy("half arc", real=True)


def apothem(side: Expr) -> Expr:
    """Distance of a hexagon's sides from its centre."""
    return side / (2 * sp.tan(pi / SIDES))


def radial(angle: Expr) -> Matrix:
    return Matrix([cos(angle), sin(angle)])


def chord_direction(start: Expr, end: Expr) -> Expr:
    """Direction of the chord between two points of a circle, from the smaller polar angle to the greater."""
    return (start + end) / 2 + pi / 2


def with_angles(expr: Expr) -> Expr:
    """Put in the angles of the pentagon; sines and cosines of them stay as they are."""
    angles = {LEAD: lead(), HALF_ARC: (POLAR_A - POLAR_C) / 2}

    def fixed(part: Expr) -> bool:
        return isinstance(part, sin | cos) and part.free_symbols <= angles.keys()

    return expr.replace(fixed, lambda part: part.func(part.args[0].subs(angles), evaluate=False)).subs(angles)


def diagonal(circumradius: Expr) -> Expr:
    """Diagonal of the pentagon, between points half an arc to both sides: the width of its Reuleaux polygon."""
    return circumradius * (radial(HALF_ARC) - radial(-HALF_ARC))[1]


def circumradius(width: Expr) -> Expr:
    return width / diagonal(S.One)


@dataclass(frozen=True)
class VertexPath:
    """How C moves while A and B slide, for width 1 and origin O: centre + cos(theta) u + sin(theta) v."""

    centre: Matrix
    u: Matrix
    v: Matrix
    side: Expr

    def at(self, theta: Expr) -> Matrix:
        return self.centre + cos(theta) * self.u + sin(theta) * self.v


def lead() -> Expr:
    """beta - theta: both diagonals from C belong to one rigid pentagon; XOY is turned."""
    return chord_direction(POLAR_C, POLAR_A) - chord_direction(POLAR_C, POLAR_B) + TURNED.angle


def closed_loop() -> Expr:
    """x of A for which A and B are both on their sides."""
    from_A = displacement(O, C_FROM_A, TURNED)[1]
    from_B = displacement(O, C_FROM_B, TURNED)[1]
    on_sides = {q.y_A: apothem(q.a), q.Y_B: apothem(q.a), q.beta: q.theta + LEAD}
    (found,) = sp.solve((from_A - from_B).subs(on_sides), q.x_A)
    return found


def split(expr: Expr) -> tuple[Expr, Expr, Expr]:
    """Parts of an expression without theta, with cos(theta), with sin(theta)."""
    opened = expr.expand(trig=True).expand()
    cosine, sine = opened.coeff(cos(q.theta)), opened.coeff(sin(q.theta))
    return sp.expand(opened - cosine * cos(q.theta) - sine * sin(q.theta)), cosine, sine


def width_side() -> Expr:
    """Side of the hexagon whose opposite sides are the polygon's width apart."""
    (found,) = sp.solve(2 * apothem(q.a) - q.R, q.a)
    return found


@cache
def vertex_path() -> VertexPath:
    held = {q.x_A: closed_loop(), q.y_A: apothem(q.a)}
    place = displacement(O, C_FROM_A, PLANE)
    side = width_side().subs(q.R, 1)
    scale = {q.a: side, q.R: S.One}
    x, y = ([part.subs(scale).simplify() for part in split(place[i].subs(held))] for i in (0, 1))
    centre, u, v = (Matrix(pair) for pair in zip(x, y, strict=True))
    return VertexPath(centre, u, v, side)


@dataclass(frozen=True)
class Ellipse:
    """Centre, squared semi-axes and slope of the major axis."""

    centre: Matrix
    major: Expr
    minor: Expr
    slope: Expr


@cache
def ellipse() -> Ellipse:
    """Axes of the path of C: eigenvalues of u u' + v v'."""
    path = vertex_path()
    squares = sp.expand(path.u * path.u.T + path.v * path.v.T)
    form = squares.subs(sin(LEAD) ** 2, 1 - cos(LEAD) ** 2).expand()
    mean = form.trace() / 2
    spread = sp.sqrt(sp.factor(mean**2 - form.det())).replace(sp.Abs, lambda e: e * sp.sign(e.subs(LEAD, lead())))
    major, minor = sp.factor(mean + spread), sp.factor(mean - spread)
    return Ellipse(path.centre, major, minor, sp.factor((major - form[0, 0]) / form[0, 1]))


def tangency_curvature() -> Expr:
    """Radius of curvature of the path of C, width 1, where it runs along the side: x'^2 / |y''|."""
    point = vertex_path().at(q.theta)
    (lowest,) = (s for s in sp.solve(point[1].diff(q.theta), q.theta) if point[1].diff(q.theta, 2).subs(q.theta, s) > 0)
    dx, ddy = point[0].diff(q.theta).subs(q.theta, lowest), point[1].diff(q.theta, 2).subs(q.theta, lowest)
    return dx**2 / sp.Abs(ddy)


def least_fillet() -> Expr:
    """Least fillet, width 1, on a hexagon of that width which the path of C clears.

    Reach of path and fillet in the directions next to the side's normal, measured from the corner's diagonal; both
    reach the side itself, so the first difference decides.
    """
    path, turn, half = ellipse(), sp.Dummy("turn"), pi / SIDES
    corner, centre = vertex_path().side, path.centre.norm()
    reach = -centre * cos(turn) + sp.sqrt(path.major * cos(turn) ** 2 + path.minor * sin(turn) ** 2)
    inset = 1 / cos(half)
    lacking, gained = corner * cos(turn) - reach, inset * cos(turn) - 1
    return sp.simplify((lacking.diff(turn) / gained.diff(turn)).subs(turn, half))


def third_overlap() -> Expr:
    """Overlap with the side right of the upper one, width 1: by a vertex on it, or by the one on the opposite side."""
    path, rho = vertex_path(), circumradius(S.One)
    turned = -q.theta - pi - chord_direction(POLAR_C, POLAR_A) + TURN
    centroid = path.at(q.theta) - rho * radial(turned)
    beyond = []
    for polar, normal in ((TURN / VERTICES, pi / 2 - TURN / SIDES), (-TURN / VERTICES, 3 * pi / 2 - TURN / SIDES)):
        vertex = centroid + rho * radial(turned + polar)
        beyond.append(vertex.dot(radial(normal)) - apothem(path.side))
    middle = pi / 2 - lead() / 2
    return sp.Piecewise((beyond[0], sp.Le(q.theta, middle)), (-beyond[1], sp.Gt(q.theta, middle)))


def polygon(f: Formulas) -> None:
    """Pentagon in the hexagon: sections 2.1 of the paper."""
    from_A, from_B = displacement(O, C_FROM_A, PLANE), displacement(O, C_FROM_B, TURNED)
    turned = displacement(O, C, TURNED)
    rest, cosine, sine = split(closed_loop() + q.R * cos(q.theta))
    A1, A2 = (sp.simplify(part / q.R) for part in (sine, cosine))
    oval = ellipse()
    intercept = sp.simplify(oval.centre[1] - oval.slope * oval.centre[0])
    eccentric = sp.sqrt((oval.major - oval.minor) / (1 + oval.slope**2))
    f.defines(q.x_C, from_A[0], ClutchClaim.C_FROM_A_X)
    f.defines(q.y_C, from_A[1], ClutchClaim.C_FROM_A_Y)
    f.defines(q.X_C, from_B[0], ClutchClaim.C_FROM_B_X)
    f.defines(q.Y_C, from_B[1], ClutchClaim.C_FROM_B_Y)
    f.defines(q.X_C, turned[0], ClutchClaim.C_TURNED_X)
    f.defines(q.Y_C, turned[1], ClutchClaim.C_TURNED_Y)
    f.defines(q.beta, q.theta + LEAD, ClutchClaim.DIRECTION_BC)
    f.defines(q.y_A, apothem(q.a), ClutchClaim.SIDE_OF_A)
    f.defines(q.Y_B, apothem(q.a), ClutchClaim.SIDE_OF_B)
    f.defines(q.x_A, closed_loop(), ClutchClaim.A_SLIDING)
    f.defines(q.x_C, rest + q.R * (q.A1 * sin(q.theta) + q.A2 * cos(q.theta)), ClutchClaim.PATH_X)
    f.defines(q.y_C, from_A[1].subs(q.y_A, apothem(q.a)), ClutchClaim.PATH_Y)
    f.defines(q.A1, A1, ClutchClaim.PATH_SINE)
    f.defines(q.A2, A2, ClutchClaim.PATH_COSINE)
    f.defines(q.a, width_side(), ClutchClaim.HEXAGON_SIDE)
    f.defines(q.x_E, q.R * oval.centre[0], ClutchClaim.ELLIPSE_CENTRE_X)
    f.defines(q.y_E, q.R * oval.centre[1], ClutchClaim.ELLIPSE_CENTRE_Y)
    f.defines(q.x_F, q.R * (oval.centre[0] + eccentric), ClutchClaim.FOCUS_X)
    f.defines(q.y_F, oval.slope * q.x_F + q.R * intercept, ClutchClaim.FOCI_LINE)
    f.defines(q.s_1, q.R * sp.sqrt(oval.major), ClutchClaim.SEMI_MAJOR_AXIS)
    f.defines(q.s_2, q.R * sp.sqrt(oval.minor), ClutchClaim.SEMI_MINOR_AXIS)
    f.defines(q.rho_C, q.R * tangency_curvature(), ClutchClaim.PATH_CURVATURE)
    f.defines(q.e_3, q.R * third_overlap(), ClutchClaim.THIRD_OVERLAP)
    f.defines(q.rho_t, tip_width() * tangency_curvature(), ClutchClaim.TIP_PATH_CURVATURE)
    f.holds(ClutchClaim.FILLET, q.r - tip_width() * least_fillet(), ">=")


def tip_width() -> Expr:
    """Distance between the shaft's opposite flats: width of the tooth tips' polygon that just goes round."""
    return 2 * apothem(q.a1)


def face_sine(tip: Expr, flat: Expr) -> Expr:
    """Sine of the angle between a tooth's axis and a face: its line passes the centroid at the apothem of the shaft."""
    radius, half = Matrix([tip, S.Zero]), sp.Dummy("half")
    face = radial(half)
    distance = radius[0] * face[1] - radius[1] * face[0]
    (sine,) = sp.solve(distance - flat, sin(half))
    return sine


def face_angle() -> Expr:
    """Full angle between the faces."""
    return 2 * sp.asin(face_sine(q.b1, apothem(q.a1)))


def tooth(f: Formulas) -> None:
    """Teeth on the output shaft: section 2.2."""
    (least_tip,) = sp.solve(diagonal(q.b1) - tip_width(), q.b1)
    inset = sp.Dummy("inset")
    (fillet_centre,) = sp.solve(inset * cos(pi / SIDES) - (apothem(q.a1) - q.r), inset)
    at_least = face_angle().subs(q.b1, least_tip).subs(HALF_ARC, (POLAR_A - POLAR_C) / 2)
    f.holds(ClutchClaim.TIP_DISTANCE, q.b1 - least_tip, ">=")
    f.holds(ClutchClaim.ROOT_DISTANCE, q.b2 - sp.expand(fillet_centre + q.r), ">=")
    f.defines(q.xi, face_angle(), ClutchClaim.FACE_ANGLE)
    f.defines(q.xi, sp.simplify(at_least), ClutchClaim.LEAST_TIP_FACE_ANGLE)


def taper(f: Formulas) -> None:
    """Travel and taper: section 2.3. The outline circle must come free of the sides; the sleeve must slide."""
    steepness, advance, force = sp.Dummy("tan phi"), sp.Dummy("advance"), sp.Dummy("force")
    free = advance * steepness - (q.b - apothem(q.a))
    (travel,), (flattest,) = sp.solve(free, advance), sp.solve(free.subs(advance, q.c), steepness)
    surface = Frame("surface", PLANE, Z, q.phi)
    along, across = Vec(PLANE, (force, S.Zero, S.Zero)).resolved(surface).components[:2]
    friction = q.mu * q.F_N
    margin = sp.expand((along - friction.subs(q.F_N, -across)) / force)
    steepest = -margin.coeff(cos(q.phi)) / margin.coeff(sin(q.phi))
    along, pressing = (e.subs(force, q.F1 - q.F2) for e in (along, -across))
    f.defines(q.b, circumradius(2 * apothem(q.a)), ClutchClaim.OUTLINE_RADIUS)
    f.defines(q.c_min, travel.subs(steepness, sp.tan(q.phi)), ClutchClaim.LEAST_TRAVEL)
    f.holds(ClutchClaim.TRAVEL, q.c - q.c_min, ">=", named=True)
    f.holds(ClutchClaim.SLEEVE_SLIDES, along - q.f, ">=")
    f.holds(ClutchClaim.SLEEVE_ACROSS, pressing - q.F_N)
    f.defines(q.f, friction, ClutchClaim.SLEEVE_FRICTION)
    f.defines(q.phi, sp.atan((q.R1 - q.R2) / q.d), ClutchClaim.AXIAL_ANGLE)
    f.holds(ClutchClaim.WALL, (q.R1 - q.R2) / q.d - (q.R1 - q.b2) / q.d, "<")
    f.holds(ClutchClaim.LEAST_AXIAL_ANGLE, sp.atan(flattest) - q.phi, "<=")
    f.holds(ClutchClaim.LARGEST_AXIAL_ANGLE, q.phi - sp.atan(steepest), "<=")
