"""What is computed of the clutch: the same stages from the derived equations and from those in print.

A stage solves equations in the order given here, each linear in its unknown, found by what it claims to be. A source
that makes no such claim says so; what hangs on it, its stages do not give.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr

from ...chain import Chain
from ...equations import Claim, Claimed, ClaimError, Definition, Equation, among, by_claim
from ...model import Formulas, Let, Stage
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


@dataclass(frozen=True)
class Source:
    """Equations by what they claim to be, how their symbols are read, and the claims that the source does not make.

    Raises ClaimError if it makes one of those.
    """

    equations: Mapping[Claimed, Equation]
    bind: Mapping[sp.Symbol, Expr] = field(default_factory=dict)
    lacking: frozenset[Claim] = frozenset()

    def __post_init__(self) -> None:
        made = sorted(map(str, self.lacking & self.equations.keys()))
        if made:
            raise ClaimError(f"said to be lacking, but stated: {', '.join(map(repr, made))}")

    def lets(self, order: Iterable[tuple[Claim, Quantity]]) -> tuple[Let, ...]:
        """Steps for an order, but for what the source lacks; raises ClaimError where it has no such claim otherwise."""
        made = [(claim, unknown) for claim, unknown in order if claim not in self.lacking]
        return Chain.of_claims(self.equations, made, self.bind).lets()

    def stage(
        self, name: str, inputs: tuple[Vector | Quantity, ...], order: Sequence[tuple[Claim, Quantity]],
        before: tuple[Let, ...] = (),
    ) -> Stage:  # fmt: skip
        """A stage that gives every unknown of its order but those that hang on what the source lacks."""
        missing = {unknown for claim, unknown in order if claim in self.lacking}
        steps: list[Let] = []
        for step in self.lets(order):
            if step.needs & missing:
                missing.add(step.symbol)
            else:
                steps.append(step)
        return Stage(name, inputs, (*before, *steps), Vector(name, tuple(step.symbol for step in steps)))

    def outline(self) -> Let:
        """Outline radius at the left end from the axial angle."""
        equation = among(self.equations, ClutchClaim.AXIAL_ANGLE)
        (radius,) = sp.solve(equation.residual, q.R1)
        return Let(q.R1, radius, equation.source)

    def conditions(self) -> Stage:
        """By how much each inequality holds."""
        margins = [self._margin(claim, *name) for claim, name in _CONDITIONS.items()]
        steps = (_edge(), *self.lets(_TRAVEL), self.outline(), *margins)
        return Stage("conditions", (CLUTCH,), steps, Vector("conditions", tuple(m.symbol for m in margins)))

    def _margin(self, claim: Claim, name: str, unit: str) -> Let:
        equation = among(self.equations, claim)
        sign = 1 if equation.relation in (">", ">=") else -1
        symbol = Quantity(f"margin_{name}", unit, str(claim), equation.source)
        return Let(symbol, sign * equation.residual.xreplace(dict(self.bind)), equation.source)


def _edge() -> Let:
    (edge,) = sp.solve(2 * apothem(q.a1) - FLATS, q.a1)
    return Let(q.a1, edge, "derived: regular hexagon")


def stages(source: Source) -> tuple[Stage, ...]:
    """The stages that both models have."""
    return (
        source.stage("polygon", (q.a,), _POLYGON),
        source.stage("path", (q.theta, q.a), _PATH),
        source.stage("fillet", (FLATS,), [(ClutchClaim.FILLET, q.r)], (_edge(),)),
        source.stage("teeth", (FLATS, q.r), _TEETH, (_edge(),)),
        source.stage("face", (FLATS, q.b1), _TEETH[2:], (_edge(),)),
        source.stage("travel", (q.a, q.phi, q.mu, q.F1, q.F2), _TRAVEL),
        source.stage(
            "angle",
            (q.a, q.c),
            [(ClutchClaim.OUTLINE_RADIUS, q.b), (ClutchClaim.LEAST_AXIAL_ANGLE, q.phi)],
        ),
        Stage("taper", (q.R2, q.d, q.phi), (source.outline(),), Vector("taper", (q.R1,))),
        source.stage("gears", (q.alpha, q.k, q.gamma), _GEARS),
        source.stage("limit", (CRANK, q.c, q.r_A, q.m), _LIMIT),
        source.conditions(),
    )


def rotor(source: Source) -> Stage:
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
        *source.lets(_POLYGON[:1]),
        Let(MISS, miss, "derived: largest overlap of a piece between two contacts"),
        Let(FREE, widened, "derived: the three pairs of sides share the overlap"),
    )
    return Stage("rotor", (q.a,), steps, Vector("rotor", (MISS, FREE)))


def body(source: Source) -> Stage:
    """Hexagon side with which a body of full outline at its left end keeps its wall outside the tooth roots."""
    side = source.lets([(ClutchClaim.OUTLINE_RADIUS, q.b)])[0].expr
    steepness = (side - apothem(q.a)) / q.c
    (least,) = sp.solve(side - q.d * steepness - q.b2 - WALL, q.a)
    return Stage(
        "body", (q.b2, WALL, q.d, q.c), (Let(q.a, sp.simplify(least), "derived: tapered body"),), Vector("body", (q.a,))
    )


def exact() -> Formulas:
    """The clutch from first principles."""
    source = Source(claims.claims())
    return Formulas(
        "clutch_exact",
        "Reuleaux-pentagon clutch, from first principles",
        "derived (kinematics, statics)",
        claims.ASSUMPTIONS[:4],
        (*stages(source), rotor(source), body(source), *slider()),
    )


def printed(
    equations: Mapping[str, Equation], reading: Mapping[sp.Symbol, Expr], lacking: frozenset[Claim] = frozenset()
) -> Formulas:
    """The clutch as a paper prints it, ``lacking`` what it does not state.

    Raises ClaimError where it states what nothing derives, the same twice, or not what is asked for.
    """
    said = by_claim(equations.values())
    for claim in (*said, *lacking):
        if not isinstance(claim, Definition):
            among(claims.claims(), claim)
    return Formulas(
        "clutch_printed",
        "Reuleaux-pentagon clutch, as printed",
        "shi2021 (1)-(7), taken literally",
        claims.ASSUMPTIONS[:4],
        stages(Source(said, reading, lacking)),
    )
