"""Models of the clutch: the same functions from the derived and from the printed equations, and the
shaft's bending.

Each function solves equations in the given order, each linear in its unknown and found by its
claim. If a source does not state a claim, the functions leave out what depends on it. The
engagement is computed for several assumed shapes of bending (shi2021, section 3.1): a shape phi(x)
of height 1 at the contact gives the beam the kinetic energy M y'^2 / 2 and the strain energy K y^2
/ 2 of one coordinate y, its deflection at the contact (Rayleigh).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import mpmath
import sympy as sp
from sympy import Expr, S, cos, cosh, pi, sin, sinh

from ...equations import Claimed, Definition, Equation, find_claim
from ...formulas import Formulas, Wanted
from ...model import ClosedForm, Let, System, let
from ...quantity import Quantity, Vector
from . import quantities as q
from .geometry import hexagon_apothem, split_by_theta, substitute_angles, third_overlap
from .motion import CRANK, add_slider, assumed_mode, bearing_conditions
from .subject import ASSUMPTIONS, derive_formulas

FLATS = Quantity("flats", "m", "distance between opposite flats of the output shaft", "shi2021 2.1")
WALL = Quantity(
    "wall", "m", "material between tooth roots and outline at the right end", "derived: clutch"
)
MISS = Quantity(
    "miss", "m", "largest overlap with the third pair of sides over a revolution", "derived: clutch"
)
FREE = Quantity(
    "free",
    "m",
    "smallest distance of opposite sides in which the polygon turns freely",
    "derived: clutch",
)

CLUTCH = Vector("clutch", (q.a, FLATS, q.r, q.b1, q.b2, q.phi, q.c, q.mu, q.F1, q.F2, q.R2, q.d))

_POLYGON = (
    ("side of the hexagon that fits the polygon's width", q.R),
    ("largest outline radius of the body", q.b),
    ("coefficient of the sine in the path of C", q.A1),
    ("coefficient of the cosine in the path of C", q.A2),
    ("centre of the ellipse, x", q.x_E),
    ("centre of the ellipse, y", q.y_E),
    ("focus of the ellipse, x", q.x_F),
    ("line of the foci", q.y_F),
    ("semi-major axis of the ellipse", q.s_1),
    ("semi-minor axis of the ellipse", q.s_2),
    ("curvature of the path where it leaves the side", q.rho_C),
)
_PATH = (
    ("side of the hexagon that fits the polygon's width", q.R),
    ("coefficient of the sine in the path of C", q.A1),
    ("coefficient of the cosine in the path of C", q.A2),
    ("direction of BC from that of AC", q.beta),
    ("path of C, x", q.x_C),
    ("path of C, y", q.y_C),
    ("vertex C from vertex A, x", q.x_A),
    ("vertex C from vertex A, y", q.y_A),
    ("coordinates of C in the turned frame, X", q.X_C),
    ("coordinates of C in the turned frame, Y", q.Y_C),
    ("vertex C from vertex B, X", q.X_B),
    ("vertex C from vertex B, Y", q.Y_B),
    ("overlap with the third pair of sides", q.e_3),
)
_TEETH = (
    ("tooth tips go round the shaft", q.b1),
    ("tooth roots clear the shaft's corners", q.b2),
    ("angle between the faces of a tooth", q.xi),
)
_TRAVEL = (
    ("largest outline radius of the body", q.b),
    ("least travel of the sleeve", q.c_min),
    ("sleeve on the taper, force across it", q.F_N),
    ("friction of body and sleeve", q.f),
)
_GEARS = (
    ("rotation of the crank gear with the link", q.theta_A),
    ("rotation of the crank gear relative to the link", q.theta_AR),
)
_LIMIT = (
    ("rotation of the crank for the travel of the sleeve", q.theta_Amax),
    ("rotation of the crank gear for a number of teeth", q.n),
)
_CONDITIONS = {
    "fillet that the tooth tips clear": ("fillet", "m"),
    "tooth tips go round the shaft": ("tips", "m"),
    "tooth roots clear the shaft's corners": ("roots", "m"),
    "travel of the sleeve": ("travel", "m"),
    "sleeve slides along the taper": ("slide", "N"),
    "material between tooth roots and outline": ("material", "1"),
    "least axial angle for a travel": ("least_angle", "rad"),
    "largest axial angle at which the sleeve slides": ("largest_angle", "rad"),
}
"""The inequalities of a working clutch, each with the name and the unit of its _margin."""


def _outline_radius(f: Formulas) -> Let:
    """Return the outline radius at the left end, from the axial angle."""
    equation = find_claim(f.equations, "axial angle from the outline radii")
    (radius,) = sp.solve(equation.residual, q.R1)
    return Let(q.R1, radius, equation.source)


def _margin(f: Formulas, claim: Claimed, name: str, unit: str) -> Let:
    """Return the margin of an inequality, positive if it holds."""
    equation = find_claim(f.equations, claim)
    sign = 1 if equation.relation in (">", ">=") else -1
    symbol = Quantity(f"margin_{name}", unit, str(claim), equation.source)
    return Let(symbol, sign * equation.residual.xreplace(f.bind), equation.source)


def section_edge() -> Let:
    """Return the edge of the shaft's section, from the distance of its flats."""
    (edge,) = sp.solve(2 * hexagon_apothem(q.a1) - FLATS, q.a1)
    return let(q.a1, edge, "regular hexagon")


