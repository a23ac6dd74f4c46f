"""Derived equations of the planting device for each claim of a paper, also without the paper's assumptions.

The assumptions that can be relaxed are the constant speed and the balance of the carrier, and the directions in which
spring and cam act on the nozzle.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from functools import cache
from itertools import combinations

import sympy as sp
from mpmath import mpf
from sympy import Expr, S, pi

from ...chain import ordered, solve_linear
from ...equations import Balance, Claimed, Equation, among, by_claim, defined, stated
from ...evaluate import Point as NumericPoint
from ...functions import switch
from ...mechanics import driven_motion as twins
from ...mechanics.bodies import Part, about_pin
from ...mechanics.contacts import GearContact
from ...mechanics.frames import Point, Vec, displacement
from ...mechanics.mechanism import Mechanism
from ...model import Let
from ...quantity import Quantity
from . import cycle, derivation
from . import quantities as q
from .quantities import PlantingClaim

BETWEEN = (
    q.L_AC1,
    q.L_AC2,
    q.theta30,
    q.theta40,
    q.theta3,
    q.theta4,
    q.mu,
    q.M_T,
    q.phi_P1,
    q.phi_P2,
    q.phi_Q1,
    q.phi_Q2,
    q.F_fP,
    q.F_fQ,
)
"""Quantities that the paper names between forces and geometry."""
OFFSETS: dict[sp.Symbol, Expr] = {
    q.phi72_dot: -q.omega, q.phi52_dot: -q.omega,
    q.x_C1: q.x_A, q.y_C1: q.y_A, q.z_C1: q.z_A, q.x_C2: q.x_A, q.y_C2: q.y_A, q.z_C2: q.z_A,
    q.x_CA: q.x_A1, q.y_CA: q.y_A1, q.x_CB: q.x_B1, q.y_CB: q.y_B1,
}  # fmt: skip
"""Rates that come in relative to the carrier's reverse, places that come in relative to a pin."""
SIDES = {s: -s for s in (q.x_A1, q.y_A1, q.x_B1, q.y_B1, q.x_P, q.y_P)}
"""Places on the carrier and on the sun's pitch curve lie opposite each other on the two sides."""


@cache
def derive_claims() -> dict[Claimed, Equation]:
    """Derived equations by what they claim to be."""
    m = derivation.device()
    found = (
        balances(m)
        + _cam(m)
        + _places(m)
        + _teeth(m, "P", derivation.CONTACT_P, q.M_P, q.F_NP, q.phi_P1, q.phi_P2, q.F_fP)
    )
    found += _teeth(m, "Q", derivation.CONTACT_Q, q.M_Q, q.F_NQ, q.phi_Q1, q.phi_Q2, q.F_fQ)
    return by_claim(found)


def balances(m: Mechanism) -> list[Equation]:
    """Of every body of a side, and of sun and carrier with both sides."""
    shared = twins.shared(m, twins.Other(q.phi, q.twin, twins.own(m)))
    return [e for e in (*m.equations(), *shared) if e.defines is None]


def _law(m: Mechanism, symbol: Quantity) -> Expr:
    return m.assembly.law(symbol).expr


def _cam(m: Mechanism) -> list[Equation]:
    """Contact of cam and roller: components of its force, its angle to the roller's path, its moment."""
    frictionless = {q.mu1: S.Zero}
    x, z = (_law(m, f).xreplace(frictionless) / q.F_E for f in (q.F_Ex, q.F_Ez))
    swing = q.theta1 + q.psi0
    path_x, path_z = sp.sin(swing), sp.cos(swing)
    angle = sp.atan((path_x * z - path_z * x) / (path_x * x + path_z * z))
    moment = -(q.x_E * S.Zero - q.y_E * q.F_Ex)
    return [
        defined(PlantingClaim.CAM_PRESSURE_ANGLE, q.mu, angle),
        defined(PlantingClaim.CAM_FORCE.of("x"), q.F_Ex, _law(m, q.F_Ex)),
        stated(PlantingClaim.CAM_FORCE.of("y"), q.F_Ey, q.F_Ey),
        defined(PlantingClaim.CAM_FORCE.of("z"), q.F_Ez, _law(m, q.F_Ez)),
        defined(PlantingClaim.CAM_MOMENT, q.M_T, moment),
    ]


