"""What is computed of the clutch: the same functions from the derived equations and from those in print.

Each solves equations in the order given here, each linear in its unknown, found by what it claims to be. A source that
makes no such claim says so; what hangs on it, its functions do not give.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy import Expr

from ...equations import Claim, Definition, Equation, among
from ...formulas import Formulas
from ...model import Let, System, let
from ...quantity import Quantity, Vector
from . import claims
from . import quantities as q
from .geometry import apothem, split, third_overlap, with_angles
from .slider import CRANK, slider
from .vocabulary import ClutchClaim

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
"""The inequalities of a working clutch, each with the name and the unit of its margin."""


def outline(f: Formulas) -> Let:
    """Outline radius at the left end from the axial angle."""
    equation = among(f.equations, ClutchClaim.AXIAL_ANGLE)
    (radius,) = sp.solve(equation.residual, q.R1)
    return Let(q.R1, radius, equation.source)


def margin(f: Formulas, claim: Claim, name: str, unit: str) -> Let:
    """By how much an inequality holds."""
    equation = among(f.equations, claim)
    sign = 1 if equation.relation in (">", ">=") else -1
    symbol = Quantity(f"margin_{name}", unit, str(claim), equation.source)
    return Let(symbol, sign * equation.residual.xreplace(f.bind), equation.source)


def edge() -> Let:
    """Edge of the shaft's section from the distance of its flats."""
    (found,) = sp.solve(2 * apothem(q.a1) - FLATS, q.a1)
    return let(q.a1, found, "regular hexagon")


def functions(f: Formulas) -> None:
    """The functions that both models have."""
    f.function("polygon", (q.a,), *_POLYGON)
    f.function("path", (q.theta, q.a), *_PATH)
    f.function("fillet", (FLATS,), edge(), (ClutchClaim.FILLET, q.r), gives=(q.r,))
    f.function("teeth", (FLATS, q.r), edge(), *_TEETH, gives=[symbol for _, symbol in _TEETH])
    f.function("face", (FLATS, q.b1), edge(), _TEETH[2], gives=(q.xi,))
    f.function("travel", (q.a, q.phi, q.mu, q.F1, q.F2), *_TRAVEL)
    f.function("angle", (q.a, q.c), ClutchClaim.OUTLINE_RADIUS, (ClutchClaim.LEAST_AXIAL_ANGLE, q.phi))
    f.function("taper", (q.R2, q.d, q.phi), outline(f))
    f.function("gears", (q.alpha, q.k, q.gamma), *_GEARS)
    f.function("limit", (CRANK, q.c, q.r_A, q.m), *_LIMIT)
    margins = [margin(f, claim, *name) for claim, name in _CONDITIONS.items()]
    given = [step.symbol for step in margins]
    f.function("conditions", (CLUTCH,), edge(), *_TRAVEL, outline(f), *margins, gives=given)


def rotor(f: Formulas) -> None:
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


def body(f: Formulas) -> None:
    """Hexagon side with which a body of full outline at its left end keeps its wall outside the tooth roots."""
    side = f.expr(ClutchClaim.OUTLINE_RADIUS)
    steepness = (side - apothem(q.a)) / q.c
    (least,) = sp.solve(side - q.d * steepness - q.b2 - WALL, q.a)
    f.function("body", (q.b2, WALL, q.d, q.c), let(q.a, sp.simplify(least), "tapered body"))


def exact() -> System:
    """The clutch from first principles."""
    title = "Reuleaux-pentagon clutch, from first principles"
    stated = claims.formulas().equations.values()
    source, assumptions = "derived (kinematics, statics)", claims.ASSUMPTIONS[:4]
    f = Formulas("clutch_exact", stated, title=title, source=source, assumptions=assumptions, told="{}")
    functions(f)
    rotor(f)
    body(f)
    slider(f)
    return f.system()


def printed(
    equations: Mapping[str, Equation], reading: Mapping[sp.Symbol, Expr], lacking: frozenset[Claim] = frozenset()
) -> System:
    """The clutch as a paper prints it, ``lacking`` what it does not state.

    Raises ClaimError where it states what nothing derives, the same twice, or not what is asked for.
    """
    title, source = "Reuleaux-pentagon clutch, as printed", "shi2021 (1)-(7), taken literally"
    f = Formulas(
        "clutch_printed", equations.values(), title=title, source=source, assumptions=claims.ASSUMPTIONS[:4],
        told="{}", bind=reading, lacking=lacking,
    )  # fmt: skip
    for claim in (*f.equations, *lacking):
        if not isinstance(claim, Definition):
            among(claims.formulas().equations, claim)
    functions(f)
    return f.system()


SYSTEMS = (exact,)
