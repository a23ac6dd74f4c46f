"""Derived equations of the planting device for each claim of a paper, also without the paper's
assumptions.

The assumptions that can be relaxed are the constant speed and the balance of the carrier, and the
directions in which spring and cam act on the nozzle.
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
from ...equations import (
    Balance,
    Claimed,
    Equation,
    by_claim,
    defining_equation,
    find_claim,
    stated_equation,
)
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

INTERMEDIATE = q.TABLE.select(
    "L_AC1 L_AC2 theta30 theta40 theta3 theta4 mu M_T phi_P1 phi_P2 phi_Q1 phi_Q2 F_fP F_fQ"
)
"""Quantities of the paper that link forces and geometry."""
OFFSETS: dict[sp.Symbol, Expr] = {
    q.phi72_dot: -q.omega,
    q.phi52_dot: -q.omega,
    q.x_C1: q.x_A,
    q.y_C1: q.y_A,
    q.z_C1: q.z_A,
    q.x_C2: q.x_A,
    q.y_C2: q.y_A,
    q.z_C2: q.z_A,
    q.x_CA: q.x_A1,
    q.y_CA: q.y_A1,
    q.x_CB: q.x_B1,
    q.y_CB: q.y_B1,
}
"""Subtrahends of quantities that occur in differences: rates relative to the carrier, coordinates
relative to a pin.
"""
SIDES = {s: -s for s in q.TABLE.select("x_A1 y_A1 x_B1 y_B1 x_P y_P")}
"""Coordinates on the carrier and on the sun's pitch curve have opposite signs on the two sides."""


@cache
def derive_claims() -> dict[Claimed, Equation]:
    """Return the derived equations by their claims."""
    m = derivation.build_device()
    return by_claim(
        [
            *derive_balances(m),
            *_cam_equations(m),
            *_point_equations(m),
            *_tooth_equations(
                m, "P", derivation.CONTACT_P, q.TABLE.select("M_P F_NP phi_P1 phi_P2 F_fP")
            ),
            *_tooth_equations(
                m, "Q", derivation.CONTACT_Q, q.TABLE.select("M_Q F_NQ phi_Q1 phi_Q2 F_fQ")
            ),
        ]
    )


def derive_balances(m: Mechanism) -> list[Equation]:
    """Return the balances of every body of a side, and of sun and carrier with both sides."""
    shared = twins.shared_balances(m, twins.Other(q.phi, q.twin, twins.side_quantities(m)))
    return [e for e in (*m.equations(), *shared) if e.defines is None]


def _force_law(m: Mechanism, symbol: Quantity) -> Expr:
    return m.assembly.law(symbol).expr


def _cam_equations(m: Mechanism) -> list[Equation]:
    """Return the components of the cam's force, its angle to the roller's path, and its moment."""
    frictionless = {q.mu1: S.Zero}
    x, z = (_force_law(m, f).xreplace(frictionless) / q.F_E for f in (q.F_Ex, q.F_Ez))
    swing = q.theta1 + q.psi0
    path_x, path_z = sp.sin(swing), sp.cos(swing)
    angle = sp.atan((path_x * z - path_z * x) / (path_x * x + path_z * z))
    moment = -(q.x_E * S.Zero - q.y_E * q.F_Ex)
    return [
        defining_equation("pressure angle of the cam", q.mu, angle),
        defining_equation("force of the cam on the roller, x'", q.F_Ex, _force_law(m, q.F_Ex)),
        stated_equation("force of the cam on the roller, y'", q.F_Ey, q.F_Ey),
        defining_equation("force of the cam on the roller, z'", q.F_Ez, _force_law(m, q.F_Ez)),
        defining_equation("moment of the cam force about the planet's axis", q.M_T, moment),
    ]


def _point_equations(m: Mechanism) -> list[Equation]:
    """Return the coordinates of points on the swinging half, Cartesian and polar."""
    steps = {s.symbol: s.expr for s in m.named}
    equations = [
        defining_equation(f"place of {name}, {axis}'", symbol, steps[symbol])
        for name, axis, symbol in (
            ("the roller", "x", q.x_E),
            ("the roller", "z", q.z_E),
            ("C1", "x", q.x_C1),
            ("C1", "z", q.z_C1),
            ("C2", "x", q.x_C2),
            ("C2", "z", q.z_C2),
        )
    ]
    for name, (x, _, z), at, length, turned, closed in (
        ("C1", q.c_C1, (q.x_C1, q.z_C1), q.L_AC1, q.theta3, q.theta30),
        ("C2", q.c_C2, (q.x_C2, q.z_C2), q.L_AC2, q.theta4, q.theta40),
    ):
        down = sp.atan2(q.z_A - at[1], at[0] - q.x_A)
        equations += [
            defining_equation(f"distance of {name} from the hinge", length, sp.sqrt(x**2 + z**2)),
            defining_equation(
                f"angle of the line from the hinge to {name}, closed", closed, sp.atan2(-z, x)
            ),
            defining_equation(f"angle of the line from the hinge to {name}", turned, down),
        ]
    return equations


