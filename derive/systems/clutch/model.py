"""What is computed of the clutch: the same functions from the derived equations and from those in print.

Each solves equations in the order given here, each linear in its unknown, found by what it claims to be; what does not
follow from a set of equations, its function does not give.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr

from ...chain import Chain, Solve
from ...equations import Equation
from ...model import ClosedForm, Let, System
from ...quantity import Quantity, Vector
from . import claims
from . import quantities as q
from .geometry import apothem, split, third_overlap, with_angles
from .slider import CRANK, slider

FLATS = Quantity("flats", "m", "distance between opposite flats of the output shaft", "shi2021 2.1")
WALL = Quantity("wall", "m", "material between tooth roots and outline at the right end", "derived: clutch")
MISS = Quantity("miss", "m", "largest overlap with the third pair of sides over a turn", "derived: clutch")
FREE = Quantity("free", "m", "least distance of opposite sides in which the polygon turns freely", "derived: clutch")

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
"""The inequalities of a working clutch, each with the name and the unit of its margin."""


@dataclass(frozen=True)
class Source:
    """Equations by what they claim to be, and how their symbols are read."""

    equations: Mapping[str, Equation]
    bind: Mapping[sp.Symbol, Expr] = field(default_factory=dict)

    def lets(self, order: Iterable[tuple[str, Quantity]]) -> tuple[Let, ...]:
        """Steps for those of an order that the source has."""
        solves = [Solve(claim, unknown) for claim, unknown in order if claim in self.equations]
        return Chain(self.equations, solves, self.bind).lets()

    def closed_form(
        self, name: str, inputs: tuple[Vector | Quantity, ...], order: Iterable[tuple[str, Quantity]],
        before: tuple[Let, ...] = (),
    ) -> ClosedForm:  # fmt: skip
        """A function that gives every unknown of its order that follows from its inputs and the unknowns before."""
        known = frozenset().union(*(v if isinstance(v, Vector) else {v} for v in inputs), *(b.defines for b in before))
        steps: list[Let] = []
        for step in self.lets(order):
            if step.needs <= known:
                steps.append(step)
                known |= {step.symbol}
        return ClosedForm(name, inputs, (*before, *steps), Vector(name, tuple(step.symbol for step in steps)))

    def outline(self) -> Let:
        """Outline radius at the left end from the axial angle."""
        equation = self.equations["axial angle from the outline radii"]
        (radius,) = sp.solve(equation.residual, q.R1)
        return Let(q.R1, radius, equation.source)

    def conditions(self) -> ClosedForm:
        """By how much each inequality holds."""
        margins = [self._margin(claim, *name) for claim, name in _CONDITIONS.items()]
        steps = (_edge(), *self.lets(_TRAVEL), self.outline(), *margins)
        return ClosedForm("conditions", (CLUTCH,), steps, Vector("conditions", tuple(m.symbol for m in margins)))

    def _margin(self, claim: str, name: str, unit: str) -> Let:
        equation = self.equations[claim]
        sign = 1 if equation.relation in (">", ">=") else -1
        symbol = Quantity(f"margin_{name}", unit, claim, equation.source)
        return Let(symbol, sign * equation.residual.xreplace(dict(self.bind)), equation.source)


def _edge() -> Let:
    (edge,) = sp.solve(2 * apothem(q.a1) - FLATS, q.a1)
    return Let(q.a1, edge, "derived: regular hexagon")


def closed_forms(source: Source) -> tuple[ClosedForm, ...]:
    """The functions that both models have."""
    return (
        source.closed_form("polygon", (q.a,), _POLYGON),
        source.closed_form("path", (q.theta, q.a), _PATH),
        source.closed_form("fillet", (FLATS,), [("fillet that the tooth tips clear", q.r)], (_edge(),)),
        source.closed_form("teeth", (FLATS, q.r), _TEETH, (_edge(),)),
        source.closed_form("face", (FLATS, q.b1), _TEETH[2:], (_edge(),)),
        source.closed_form("travel", (q.a, q.phi, q.mu, q.F1, q.F2), _TRAVEL),
        source.closed_form(
            "angle",
            (q.a, q.c),
            [("largest outline radius of the body", q.b), ("least axial angle for a travel", q.phi)],
        ),
        ClosedForm("taper", (q.R2, q.d, q.phi), (source.outline(),), Vector("taper", (q.R1,))),
        source.closed_form("gears", (q.alpha, q.k, q.gamma), _GEARS),
        source.closed_form("limit", (CRANK, q.c, q.r_A, q.m), _LIMIT),
        source.conditions(),
    )


def rotor(source: Source) -> ClosedForm:
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
    return ClosedForm("rotor", (q.a,), steps, Vector("rotor", (MISS, FREE)))


def body(source: Source) -> ClosedForm:
    """Hexagon side with which a body of full outline at its left end keeps its wall outside the tooth roots."""
    side = source.lets([("largest outline radius of the body", q.b)])[0].expr
    steepness = (side - apothem(q.a)) / q.c
    (least,) = sp.solve(side - q.d * steepness - q.b2 - WALL, q.a)
    return ClosedForm(
        "body", (q.b2, WALL, q.d, q.c), (Let(q.a, sp.simplify(least), "derived: tapered body"),), Vector("body", (q.a,))
    )


def exact() -> System:
    """The clutch from first principles."""
    source = Source(claims.claims())
    return System(
        "clutch_exact",
        "Reuleaux-pentagon clutch, from first principles",
        "derived (kinematics, statics)",
        claims.ASSUMPTIONS[:4],
        closed_forms=(*closed_forms(source), rotor(source), body(source), *slider()),
    )


def printed(equations: Mapping[str, Equation], reading: Mapping[sp.Symbol, Expr]) -> System:
    """The clutch as a paper prints it."""
    by_claim = {str(equation.claims): equation for equation in equations.values()}
    return System(
        "clutch_printed",
        "Reuleaux-pentagon clutch, as printed",
        "shi2021 (1)-(7), taken literally",
        claims.ASSUMPTIONS[:4],
        closed_forms=closed_forms(Source(by_claim, reading)),
    )


SYSTEMS = (exact,)
