"""Models of the clutch: the same functions from the derived and from the printed equations, and the shaft's bending.

Each function solves equations in the given order, each linear in its unknown and found by its claim. If a source
does not state a claim, the functions leave out what depends on it. The engagement is computed for several assumed
shapes of bending (shi2021, section 3.1): a shape phi(x) of height 1 at the contact gives the beam the kinetic energy
M y'^2 / 2 and the strain energy K y^2 / 2 of one coordinate y, its deflection at the contact (Rayleigh).
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp
from sympy import Expr, S, cos, cosh, pi, sin, sinh

from ...equations import Claim, Definition, Equation, among
from ...formulas import Formulas, Wanted
from ...model import ClosedForm, Let, System, let
from ...quantity import Quantity, Vector
from . import quantities as q
from .geometry import apothem, split, third_overlap, with_angles
from .motion import CRANK, add_slider, held_at_bearing, mode
from .quantities import ClutchClaim
from .subject import ASSUMPTIONS, derive_formulas

FLATS = Quantity("flats", "m", "distance between opposite flats of the output shaft", "shi2021 2.1")
WALL = Quantity("wall", "m", "material between tooth roots and outline at the right end", "derived: clutch")
MISS = Quantity("miss", "m", "largest overlap with the third pair of sides over a turn", "derived: clutch")
FREE = Quantity("free", "m", "least distance of opposite sides in which the polygon turns freely", "derived: clutch")

CLUTCH = Vector("clutch", (q.a, FLATS, q.r, q.b1, q.b2, q.phi, q.c, q.mu, q.F1, q.F2, q.R2, q.d))

_POLYGON = (
    (ClutchClaim.HEXAGON_SIDE, q.R),
    (ClutchClaim.OUTLINE_RADIUS, q.b),
    (ClutchClaim.PATH_SINE, q.A1),
    (ClutchClaim.PATH_COSINE, q.A2),
    (ClutchClaim.ELLIPSE_CENTRE_X, q.x_E),
    (ClutchClaim.ELLIPSE_CENTRE_Y, q.y_E),
    (ClutchClaim.FOCUS_X, q.x_F),
    (ClutchClaim.FOCI_LINE, q.y_F),
    (ClutchClaim.SEMI_MAJOR_AXIS, q.s_1),
    (ClutchClaim.SEMI_MINOR_AXIS, q.s_2),
    (ClutchClaim.PATH_CURVATURE, q.rho_C),
)
_PATH = (
    (ClutchClaim.HEXAGON_SIDE, q.R),
    (ClutchClaim.PATH_SINE, q.A1),
    (ClutchClaim.PATH_COSINE, q.A2),
    (ClutchClaim.DIRECTION_BC, q.beta),
    (ClutchClaim.PATH_X, q.x_C),
    (ClutchClaim.PATH_Y, q.y_C),
    (ClutchClaim.C_FROM_A_X, q.x_A),
    (ClutchClaim.C_FROM_A_Y, q.y_A),
    (ClutchClaim.C_TURNED_X, q.X_C),
    (ClutchClaim.C_TURNED_Y, q.Y_C),
    (ClutchClaim.C_FROM_B_X, q.X_B),
    (ClutchClaim.C_FROM_B_Y, q.Y_B),
    (ClutchClaim.THIRD_OVERLAP, q.e_3),
)
_TEETH = (
    (ClutchClaim.TIP_DISTANCE, q.b1),
    (ClutchClaim.ROOT_DISTANCE, q.b2),
    (ClutchClaim.FACE_ANGLE, q.xi),
)
_TRAVEL = (
    (ClutchClaim.OUTLINE_RADIUS, q.b),
    (ClutchClaim.LEAST_TRAVEL, q.c_min),
    (ClutchClaim.SLEEVE_ACROSS, q.F_N),
    (ClutchClaim.SLEEVE_FRICTION, q.f),
)
_GEARS = (
    (ClutchClaim.CRANK_GEAR, q.theta_A),
    (ClutchClaim.CRANK_GEAR_ON_LINK, q.theta_AR),
)
_LIMIT = (
    (ClutchClaim.CRANK_BY_TRAVEL, q.theta_Amax),
    (ClutchClaim.CRANK_BY_TEETH, q.n),
)
_CONDITIONS = {
    ClutchClaim.FILLET: ("fillet", "m"),
    ClutchClaim.TIP_DISTANCE: ("tips", "m"),
    ClutchClaim.ROOT_DISTANCE: ("roots", "m"),
    ClutchClaim.TRAVEL: ("travel", "m"),
    ClutchClaim.SLEEVE_SLIDES: ("slide", "N"),
    ClutchClaim.WALL: ("material", "1"),
    ClutchClaim.LEAST_AXIAL_ANGLE: ("least_angle", "rad"),
    ClutchClaim.LARGEST_AXIAL_ANGLE: ("largest_angle", "rad"),
}
"""The inequalities of a working clutch, each with the name and the unit of its _margin."""


def _outline_radius(f: Formulas) -> Let:
    """Outline radius at the left end from the axial angle."""
    equation = among(f.equations, ClutchClaim.AXIAL_ANGLE)
    (radius,) = sp.solve(equation.residual, q.R1)
    return Let(q.R1, radius, equation.source)


def _margin(f: Formulas, claim: Claim, name: str, unit: str) -> Let:
    """By how much an inequality holds."""
    equation = among(f.equations, claim)
    sign = 1 if equation.relation in (">", ">=") else -1
    symbol = Quantity(f"margin_{name}", unit, str(claim), equation.source)
    return Let(symbol, sign * equation.residual.xreplace(f.bind), equation.source)


def section_edge() -> Let:
    """Edge of the shaft's section from the distance of its flats."""
    (found,) = sp.solve(2 * apothem(q.a1) - FLATS, q.a1)
    return let(q.a1, found, "regular hexagon")