def _tooth_equations(
    m: Mechanism,
    tag: str,
    contact: GearContact,
    quantities: tuple[Quantity, ...],
) -> list[Equation]:
    """Return the directions and sizes of normal force and friction on the flank that can transmit
    the moment.

    ``quantities`` are moment, normal force, directions of normal force and friction, friction
    force.
    """
    moment, normal, normal_angle, friction_angle, drag = quantities
    force = [next(u for u in m.unknowns if u.name == f"F_{tag}{axis}") for axis in "xy"]
    return [
        defining_equation(
            f"direction of the normal force at {tag}",
            normal_angle,
            switch(moment, contact.normal(1), contact.normal(-1)),
        ),
        defining_equation(
            f"direction of friction at {tag}",
            friction_angle,
            switch(moment, contact.across(1), contact.across(-1)),
        ),
        defining_equation(f"normal force at {tag}", normal, _force_law(m, normal)),
        stated_equation(f"friction force at {tag}", drag - normal * sp.tan(q.mu2), drag),
        *(
            defining_equation(f"tooth force at {tag}, {axis}", f, _force_law(m, f))
            for axis, f in zip("xy", force, strict=True)
        ),
    ]


@cache
def _cached_relations() -> dict[Quantity, Expr]:
    return derive_relations(derivation.build_device())


def derive_relations(m: Mechanism) -> dict[Quantity, Expr]:
    """Return unknowns that a paper need not name in terms of others: constraint moments, moments of
    tooth forces.

    Raises ClaimError if the mechanism lacks one of the balances.
    """
    equations = by_claim(m.equations())
    from_balance = {
        "M_Az": Balance("inner half", "moment", "z", "planet", "A"),
        "M_Aoz": Balance("outer half", "moment", "z", "planet", "A outer"),
        "F_A1z": Balance("middle body", "force", "z", "frame"),
        "M_K": Balance("outer half", "moment", "y", "planet", "A outer"),
    }
    unknowns = {u.name: u for u in m.unknowns}
    relations = {
        unknowns[name]: solve_linear(find_claim(equations, balance), unknowns[name])
        for name, balance in from_balance.items()
    }
    at_Q = displacement(derivation.B1, derivation.Q, derivation.WORLD)
    relations[q.M_P] = (q.y_P - q.y_A1) * q.F_Px - (q.x_P - q.x_A1) * q.F_Py
    relations[q.M_Q] = at_Q[1] * q.F_Qx - at_Q[0] * q.F_Qy
    return relations


@cache
def derive_definitions() -> dict[sp.Symbol, Expr]:
    """Return quantities of both sides by what they are in other quantities, the nearest first."""
    other = twins.Other(q.phi, q.twin, side_quantities())
    formulas: dict[sp.Symbol, Expr] = {
        step.symbol: step.expr for step in derivation.build_device().named
    }
    formulas |= {
        e.defines: e.defines - e.residual for e in derive_claims().values() if e.defines is not None
    }
    formulas |= derive_reactions() | {q.alpha_n: pi / 9}
    both = formulas | {q.twin(s): other(e) for s, e in formulas.items()}
    return {s: e for s, e in both.items() if s not in e.free_symbols} | _paper_coordinates()


def derive_reactions() -> dict[sp.Symbol, Expr]:
    """Return the actions of both sides that a paper need not name, in other quantities."""
    other = twins.Other(q.phi, q.twin, side_quantities())
    relations = _cached_relations()
    return {**relations, **{q.twin(s): other(e) for s, e in relations.items()}}


def to_canonical_form(expr: Expr) -> Expr:
    """Return an expression in the quantities that papers use, expanded."""
    return reduce_sine_squares(sp.expand(to_paper_quantities(expr), trig=False))


def to_paper_quantities(expr: Expr) -> Expr:
    """Replace body-fixed offsets by coordinates, absolute rates by relative ones, side 2's
    coordinates by side 1's.
    """
    return expr.xreplace(_paper_coordinates()).xreplace(
        {q.Omega: q.omega + q.phi72_dot, q.Omega_dot: q.phi72_ddot}
    )