def _add_functions(f: Formulas) -> None:
    """Add the functions of both models."""
    f.function("polygon", (q.a,), *_POLYGON)
    f.function("path", (q.theta, q.a), *_PATH)
    f.function(
        "fillet", (FLATS,), section_edge(), ("fillet that the tooth tips clear", q.r), gives=(q.r,)
    )
    f.function(
        "teeth", (FLATS, q.r), section_edge(), *_TEETH, gives=[symbol for _, symbol in _TEETH]
    )
    f.function("face", (FLATS, q.b1), section_edge(), _TEETH[2], gives=(q.xi,))
    f.function("travel", q.TABLE.select("a phi mu F1 F2"), *_TRAVEL)
    f.function(
        "angle",
        (q.a, q.c),
        "largest outline radius of the body",
        ("least axial angle for a travel", q.phi),
    )
    f.function("taper", (q.R2, q.d, q.phi), _outline_radius(f))
    f.function("gears", (q.alpha, q.k, q.gamma), *_GEARS)
    f.function("limit", (CRANK, q.c, q.r_A, q.m), *_LIMIT)
    margins = [_margin(f, claim, *name) for claim, name in _CONDITIONS.items()]
    symbols = [step.symbol for step in margins]
    f.function(
        "conditions",
        (CLUTCH,),
        section_edge(),
        *_TRAVEL,
        _outline_radius(f),
        *margins,
        gives=symbols,
    )


def _add_rotor(f: Formulas) -> None:
    """Add the deviation of the polygon from a rotor of its hexagon, shared equally by the three
    pairs of sides.
    """
    pieces = [substitute_angles(piece) for piece, _ in third_overlap().args]
    rest, cosine, sine = split_by_theta(pieces[0])
    miss = q.R * sp.Abs(sp.Abs(rest) - sp.sqrt(cosine**2 + sine**2))
    third = sp.symbols("p_x p_y s")
    turns = [sp.pi / 2 - i * sp.pi / 3 for i in range(3)]
    strips = [third[0] * sp.cos(t) + third[1] * sp.sin(t) for t in turns]
    overlaps = (sp.S.Zero, sp.S.Zero, MISS)
    shared = sp.solve(
        [
            strip - side - sign * third[2]
            for strip, side, sign in zip(strips, overlaps, (1, -1, 1), strict=True)
        ],
        third,
    )
    widened = q.R + 2 * sp.Abs(shared[third[2]]).subs(sp.Abs(MISS), MISS)
    steps = (
        _POLYGON[0],
        let(MISS, miss, "largest overlap of a piece between two contacts"),
        let(FREE, widened, "the three pairs of sides share the overlap"),
    )
    f.function("rotor", (q.a,), *steps, gives=(MISS, FREE))


def _add_body(f: Formulas) -> None:
    """Add the hexagon side with which a body of full outline at its left end has its wall outside
    the tooth roots.
    """
    side = f.expr("largest outline radius of the body")
    steepness = (side - hexagon_apothem(q.a)) / q.c
    (minimum,) = sp.solve(side - q.d * steepness - q.b2 - WALL, q.a)
    f.function("body", (q.b2, WALL, q.d, q.c), let(q.a, sp.simplify(minimum), "tapered body"))


def build_clutch_system() -> System:
    """Build the model of the clutch from first principles."""
    title = "Reuleaux-pentagon clutch, from first principles"
    stated = derive_formulas().equations.values()
    source, assumptions = "derived (kinematics, statics)", ASSUMPTIONS[:4]
    f = Formulas(
        "clutch_exact", stated, title=title, source=source, assumptions=assumptions, told="{}"
    )
    _add_functions(f)
    _add_rotor(f)
    _add_body(f)
    add_slider(f)
    return f.system()