def _add_functions(f: Formulas) -> None:
    """The functions that both models have."""
    f.function("polygon", (q.a,), *_POLYGON)
    f.function("path", (q.theta, q.a), *_PATH)
    f.function("fillet", (FLATS,), section_edge(), (ClutchClaim.FILLET, q.r), gives=(q.r,))
    f.function("teeth", (FLATS, q.r), section_edge(), *_TEETH, gives=[symbol for _, symbol in _TEETH])
    f.function("face", (FLATS, q.b1), section_edge(), _TEETH[2], gives=(q.xi,))
    f.function("travel", (q.a, q.phi, q.mu, q.F1, q.F2), *_TRAVEL)
    f.function("angle", (q.a, q.c), ClutchClaim.OUTLINE_RADIUS, (ClutchClaim.LEAST_AXIAL_ANGLE, q.phi))
    f.function("taper", (q.R2, q.d, q.phi), _outline_radius(f))
    f.function("gears", (q.alpha, q.k, q.gamma), *_GEARS)
    f.function("limit", (CRANK, q.c, q.r_A, q.m), *_LIMIT)
    margins = [_margin(f, claim, *name) for claim, name in _CONDITIONS.items()]
    given = [step.symbol for step in margins]
    f.function("conditions", (CLUTCH,), section_edge(), *_TRAVEL, _outline_radius(f), *margins, gives=given)


def _add_rotor(f: Formulas) -> None:
    """How far the polygon is from a rotor of its hexagon: each of three pairs of sides gives way by a third."""
    pieces = [with_angles(piece) for piece, _ in third_overlap().args]
    rest, cosine, sine = split(pieces[0])
    miss = q.R * sp.Abs(sp.Abs(rest) - sp.sqrt(cosine**2 + sine**2))
    third = sp.symbols("p_x p_y s")
    turns = [sp.pi / 2 - i * sp.pi / 3 for i in range(3)]
    strips = [third[0] * sp.cos(t) + third[1] * sp.sin(t) for t in turns]
    given = (sp.S.Zero, sp.S.Zero, MISS)
    shared = sp.solve(
        [strip - side - sign * third[2] for strip, side, sign in zip(strips, given, (1, -1, 1), strict=True)], third
    )
    widened = q.R + 2 * sp.Abs(shared[third[2]]).subs(sp.Abs(MISS), MISS)
    steps = (
        _POLYGON[0],
        let(MISS, miss, "largest overlap of a piece between two contacts"),
        let(FREE, widened, "the three pairs of sides share the overlap"),
    )
    f.function("rotor", (q.a,), *steps, gives=(MISS, FREE))


def _add_body(f: Formulas) -> None:
    """Hexagon side with which a body of full outline at its left end keeps its wall outside the tooth roots."""
    side = f.expr(ClutchClaim.OUTLINE_RADIUS)
    steepness = (side - apothem(q.a)) / q.c
    (least,) = sp.solve(side - q.d * steepness - q.b2 - WALL, q.a)
    f.function("body", (q.b2, WALL, q.d, q.c), let(q.a, sp.simplify(least), "tapered body"))


def build_clutch_system() -> System:
    """The clutch from first principles."""
    title = "Reuleaux-pentagon clutch, from first principles"
    stated = derive_formulas().equations.values()
    source, assumptions = "derived (kinematics, statics)", ASSUMPTIONS[:4]
    f = Formulas("clutch_exact", stated, title=title, source=source, assumptions=assumptions, told="{}")
    _add_functions(f)
    _add_rotor(f)
    _add_body(f)
    add_slider(f)
    return f.system()