def _places(m: Mechanism) -> list[Equation]:
    """Places of points on the swinging half, and the polar coordinates that a paper may give them by."""
    steps = {s.symbol: s.expr for s in m.named}
    found = [
        defined(PlantingClaim.PLACE.of(name, axis), symbol, steps[symbol])
        for name, axis, symbol in (
            ("the roller", "x", q.x_E), ("the roller", "z", q.z_E), ("C1", "x", q.x_C1), ("C1", "z", q.z_C1),
            ("C2", "x", q.x_C2), ("C2", "z", q.z_C2),
        )
    ]  # fmt: skip
    for name, (x, _, z), at, length, turned, closed in (
        ("C1", q.c_C1, (q.x_C1, q.z_C1), q.L_AC1, q.theta3, q.theta30),
        ("C2", q.c_C2, (q.x_C2, q.z_C2), q.L_AC2, q.theta4, q.theta40),
    ):
        down = sp.atan2(q.z_A - at[1], at[0] - q.x_A)
        found += [
            defined(PlantingClaim.HINGE_DISTANCE.of(name), length, sp.sqrt(x**2 + z**2)),
            defined(PlantingClaim.HINGE_ANGLE_CLOSED.of(name), closed, sp.atan2(-z, x)),
            defined(PlantingClaim.HINGE_ANGLE.of(name), turned, down),
        ]
    return found


def _teeth(
    m: Mechanism,
    tag: str,
    contact: GearContact,
    moment: Quantity,
    normal: Quantity,
    along: Quantity,
    across: Quantity,
    drag: Quantity,
) -> list[Equation]:
    """Tooth contact: directions and sizes of normal force and friction on the flank that can give the moment."""
    force = [next(u for u in m.unknowns if u.name == f"F_{tag}{axis}") for axis in "xy"]
    return [
        defined(PlantingClaim.NORMAL_DIRECTION.of(tag), along, switch(moment, contact.normal(1), contact.normal(-1))),
        defined(
            PlantingClaim.FRICTION_DIRECTION.of(tag), across, switch(moment, contact.across(1), contact.across(-1))
        ),
        defined(PlantingClaim.NORMAL_FORCE.of(tag), normal, _law(m, normal)),
        stated(PlantingClaim.FRICTION_FORCE.of(tag), drag - normal * sp.tan(q.mu2), drag),
        *(defined(PlantingClaim.TOOTH_FORCE.of(tag, axis), f, _law(m, f)) for axis, f in zip("xy", force, strict=True)),
    ]


@cache
def _relations() -> dict[Quantity, Expr]:
    return relations(derivation.device())


def relations(m: Mechanism) -> dict[Quantity, Expr]:
    """Unknowns that a paper need not name, in terms of others: constraint moments, and moments of tooth forces.

    Raises ClaimError where the mechanism has no such balance.
    """
    equations = by_claim(m.equations())
    from_balance = {
        "M_Az": Balance("inner half", "moment", "z", "planet", "A"),
        "M_Aoz": Balance("outer half", "moment", "z", "planet", "A outer"),
        "F_A1z": Balance("middle body", "force", "z", "frame"),
        "M_K": Balance("outer half", "moment", "y", "planet", "A outer"),
    }
    unknowns = {u.name: u for u in m.unknowns}
    found = {
        unknowns[name]: solve_linear(among(equations, balance), unknowns[name])
        for name, balance in from_balance.items()
    }
    at_Q = displacement(derivation.B1, derivation.Q, derivation.WORLD)
    found[q.M_P] = (q.y_P - q.y_A1) * q.F_Px - (q.x_P - q.x_A1) * q.F_Py
    found[q.M_Q] = at_Q[1] * q.F_Qx - at_Q[0] * q.F_Qy
    return found


def canonical(expr: Expr) -> Expr:
    """An expression in the quantities that papers use, multiplied out."""
    return squared(sp.expand(in_names(expr), trig=False))


def in_names(expr: Expr) -> Expr:
    """Named places for fixed offsets, rates relative to the carrier, side 1's places for those of side 2."""
    return expr.xreplace(_named()).xreplace({q.Omega: q.omega + q.phi72_dot, q.Omega_dot: q.phi72_ddot})


def _named() -> dict[sp.Symbol, Expr]:
    """Offsets that are fixed in a body, in terms of the named places of the points that they lead to."""
    found: dict[sp.Symbol, Expr] = {q.twin(s): other for s, other in SIDES.items()}
    c, s = sp.cos(q.theta1), sp.sin(q.theta1)
    for offset, (x, y, z) in ((q.c_C1, (q.x_C1, q.y_C1, q.z_C1)), (q.c_C2, (q.x_C2, q.y_C2, q.z_C2))):
        along, beyond = x - q.x_A, z - q.z_A
        found |= {offset[0]: along * c - beyond * s, offset[1]: y - q.y_A, offset[2]: along * s + beyond * c}
    along, beyond = q.x_CB - q.x_B1, q.y_CB - q.y_B1
    c, s = sp.cos(q.alpha), sp.sin(q.alpha)
    found |= {q.c_CBx: along * c - beyond * s, q.c_CBy: along * s + beyond * c}
    return found


