"""Any odd Reuleaux polygon in any regular polygon, derived: shape, vertex path, support function,
harmonics.

As in the clutch (`geometry`), vertex A slides on the upper side, vertex B on the next one
counter-clockwise and C is the vertex opposite to both; the numbers of vertices and sides and the
distance of the sides are free.
"""

from __future__ import annotations

from functools import partial

import sympy as sp
from sympy import Expr, Matrix, S, cos, pi, sin, sqrt

from ...formulas import Formulas
from ...functions import switch, wrap
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from ...model import Let, System, let, let_all
from ...quantity import Quantity, Vector
from .geometry import chord_direction, polar_unit_vector

ASSUMPTIONS = (
    "rigid polygons, no clearance",
    "vertices A and B stay on their sides while C passes a corner",
)


_rotor = partial(Quantity, source="derived: rotor")


WIDTH = _rotor("width", "m", "constant width of the Reuleaux polygon")
APOTHEM = _rotor("apothem", "m", "distance of the sides from the centre of the regular polygon")
VERTICES = _rotor("vertices", "1", "vertices of the Reuleaux polygon, odd")
SIDES = _rotor("sides", "1", "sides of the regular polygon")
SHAPE = Vector("shape", (WIDTH, APOTHEM, VERTICES, SIDES))

ARC = _rotor("arc", "rad", "angle of an arc, seen from the vertex at its centre")
TURN = _rotor("turn", "rad", "angle between the normals of two neighbouring sides")
LEAD = _rotor("lead", "rad", "rotation of the polygon while C passes a corner")
RHO = _rotor("circumradius", "m", "distance of the vertices from the centroid")
THETA = _rotor("theta", "rad", "direction of AC below +x")
PSI = _rotor("psi", "rad", "direction of a normal, from that of a vertex")
INSIDE = _rotor("inside", "rad", "direction of the normal from that of the nearest vertex")
ORDER = _rotor("order", "1", "order of a harmonic in units of the number of vertices")
PLACES = tuple(
    _rotor(f"{axis}_{point}", "m", f"{meaning}, {axis}")
    for point, meaning in (
        ("A", "vertex A"),
        ("B", "vertex B"),
        ("C", "vertex C"),
        ("M", "centroid"),
    )
    for axis in ("x", "y")
)
ROTATION = _rotor("rotation", "rad", "direction of the polar axis of the polygon")
SPREAD = _rotor("spread", "rad", "angle between the normals of the two sides that A and B slide on")
POLES = tuple(
    _rotor(f"polar_{p}", "rad", f"polar angle of vertex {p} in the polygon") for p in "ABC"
)
TRAMMEL = Vector("trammel", (RHO, APOTHEM, SPREAD, *POLES))
CENTRE = (
    _rotor("x_E", "m", "centre of the ellipse, x"),
    _rotor("y_E", "m", "centre of the ellipse, y"),
)
COSINE = _rotor("cosine_x", "1", "share of R cos(theta) in x_C")
SINE = _rotor("sine_x", "1", "share of R sin(theta) in x_C")
MAJOR = _rotor("s_1", "m", "semi-major axis of the ellipse")
MINOR = _rotor("s_2", "m", "semi-minor axis of the ellipse")
AXIS = _rotor("axis", "rad", "direction of the major axis")
TANGENCY = _rotor("tangency", "m", "radius of curvature of the path where it is tangent to a side")
FILLET = _rotor(
    "fillet", "m", "smallest corner radius that the path of C clears, sides a width apart"
)
SUPPORT = _rotor("support", "m", "distance of the tangent with a normal from the centroid")
RADIUS = _rotor("radius", "m", "radius of curvature of the outline at a normal")
HARMONIC = _rotor("harmonic", "m", "amplitude of a harmonic of the support function")

PLANE = Frame("xOy")
TURNED = Frame("XOY", PLANE, Z, TURN)
OPPOSITE = pi - pi / VERTICES
"""Polar angle of a vertex at the end of the arc opposite to C, which lies at 0."""


def _shape() -> tuple[Let, ...]:
    """Return the angles of both polygons, and the circumradius from the width, the distance of
    opposite vertices.
    """
    vertex, ahead = polar_unit_vector(S.Zero), polar_unit_vector(OPPOSITE)
    diagonal = sqrt(sp.trigsimp((vertex - ahead).dot(vertex - ahead)))
    lead = chord_direction(S.Zero, OPPOSITE) - chord_direction(S.Zero, 2 * pi - OPPOSITE) + TURN
    return (
        let(ARC, chord_direction(S.Zero, 2 * pi - OPPOSITE) - chord_direction(S.Zero, OPPOSITE)),
        let(TURN, 2 * pi / SIDES),
        let(LEAD, sp.expand(lead).subs(pi / VERTICES, ARC)),
        let(RHO, WIDTH / diagonal),
    )