def build_printed_clutch(
    equations: Mapping[str, Equation], reading: Mapping[sp.Symbol, Expr], lacking: frozenset[Claim] = frozenset()
) -> System:
    """The clutch as a paper prints it, ``lacking`` what it does not state.

    Raises ClaimError where it states what nothing derives, the same twice, or not what is asked for.
    """
    title, source = "Reuleaux-pentagon clutch, as printed", "shi2021 (1)-(7), taken literally"
    f = Formulas(
        "clutch_printed", equations.values(), title=title, source=source, assumptions=ASSUMPTIONS[:4],
        told="{}", bind=reading, lacking=lacking,
    )  # fmt: skip
    for claim in (*f.equations, *lacking):
        if not isinstance(claim, Definition):
            among(derive_formulas().equations, claim)
    _add_functions(f)
    return f.system()


BEND = "beam"
BEAM_ASSUMPTIONS = (
    "output shaft is a uniform Euler-Bernoulli beam of hexagonal section, in one assumed shape",
    "shaft end undeformed at contact and at the body's speed; both move together",
)

Z = sp.Symbol("z", nonnegative=True)
"""Place along the overhang as a share of it."""
DIGITS = 40


def _beam(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, f"derived: {BEND}")


MASS = _beam("mass_coefficient", "1", "modal mass over the mass of the overhang")
STIFFNESS = _beam("stiffness_coefficient", "1", "modal stiffness over E I / l^3")
SWING = _beam("swing", "N", "amplitude of the load about the driving force")
LAG = _beam("lag", "rad", "phase at which the load passes the driving force")
N_0 = _beam("N_0", "N", "contact load at the start")
T_MAX = _beam("t_max", "s", "time of the largest load")
T_LOSS = _beam("t_loss", "s", "time at which contact is lost; after a full swing to zero where it never is")
RATE = _beam("rate", "m/s", "speed of tooth and shaft end")
PERIOD = _beam("period", "s", "time of a full swing")
GIVEN = _beam("given", "J", "work of the driving force since the start")
KEPT = _beam("kept", "J", "kinetic and strain energy less that at the start")

BEAM = Vector("beam", (FLATS, q.E, q.rho, q.l))
STRUCK = Vector("struck", (q.m1, q.F_M, q.Delta_omega, q.r1))
"""What strikes the shaft: mass, force, speed difference, radius."""


def clamped_mode() -> tuple[Expr, Expr]:
    """First eigenvalue b of the clamped-free beam, cos(b) cosh(b) = -1, and its shape, of height 1 at the end."""
    b = sp.Dummy("b")
    root = sp.nsolve(cos(b) * cosh(b) + 1, b, 1.875, prec=DIGITS)
    share = (cosh(root) + cos(root)) / (sinh(root) + sin(root))
    return root, (cosh(root * Z) - cos(root * Z) - share * (sinh(root * Z) - sin(root * Z))) / 2


def static_shape(fixity: Expr = S.One) -> Expr:
    """A beam in its bearing at z = 0, free of moment at z = 1, under a load there, of height 1 at the end.

    The bearing clamps it, or holds it elastically with a ``fixity`` from 1 down to 0, where it turns freely.
    """
    a, b, c, d = sp.symbols("a b c d")
    shape = a + b * Z + c * Z**2 + d * Z**3
    held = held_at_bearing(shape.subs(Z, q.x / q.l)).values()
    at_bearing = [sp.expand(q.l * left.subs(q.fixity, fixity)) for left in held]
    ends = [*at_bearing, shape.diff(Z, 2).subs(Z, 1), shape.subs(Z, 1) - 1]
    return shape.subs(sp.solve(ends, (a, b, c, d)))


def shapes() -> dict[str, Expr]:
    """Shapes to choose from over z, by name; the first is the paper's."""
    return {
        "quarter_sine": mode().subs(q.x, Z * q.l),
        "clamped_cosine": 1 - cos(pi / 2 * Z),
        "clamped_static": static_shape(),
        "clamped_mode": clamped_mode()[1],
    }


def coefficients(shape: Expr) -> tuple[Expr, Expr]:
    """Integrals of the shape squared and of its curvature squared over 0..1."""
    if shape.has(sp.Float):
        return sp.Rational(str(_quadrature(shape))), sp.Rational(str(_quadrature(shape.diff(Z, 2))))
    return _integral(shape), _integral(shape.diff(Z, 2))