def build_printed_clutch(
    equations: Mapping[str, Equation],
    reading: Mapping[sp.Symbol, Expr],
    lacking: frozenset[Claimed] = frozenset(),
) -> System:
    """Build the model of the clutch as a paper prints it, without the claims that it is
    ``lacking``.

    Raises ClaimError if the paper states a claim that is not derived, states one twice, or lacks
    another one.
    """
    title, source = "Reuleaux-pentagon clutch, as printed", "shi2021 (1)-(7), taken literally"
    f = Formulas(
        "clutch_printed",
        equations.values(),
        title=title,
        source=source,
        assumptions=ASSUMPTIONS[:4],
        told="{}",
        bind=reading,
        lacking=lacking,
    )
    for claim in (*f.equations, *lacking):
        if not isinstance(claim, Definition):
            find_claim(derive_formulas().equations, claim)
    _add_functions(f)
    return f.system()


BEND = "beam"
BEAM_ASSUMPTIONS = (
    "output shaft is a uniform Euler-Bernoulli beam of hexagonal section, in one assumed shape",
    "shaft end undeformed at contact and at the body's speed; both move together",
)

Z = sp.Symbol("z", nonnegative=True)
"""Position along the overhang, relative to its length."""
DIGITS = 40


_beam = partial(Quantity, source=f"derived: {BEND}")


MASS = _beam("mass_coefficient", "1", "modal mass over the mass of the overhang")
STIFFNESS = _beam("stiffness_coefficient", "1", "modal stiffness over E I / l^3")
SWING = _beam("swing", "N", "amplitude of the load about the driving force")
LAG = _beam("lag", "rad", "phase at which the load passes the driving force")
N_0 = _beam("N_0", "N", "contact load at the start")
T_MAX = _beam("t_max", "s", "time of the largest load")
T_LOSS = _beam("t_loss", "s", "time of loss of contact; a full swing if the contact is never lost")
RATE = _beam("rate", "m/s", "speed of tooth and shaft end")
PERIOD = _beam("period", "s", "time of a full swing")
DRIVE_WORK = _beam("given", "J", "work of the driving force since the start")
STORED_ENERGY = _beam("kept", "J", "kinetic and strain energy minus that at the start")

BEAM = Vector("beam", (FLATS, q.E, q.rho, q.l))
STRUCK = Vector("struck", q.TABLE.select("m1 F_M Delta_omega r1"))
"""The striking body: mass, force, speed difference, radius."""


def clamped_mode() -> tuple[Expr, Expr]:
    """Return the first eigenvalue b of the clamped-free beam, cos(b) cosh(b) = -1, and its mode of
    height 1.
    """
    b = sp.Dummy("b")
    root = sp.nsolve(cos(b) * cosh(b) + 1, b, 1.875, prec=DIGITS)
    share = (cosh(root) + cos(root)) / (sinh(root) + sin(root))
    return root, (cosh(root * Z) - cos(root * Z) - share * (sinh(root * Z) - sin(root * Z))) / 2


def static_shape(fixity: Expr = S.One) -> Expr:
    """Return the shape, of height 1, of a beam with a bearing at z = 0 and a transverse load at its
    end z = 1.

    The ``fixity`` of the bearing is 1 if it clamps the beam, and 0 if the beam turns freely in it.
    """
    a, b, c, d = sp.symbols("a b c d")
    shape = a + b * Z + c * Z**2 + d * Z**3
    conditions = bearing_conditions(shape.subs(Z, q.x / q.l)).values()
    at_bearing = [sp.expand(q.l * condition.subs(q.fixity, fixity)) for condition in conditions]
    ends = [*at_bearing, shape.diff(Z, 2).subs(Z, 1), shape.subs(Z, 1) - 1]
    return shape.subs(sp.solve(ends, (a, b, c, d)))


def bending_shapes() -> dict[str, Expr]:
    """Return the available shapes over z by name; the first is that of the paper."""
    return {
        "quarter_sine": assumed_mode().subs(q.x, Z * q.l),
        "clamped_cosine": 1 - cos(pi / 2 * Z),
        "clamped_static": static_shape(),
        "clamped_mode": clamped_mode()[1],
    }


def shape_integrals(shape: Expr) -> tuple[Expr, Expr]:
    """Return the integrals over 0..1 of the squared shape and of its squared curvature."""
    if shape.has(sp.Float):
        return sp.Rational(str(_quadrature(shape))), sp.Rational(str(_quadrature(shape.diff(Z, 2))))
    return _integral(shape), _integral(shape.diff(Z, 2))


def _integral(expr: Expr) -> Expr:
    """Return the integral of a square over 0..1."""
    return sp.simplify(sp.integrate(expr**2, (Z, 0, 1)))


def _quadrature(expr: Expr) -> sp.Float:
    """Return the integral of a square over 0..1 to 20 digits."""
    digits = DIGITS // 2
    with mpmath.workdps(digits + 5):
        return sp.N(
            sp.Float(mpmath.quad(sp.lambdify(Z, expr**2, "mpmath"), (0, 1)), digits + 5), digits
        )