def squared(expr: Expr) -> Expr:
    """A multiplied-out expression with every square of a sine written by the cosine, so that they add up to 1."""
    for _ in range(8):
        reduced = sp.expand(expr.replace(_is_square_of_sine, _by_cosine), trig=False)
        if reduced == expr:
            return expr
        expr = reduced
    return expr


def _is_square_of_sine(expr: sp.Basic) -> bool:
    return isinstance(expr, sp.Pow) and isinstance(expr.base, sp.sin) and expr.exp.is_Integer and expr.exp >= 2


def _by_cosine(power: Expr) -> Expr:
    angle = power.base.args[0]
    return power.base ** (power.exp - 2) * (1 - sp.cos(angle) ** 2)


@cache
def moving() -> frozenset[Quantity]:
    """Quantities that each side has of its own."""
    return twins.own(derivation.device()) | set(BETWEEN)


@cache
def actions() -> dict[sp.Symbol, str]:
    """What the mechanism calls its forces and moments, those of side 2 as those of side 1."""
    unknowns = derivation.device().assembly.unknowns
    return {symbol: u.meaning for u in unknowns for symbol in (u, q.twin(u))}


def common(printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
    """Two balances in the same quantities: what only one of them names is written by what both do."""
    given = _given(printed, derived)
    return in_names(given), canonical(eliminated(derived, given.free_symbols, _relations()))


def footings(printed: Expr, derived: Expr) -> list[tuple[Expr, Expr]]:
    """Two balances with none, some and all of the unknowns eliminated that only the derived one names."""
    given = _given(printed, derived)
    relations = {s: e for s, e in _relations().items() if {s, q.twin(s)} & (derived.free_symbols - given.free_symbols)}
    some = (chosen for size in range(len(relations) + 1) for chosen in combinations(relations, size))
    sums = (eliminated(derived, given.free_symbols, {s: relations[s] for s in chosen}) for chosen in some)
    return [(in_names(given), canonical(left)) for left in sums]


def _given(printed: Expr, derived: Expr) -> Expr:
    """A printed balance without the defined quantities that the derived one does not name."""
    definitions = {e.defines: e.defines - e.residual for e in derive_claims().values() if e.defines is not None}
    return eliminated(printed, derived.free_symbols, definitions)


def eliminated(expr: Expr, kept: set[sp.Symbol], definitions: Mapping[Quantity, Expr]) -> Expr:
    """``expr`` without the defined quantities that are not among those to keep, on both sides."""
    other = twins.Other(q.phi, q.twin, moving())
    for symbol, meant in definitions.items():
        for one, value in ((symbol, meant), (q.twin(symbol), other(meant))):
            if one in expr.free_symbols and one not in kept:
                expr = expr.xreplace({one: value})
    return expr


@cache
def compute_reference_cycle(points: int) -> tuple[Mapping[sp.Symbol, mpf], ...]:
    """Return every quantity over the reference cycle, those that the paper names between them too."""
    return tuple(_between(_reactions(NumericPoint(values))) for values in cycle.reference(points))


@cache
def supplements() -> tuple[Let, ...]:
    """The derivation's steps for every force and moment of one side that its equations name."""
    m = derivation.device()
    named = frozenset().union(*(e.residual.free_symbols for e in derive_claims().values()))
    return ordered(m.equations(), m.unknowns, [u for u in m.unknowns if u in named]).lets()


@cache
def _unreported() -> tuple[tuple[Quantity, Expr], ...]:
    """Every step of the motion and of the reactions, of side 1 and of side 2."""
    other = twins.Other(q.phi, q.twin, moving())
    steps = [(step.symbol, step.expr) for step in (*derivation.device().named, *supplements())]
    return tuple(pair for s, e in steps for pair in ((s, e), (q.twin(s), other(e))))


def _reactions(point: NumericPoint) -> NumericPoint:
    """A point with what no model reports of either side."""
    for symbol, expr in _unreported():
        if symbol not in point:
            point.set(symbol, point(expr))
    return point


def _between(point: NumericPoint) -> dict[sp.Symbol, mpf]:
    definitions = {e.defines: e.defines - e.residual for e in derive_claims().values() if e.defines in BETWEEN}
    for symbol in BETWEEN:
        point.set(symbol, point(definitions[symbol]))
    return point.values()


def draw_admissible_point(rng: random.Random) -> dict[sp.Symbol, mpf]:
    """A random point of the device on the rising flank of its cam, kinematics consistent, reactions at will.

    The rocker stays within a right angle of x', where the paper's arctangent is the pressure angle.
    """
    m = derivation.device()
    everything = {v for v in vars(q).values() if isinstance(v, Quantity)} | set(q.MACHINE) | set(m.unknowns)
    known: dict[sp.Symbol, Expr] = {
        s: sp.Rational(rng.randint(101, 999), rng.randint(301, 699))
        for s in sorted(everything | {q.twin(s) for s in everything}, key=str)
    }
    known |= {q.alpha_n: pi / 9, q.T2_0: S.Zero, q.T2: sp.Rational(rng.randint(23, 29), 10)}
    known |= dict(zip((*q.delta_r, *q.delta_f), map(sp.Rational, ("2.2", "3.1", "4.2", "5.1")), strict=True))
    known |= {q.psi0: sp.Rational(rng.randint(-30, 20), 100), q.H: sp.Rational(rng.randint(20, 45), 100)}
    known |= {s: known[s] * rng.choice((-1, 1)) for s in (q.M_P, q.M_Q)}
    return _consistent(known, m)


def _consistent(known: dict[sp.Symbol, Expr], m: Mechanism) -> dict[sp.Symbol, mpf]:
    """Kinematics and the quantities between, from the rest."""
    point = NumericPoint(known)
    for step in m.named:
        point.set(step.symbol, point(step.expr))
    return _between(point)


_SOURCE = "derived: assumption"
phi_ddot = Quantity("phi_ddot", "rad/s2", "acceleration of the carrier", _SOURCE)
J_4 = Quantity("J_4", "kg m2", "moment of inertia of the carrier about O", _SOURCE)
x_C4 = Quantity("x_C4", "m", "centroid of the carrier, along the carrier's x", _SOURCE)
y_C4 = Quantity("y_C4", "m", "centroid of the carrier, along the carrier's y", _SOURCE)
F_Fx = Quantity("F_Fx", "N", "force of the spring on the inner half, x'", _SOURCE)
F_Fy = Quantity("F_Fy", "N", "force of the spring on the inner half, y'", _SOURCE)

_SHARED = {
    phi_ddot: "constant carrier speed",
    x_C4: "balanced carrier",
    y_C4: "balanced carrier",
}
_OF_A_SIDE = {
    F_Fx: "the spring acts along z' alone",
    F_Fy: "the spring acts along z' alone",
    q.F_Ey: "the cam acts in the plane of the swing",
}
ZERO: dict[sp.Symbol, str] = _SHARED | _OF_A_SIDE | {q.twin(s): why for s, why in _OF_A_SIDE.items()}
"""Quantities that are zero by assumption, each with the reason."""


def relax_balance(claim: Claimed, printed: Expr) -> Expr | None:
    """The balance that a claim names, in the quantities of a printed one, while the assumptions are lifted."""
    if claim not in _relaxed_balances():
        return None
    given, _ = common(printed, among(derive_claims(), claim).residual)
    kept = eliminated(_relaxed_balances()[claim], given.free_symbols, _relaxed_relations())
    return canonical(kept.xreplace(_ACCELERATIONS))


_ACCELERATIONS = {
    q.Omega_dot: phi_ddot + q.phi72_ddot,
    q.twin(q.Omega_dot): phi_ddot + q.twin(q.phi72_ddot),
}


@cache
def _relaxed_device() -> Mechanism:
    """The device without the assumptions."""
    offset = Vec(derivation.CARRIER, (x_C4, y_C4, S.Zero))
    carrier = Part(q.m4, Point("C4", derivation.O, offset), about_pin(J_4, q.m4, offset))
    m = derivation.device(speed_rate=phi_ddot, carrier=carrier)
    bodies = {body.name: body for body in m.bodies}
    at = {action.name: action.at for action in m.assembly.actions}
    inner, spring = bodies["inner half"], m.body("spring", derivation.PLANET)
    m.force("F_F across", inner, at["F_F"], Vec(derivation.PLANET, (F_Fx, F_Fy, S.Zero)), by=spring)
    m.force("F_E across", inner, at["F_E"], Vec(derivation.PLANET, (S.Zero, q.F_Ey, S.Zero)), by=bodies["carrier"])
    m.assembly.unknowns.extend(_OF_A_SIDE)
    return m


@cache
def _relaxed_balances() -> dict[Claimed, Expr]:
    return {e.claims: e.residual for e in balances(_relaxed_device())}


@cache
def _relaxed_relations() -> dict[Quantity, Expr]:
    return relations(_relaxed_device())