def _loop() -> tuple[Point, Point, Point, Expr]:
    """Return A, B, C and the x of A, with A and B on their sides: C is the same point from both."""
    x_A, arm = sp.Dummy("x_A", real=True), (WIDTH, S.Zero, S.Zero)
    O = Point("O")  # noqa: E741
    A = Point("A", O, Vec(PLANE, (x_A, APOTHEM, S.Zero)))
    C = Point("C", A, Vec(Frame("AC", PLANE, Z, -THETA), arm))
    B = Point("B", C, -Vec(Frame("BC", TURNED, Z, -THETA - LEAD), arm))
    (solution,) = sp.solve(displacement(O, B, TURNED)[1] - APOTHEM, x_A)
    return A, B, C, solution


def _coordinates() -> dict[str, tuple[Expr, Expr]]:
    """Return vertices and centroid while C passes a corner."""
    A, B, C, solution = _loop()
    origin = A.base
    assert origin is not None
    points = {p.name: displacement(origin, p, PLANE).components[:2] for p in (A, B, C)}
    turned = -THETA - pi - chord_direction(S.Zero, OPPOSITE) + 2 * pi
    x, y = points["C"]
    points["M"] = (x - RHO * cos(turned), y - RHO * sin(turned))
    x_A = displacement(origin, A, PLANE)[0]
    return {name: (x.subs(x_A, solution), y.subs(x_A, solution)) for name, (x, y) in points.items()}


def _add_path(f: Formulas) -> None:
    places = _coordinates()
    steps = [
        let(symbol, places[symbol.name[-1]]["xy".index(symbol.name[0])], "the loop A-C-B closes")
        for symbol in PLACES
    ]
    f.function("path", (THETA, SHAPE), *_shape(), *steps, gives=PLACES)


def _add_ellipse(f: Formulas) -> None:
    """Add centre, axes and direction of C's path, centre + cos(theta) u + sin(theta) v, and the
    radii at the side.
    """
    x, y = (sp.expand(sp.expand_trig(e)) for e in _coordinates()["C"])
    u, v = (Matrix([x.coeff(wave(THETA)), y.coeff(wave(THETA))]) / WIDTH for wave in (cos, sin))
    rest = [
        sp.expand(e - WIDTH * (a * cos(THETA) + b * sin(THETA)))
        for e, a, b in zip((x, y), u, v, strict=True)
    ]
    named = {u[0]: COSINE, v[0]: SINE}
    u, v = (Matrix([named.get(e, e) for e in column]) for column in (u, v))
    largest, axis, area = _find_axes(u, v)
    slope, bend = (
        WIDTH * (-sin(THETA) * u + cos(THETA) * v),
        WIDTH * (-cos(THETA) * u - sin(THETA) * v),
    )
    lowest = {THETA: pi / 2}
    corner, tangent = WIDTH * sp.tan(TURN / 2) / 2, rest[0].subs(APOTHEM, WIDTH / 2) + WIDTH * SINE
    steps = (
        *(let(symbol, sp.simplify(e)) for symbol, e in zip(CENTRE, rest, strict=True)),
        *(let(name, sp.simplify(e)) for e, name in named.items()),
        let(MAJOR, WIDTH * largest, "eigenvalues of u u' + v v'"),
        let(MINOR, WIDTH * area / largest, "eigenvalues of u u' + v v'"),
        axis,
        let(TANGENCY, (slope[0] ** 2 / sp.Abs(bend[1])).subs(lowest)),
        let(
            FILLET,
            sp.simplify((corner - tangent) / sp.tan(TURN / 2)),
            "the fillet begins where the path leaves the side",
        ),
    )
    outputs = (*CENTRE, MAJOR, MINOR, AXIS, TANGENCY, FILLET, LEAD, RHO, ARC)
    f.function("ellipse", (SHAPE,), *_shape(), *steps, gives=outputs)


def _find_axes(u: Matrix, v: Matrix) -> tuple[Expr, Let, Expr]:
    """Return the major semi-axis of cos(t) u + sin(t) v, its direction, and both semi-axes'
    product.
    """
    form = u * u.T + v * v.T
    difference = sqrt(((form[0, 0] - form[1, 1]) / 2) ** 2 + form[0, 1] ** 2)
    direction = sp.atan2(2 * form[0, 1], form[0, 0] - form[1, 1]) / 2
    axis = let(AXIS, direction, "eigenvectors of u u' + v v'")
    return sqrt(form.trace() / 2 + difference), axis, sp.Abs(u.row_join(v).det())