def _paper_coordinates() -> dict[sp.Symbol, Expr]:
    """Return the offsets that are fixed in a body in terms of the coordinates of their end
    points.
    """
    offsets: dict[sp.Symbol, Expr] = {q.twin(s): other for s, other in SIDES.items()}
    c, s = sp.cos(q.theta1), sp.sin(q.theta1)
    for offset, (x, y, z) in (
        (q.c_C1, (q.x_C1, q.y_C1, q.z_C1)),
        (q.c_C2, (q.x_C2, q.y_C2, q.z_C2)),
    ):
        dx, dz = x - q.x_A, z - q.z_A
        offsets |= {offset[0]: dx * c - dz * s, offset[1]: y - q.y_A, offset[2]: dx * s + dz * c}
    dx, dy = q.x_CB - q.x_B1, q.y_CB - q.y_B1
    c, s = sp.cos(q.alpha), sp.sin(q.alpha)
    return offsets | {q.c_CBx: dx * c - dy * s, q.c_CBy: dx * s + dy * c}


def reduce_sine_squares(expr: Expr) -> Expr:
    """Return an expanded expression with every square of a sine in terms of the cosine, so that
    they add up to 1.
    """
    for _ in range(8):
        reduced = sp.expand(expr.replace(_is_sine_square, _from_cosine), trig=False)
        if reduced == expr:
            return expr
        expr = reduced
    return expr


def _is_sine_square(expr: sp.Basic) -> bool:
    return (
        isinstance(expr, sp.Pow)
        and isinstance(expr.base, sp.sin)
        and expr.exp.is_Integer
        and expr.exp >= 2
    )


def _from_cosine(power: Expr) -> Expr:
    angle = power.base.args[0]
    return power.base ** (power.exp - 2) * (1 - sp.cos(angle) ** 2)


@cache
def side_quantities() -> frozenset[Quantity]:
    """Return the quantities that differ between the sides."""
    return twins.side_quantities(derivation.build_device()) | set(INTERMEDIATE)


@cache
def describe_actions() -> dict[sp.Symbol, str]:
    """Return the meanings of the mechanism's forces and moments, the same for both sides."""
    unknowns = derivation.build_device().assembly.unknowns
    return {symbol: u.meaning for u in unknowns for symbol in (u, q.twin(u))}