def _add_modal(f: Formulas, name: str, shape: Expr) -> None:
    """Add modal mass and stiffness of the shaft in a shape, and the mass of the overhang."""
    mass, stiffness = shape_integrals(shape)
    steps = (
        section_edge(),
        "section of the shaft",
        "second moment of the shaft",
        "mass of the overhanging shaft",
        let(MASS, mass, BEND),
        let(STIFFNESS, stiffness, BEND),
        let(q.M_1, MASS * q.m2, BEND),
        let(q.K_1, STIFFNESS * q.E * q.I / q.l**3, BEND),
    )
    f.function(name, (BEAM,), *steps, gives=(MASS, STIFFNESS, q.M_1, q.K_1, q.m2, q.I))


def frequency_steps() -> tuple[Let, ...]:
    """Return frequency and acceleration by the driving force of shaft and body, which move as one
    mass in contact.
    """
    moving = q.M_1 + q.m1
    return (let(q.B1, sp.sqrt(q.K_1 / moving), BEND), let(q.B2, q.F_M / moving, BEND))


def _add_extremes(f: Formulas, inputs: tuple[Vector | Quantity, ...], *rates: Wanted) -> ClosedForm:
    """Add the load as an oscillation about the driving force: its maximum, the time of it, the time
    of its loss.
    """
    load = sp.expand(derive_formulas().expr("contact load over time"))
    sine, cosine = load.coeff(sin(q.B1 * q.t)), load.coeff(cos(q.B1 * q.t))
    steps = (
        let(SWING, sp.sqrt(sine**2 + cosine**2), BEND),
        let(LAG, sp.atan2(-cosine, sine), BEND),
        let(N_0, load.subs(q.t, 0), BEND),
        let(q.N_max, q.F_M + SWING, BEND),
        let(T_MAX, (pi / 2 + LAG) / q.B1, BEND),
        let(PERIOD, 2 * pi / q.B1, BEND),
        let(T_LOSS, (pi + LAG + sp.asin(sp.Min(S.One, q.F_M / SWING))) / q.B1, BEND),
    )
    outputs = (q.B1, q.B2, SWING, N_0, q.N_max, T_MAX, T_LOSS, PERIOD)
    return f.function("extremes", inputs, *rates, *steps, gives=outputs)


def _add_energy(f: Formulas) -> None:
    """Add the work since the start and the stored energy, while tooth and shaft end move
    together.
    """
    way = sp.Dummy("way")

    def stored(deflection: Expr, speed: Expr) -> Expr:
        strain = sp.integrate(q.K_1 * way, (way, 0, deflection))
        return (q.M_1 + q.m1) * speed**2 / 2 + strain

    steps = (
        "speed of the contact point at the start",
        let(DRIVE_WORK, sp.integrate(q.F_M, (way, 0, q.y_max)), BEND),
        let(STORED_ENERGY, stored(q.y_max, RATE) - stored(S.Zero, q.v_0), BEND),
    )
    f.function(
        "energy",
        (q.y_max, RATE, q.M_1, q.K_1, STRUCK),
        *steps,
        gives=(DRIVE_WORK, STORED_ENERGY),
        told="energies",
    )


def build_beam_system() -> System:
    """Build the model of the engagement from first principles."""
    title = "Engagement in one mode, from first principles"
    stated = derive_formulas().equations.values()
    f = Formulas(
        "clutch_beam",
        stated,
        title=title,
        source="derived",
        assumptions=BEAM_ASSUMPTIONS,
        told="{}",
    )
    for name, shape in bending_shapes().items():
        _add_modal(f, name, shape)
    _add_extremes(f, (q.M_1, q.K_1, STRUCK), *frequency_steps())
    rate = let(RATE, f.expr("deflection at the contact over time").diff(q.t), BEND)
    moving = "deflection at the contact over time", "contact load over time", rate
    f.function("motion", (q.t, q.B1, q.B2, STRUCK), *moving, gives=(q.y_max, RATE, q.N))
    f.function("start", (STRUCK,), "speed of the contact point at the start", told="at_start")
    _add_energy(f)
    return f.system()


def build_printed_beam(equations: Mapping[str, Equation]) -> System:
    """Build the model with the frequency and the acceleration that a paper prints, otherwise with
    (11).
    """
    title, source = "Engagement in one mode, as printed", "shi2021 (8)-(12), taken literally"
    f = Formulas(
        "clutch_beam_printed",
        equations.values(),
        title=title,
        source=source,
        assumptions=BEAM_ASSUMPTIONS,
        told="{}",
    )
    rates = ("circular frequency in contact", q.B1), ("acceleration by the driving force", q.B2)
    _add_extremes(f, (q.E, q.I, q.l, q.m2, STRUCK), *rates)
    return f.system()


SYSTEMS = (
    build_clutch_system,
    build_beam_system,
)