def _sliding_vertices() -> dict[str, tuple[Expr, Expr]]:
    """Return three vertices, the first on the upper side, the second on a side that is turned by
    the spread.
    """
    x, y = sp.symbols("x y", real=True)
    arms = {
        p: (RHO * cos(ROTATION + polar), RHO * sin(ROTATION + polar))
        for p, polar in zip("ABC", POLES, strict=True)
    }
    turned = pi / 2 + SPREAD
    across = cos(turned) * (x + arms["B"][0]) + sin(turned) * (y + arms["B"][1])
    solution = sp.solve([y + arms["A"][1] - APOTHEM, across - APOTHEM], (x, y))
    return {
        p: (solution[x] + arm[0], solution[y] + arm[1])
        for p, arm in (*arms.items(), ("M", (S.Zero, S.Zero)))
    }


def _add_trammel(f: Formulas) -> None:
    """Add the path of a vertex while two others slide on two sides: coordinates, and the
    ellipse.
    """
    places = _sliding_vertices()
    steps = [
        let(
            symbol,
            places[symbol.name[-1]]["xy".index(symbol.name[0])],
            "two vertices on their sides",
        )
        for symbol in PLACES
    ]
    x, y = (sp.expand(sp.expand_trig(e)) for e in places["C"])
    u, v = (Matrix([x.coeff(wave(ROTATION)), y.coeff(wave(ROTATION))]) for wave in (cos, sin))
    rest = [
        sp.simplify(e - a * cos(ROTATION) - b * sin(ROTATION))
        for e, a, b in zip((x, y), u, v, strict=True)
    ]
    largest, axis, area = _find_axes(u, v)
    oval = (
        *let_all(CENTRE, rest),
        let(MAJOR, largest, "eigenvalues of u u' + v v'"),
        let(MINOR, area / MAJOR, "eigenvalues of u u' + v v'"),
        axis,
    )
    f.function("slid", (ROTATION, TRAMMEL), *steps)
    f.function("slid_ellipse", (TRAMMEL,), *oval)


def support_steps() -> tuple[Let, ...]:
    """Return the support function: normals within half an arc of a vertex belong to it, the others
    to arcs.
    """
    normal = polar_unit_vector(INSIDE)
    about = (
        RHO * polar_unit_vector(pi + ARC).dot(normal),
        RHO * polar_unit_vector(pi - ARC).dot(normal),
    )
    beyond = sp.Abs(INSIDE) - ARC / 2
    arc = WIDTH + switch(INSIDE, *(sp.trigsimp(e) for e in about))
    return (
        *_shape(),
        let(INSIDE, wrap(PSI + ARC, 2 * ARC) - ARC),
        let(SUPPORT, switch(-beyond, RHO * polar_unit_vector(S.Zero).dot(normal), arc)),
    )


def _add_support(f: Formulas) -> None:
    beyond = sp.Abs(INSIDE) - ARC / 2
    steps = (*support_steps(), let(RADIUS, switch(-beyond, S.Zero, WIDTH)))
    f.function("support", (PSI, SHAPE), *steps, gives=(SUPPORT, RADIUS))


def _add_harmonic(f: Formulas) -> None:
    """Add the harmonics of the support h: those of the radius of curvature h + h'', divided by 1 -
    k^2.
    """
    k, psi = sp.Dummy("k", positive=True), sp.Dummy("psi", real=True)
    mean = 2 * sp.integrate(cos(k * psi), (psi, ARC / 2, ARC)) * WIDTH / ARC
    amplitude = (mean / (1 - k**2)).subs(k, ORDER * VERTICES)
    f.function("harmonic", (ORDER, SHAPE), *_shape(), let(HARMONIC, amplitude), gives=(HARMONIC,))


def build_rotor_system() -> System:
    """Build the model of a Reuleaux polygon in a regular polygon, from first principles."""
    title, source = "Reuleaux polygon in a regular polygon", "derived (kinematics)"
    f = Formulas("clutch_rotor", title=title, source=source, assumptions=ASSUMPTIONS, told="{}")
    for part in (_add_path, _add_ellipse, _add_trammel, _add_support, _add_harmonic):
        part(f)
    return f.system()


SYSTEMS = (build_rotor_system,)