def _integral(expr: Expr) -> Expr:
    """Integral of a square over 0..1."""
    return sp.simplify(sp.integrate(expr**2, (Z, 0, 1)))


def _quadrature(expr: Expr) -> sp.Float:
    """Integral of a square over 0..1 to 20 digits."""
    digits = DIGITS // 2
    with mpmath.workdps(digits + 5):
        return sp.N(sp.Float(mpmath.quad(sp.lambdify(Z, expr**2, "mpmath"), (0, 1)), digits + 5), digits)


def _add_modal(f: Formulas, name: str, shape: Expr) -> None:
    """Modal mass and stiffness of the shaft in a shape, and the mass of the whole overhang."""
    mass, stiffness = coefficients(shape)
    steps = (
        section_edge(),
        ClutchClaim.SHAFT_SECTION,
        ClutchClaim.SECOND_MOMENT,
        ClutchClaim.OVERHANG_MASS,
        let(MASS, mass, BEND),
        let(STIFFNESS, stiffness, BEND),
        let(q.M_1, MASS * q.m2, BEND),
        let(q.K_1, STIFFNESS * q.E * q.I / q.l**3, BEND),
    )
    f.function(name, (BEAM,), *steps, gives=(MASS, STIFFNESS, q.M_1, q.K_1, q.m2, q.I))


def frequency_steps() -> tuple[Let, ...]:
    """Frequency of shaft and body in contact, and the acceleration by the driving force: they move as one mass."""
    moving = q.M_1 + q.m1
    return (let(q.B1, sp.sqrt(q.K_1 / moving), BEND), let(q.B2, q.F_M / moving, BEND))


def _add_extremes(f: Formulas, inputs: tuple[Vector | Quantity, ...], *rates: Wanted) -> ClosedForm:
    """The load as a swing about the driving force: largest, when, and when it is gone."""
    load = sp.expand(derive_formulas().expr(ClutchClaim.CONTACT_LOAD))
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
    given = (q.B1, q.B2, SWING, N_0, q.N_max, T_MAX, T_LOSS, PERIOD)
    return f.function("extremes", inputs, *rates, *steps, gives=given)


def _add_energy(f: Formulas) -> None:
    """Work done since the start, and what has become of it, where tooth and shaft end move together."""
    way = sp.Dummy("way")

    def held(deflection: Expr, speed: Expr) -> Expr:
        strain = sp.integrate(q.K_1 * way, (way, 0, deflection))
        return (q.M_1 + q.m1) * speed**2 / 2 + strain

    steps = (
        ClutchClaim.CONTACT_SPEED,
        let(GIVEN, sp.integrate(q.F_M, (way, 0, q.y_max)), BEND),
        let(KEPT, held(q.y_max, RATE) - held(S.Zero, q.v_0), BEND),
    )
    f.function("energy", (q.y_max, RATE, q.M_1, q.K_1, STRUCK), *steps, gives=(GIVEN, KEPT), told="energies")


def build_beam_system() -> System:
    """The engagement from first principles."""
    title = "Engagement in one mode, from first principles"
    stated = derive_formulas().equations.values()
    f = Formulas("clutch_beam", stated, title=title, source="derived", assumptions=BEAM_ASSUMPTIONS, told="{}")
    for name, shape in shapes().items():
        _add_modal(f, name, shape)
    _add_extremes(f, (q.M_1, q.K_1, STRUCK), *frequency_steps())
    rate = let(RATE, f.expr(ClutchClaim.CONTACT_DEFLECTION).diff(q.t), BEND)
    moving = ClutchClaim.CONTACT_DEFLECTION, ClutchClaim.CONTACT_LOAD, rate
    f.function("motion", (q.t, q.B1, q.B2, STRUCK), *moving, gives=(q.y_max, RATE, q.N))
    f.function("start", (STRUCK,), ClutchClaim.CONTACT_SPEED, told="at_start")
    _add_energy(f)
    return f.system()


def build_printed_beam(equations: Mapping[str, Equation]) -> System:
    """The engagement with the frequency and the acceleration that a paper prints; from there on it follows (11)."""
    title, source = "Engagement in one mode, as printed", "shi2021 (8)-(12), taken literally"
    said = equations.values()
    f = Formulas("clutch_beam_printed", said, title=title, source=source, assumptions=BEAM_ASSUMPTIONS, told="{}")
    rates = (ClutchClaim.CONTACT_FREQUENCY, q.B1), (ClutchClaim.DRIVING_ACCELERATION, q.B2)
    _add_extremes(f, (q.E, q.I, q.l, q.m2, STRUCK), *rates)
    return f.system()


SYSTEMS = (
    build_clutch_system,
    build_beam_system,
)