def to_common_quantities(printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
    """Return two balances in the same quantities: those of only one balance are expressed by those
    of both.
    """
    reduced = _substitute_definitions(printed, derived)
    derived = eliminate_unknowns(derived, reduced.free_symbols, _cached_relations())
    return to_paper_quantities(reduced), to_canonical_form(derived)


def list_comparisons(printed: Expr, derived: Expr) -> list[tuple[Expr, Expr]]:
    """Return two balances with none, some and all of the unknowns eliminated that only the derived
    one contains.
    """
    reduced = _substitute_definitions(printed, derived)
    extra = derived.free_symbols - reduced.free_symbols
    relations = {s: e for s, e in _cached_relations().items() if {s, q.twin(s)} & extra}
    subsets = (
        subset for size in range(len(relations) + 1) for subset in combinations(relations, size)
    )
    sums = (
        eliminate_unknowns(derived, reduced.free_symbols, {s: relations[s] for s in subset})
        for subset in subsets
    )
    return [(to_paper_quantities(reduced), to_canonical_form(expr)) for expr in sums]


def _substitute_definitions(printed: Expr, derived: Expr) -> Expr:
    """Return a printed balance without the defined quantities that the derived one does not
    contain.
    """
    definitions = {
        e.defines: e.defines - e.residual for e in derive_claims().values() if e.defines is not None
    }
    return eliminate_unknowns(printed, derived.free_symbols, definitions)


def eliminate_unknowns(
    expr: Expr, retained: set[sp.Symbol], definitions: Mapping[Quantity, Expr]
) -> Expr:
    """Return ``expr`` without the defined quantities of both sides that are not ``retained``."""
    other = twins.Other(q.phi, q.twin, side_quantities())
    for symbol, definition in definitions.items():
        for defined_symbol, value in ((symbol, definition), (q.twin(symbol), other(definition))):
            if defined_symbol in expr.free_symbols and defined_symbol not in retained:
                expr = expr.xreplace({defined_symbol: value})
    return expr


@cache
def compute_reference_cycle(points: int) -> tuple[Mapping[sp.Symbol, mpf], ...]:
    """Return all quantities over the reference cycle, with the intermediate ones of the paper."""
    return tuple(
        _add_intermediate(_add_reactions(NumericPoint(values)))
        for values in cycle.compute_reference_cycle(points)
    )


@cache
def derive_reaction_steps() -> tuple[Let, ...]:
    """Return the steps that give every force and moment in the derived equations of one side."""
    m = derivation.build_device()
    named = frozenset().union(*(e.residual.free_symbols for e in derive_claims().values()))
    return ordered(m.equations(), m.unknowns, [u for u in m.unknowns if u in named]).lets()


@cache
def _all_steps() -> tuple[tuple[Quantity, Expr], ...]:
    """Return every step of the motion and of the reactions, for both sides."""
    other = twins.Other(q.phi, q.twin, side_quantities())
    steps = [
        (step.symbol, step.expr)
        for step in (*derivation.build_device().named, *derive_reaction_steps())
    ]
    return tuple(pair for s, e in steps for pair in ((s, e), (q.twin(s), other(e))))


def _add_reactions(point: NumericPoint) -> NumericPoint:
    """Add the quantities of both sides that no model reports."""
    for symbol, expr in _all_steps():
        if symbol not in point:
            point.set(symbol, point(expr))
    return point


def _add_intermediate(point: NumericPoint) -> dict[sp.Symbol, mpf]:
    definitions = {
        e.defines: e.defines - e.residual
        for e in derive_claims().values()
        if e.defines in INTERMEDIATE
    }
    for symbol in INTERMEDIATE:
        point.set(symbol, point(definitions[symbol]))
    return point.values()


def draw_admissible_point(rng: random.Random) -> dict[sp.Symbol, mpf]:
    """Draw a point on the rising flank of the cam, with consistent kinematics and arbitrary
    reactions.

    The rocker stays within a right angle of x', so that the paper's arctangent is the pressure
    angle.
    """
    m = derivation.build_device()
    everything = {*q.TABLE.values(), *m.unknowns}
    values: dict[sp.Symbol, Expr] = {
        s: sp.Rational(rng.randint(101, 999), rng.randint(301, 699))
        for s in sorted(everything | {q.twin(s) for s in everything}, key=str)
    }
    values |= {q.alpha_n: pi / 9, q.T2_0: S.Zero, q.T2: sp.Rational(rng.randint(23, 29), 10)}
    values |= dict(
        zip((*q.delta_r, *q.delta_f), map(sp.Rational, ("2.2", "3.1", "4.2", "5.1")), strict=True)
    )
    values |= {
        q.psi0: sp.Rational(rng.randint(-30, 20), 100),
        q.H: sp.Rational(rng.randint(20, 45), 100),
    }
    values |= {s: values[s] * rng.choice((-1, 1)) for s in (q.M_P, q.M_Q)}
    return _consistent(values, m)


def _consistent(values: dict[sp.Symbol, Expr], m: Mechanism) -> dict[sp.Symbol, mpf]:
    """Return the kinematics and the intermediate quantities that follow from the values."""
    point = NumericPoint(values)
    for step in m.named:
        point.set(step.symbol, point(step.expr))
    return _add_intermediate(point)


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
ZERO: dict[sp.Symbol, str] = (
    _SHARED | _OF_A_SIDE | {q.twin(s): why for s, why in _OF_A_SIDE.items()}
)
"""Quantities that are zero by assumption, each with the reason."""


def relax_balance(claim: Claimed, printed: Expr) -> Expr | None:
    """Return the balance of a claim without the assumptions, in the quantities of a printed one, or
    None.
    """
    if claim not in _relaxed_balances():
        return None
    reduced, _ = to_common_quantities(printed, find_claim(derive_claims(), claim).residual)
    balance = eliminate_unknowns(
        _relaxed_balances()[claim], reduced.free_symbols, _relaxed_relations()
    )
    return to_canonical_form(balance.xreplace(_ACCELERATIONS))


_ACCELERATIONS = {
    q.Omega_dot: phi_ddot + q.phi72_ddot,
    q.twin(q.Omega_dot): phi_ddot + q.twin(q.phi72_ddot),
}


@cache
def _relaxed_device() -> Mechanism:
    """Return the device without the assumptions."""
    offset = Vec(derivation.CARRIER, (x_C4, y_C4, S.Zero))
    carrier = Part(q.m4, Point("C4", derivation.O, offset), about_pin(J_4, q.m4, offset))
    m = derivation.build_device(speed_rate=phi_ddot, carrier=carrier)
    bodies = {body.name: body for body in m.bodies}
    at = {action.name: action.at for action in m.assembly.actions}
    inner, spring = bodies["inner half"], m.body("spring", derivation.PLANET)
    m.force("F_F across", inner, at["F_F"], Vec(derivation.PLANET, (F_Fx, F_Fy, S.Zero)), by=spring)
    m.force(
        "F_E across",
        inner,
        at["F_E"],
        Vec(derivation.PLANET, (S.Zero, q.F_Ey, S.Zero)),
        by=bodies["carrier"],
    )
    m.assembly.unknowns.extend(_OF_A_SIDE)
    return m


@cache
def _relaxed_balances() -> dict[Claimed, Expr]:
    return {e.claims: e.residual for e in derive_balances(_relaxed_device())}


@cache
def _relaxed_relations() -> dict[Quantity, Expr]:
    return derive_relations(_relaxed_device())
