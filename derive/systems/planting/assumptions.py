"""What the balances of the planting device lose by its assumptions: derived again with these lifted.

Lifted are constant speed and balance of the carrier, and the directions in which spring and cam act on the nozzle.
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, S

from ...equations import Claimed, among
from ...mechanics.bodies import Part, about_pin
from ...mechanics.frames import Point, Vec
from ...mechanics.mechanism import Mechanism
from ...quantity import Quantity
from . import claims, derivation
from . import quantities as q

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


def lift(claim: Claimed, printed: Expr) -> Expr | None:
    """The balance that a claim names, in the quantities of a printed one, while the assumptions are lifted."""
    if claim not in _balances():
        return None
    given, _ = claims.common(printed, among(claims.claims(), claim).residual)
    kept = claims.eliminated(_balances()[claim], given.free_symbols, _relations())
    return claims.canonical(kept.xreplace(_ACCELERATIONS))


_ACCELERATIONS = {
    q.Omega_dot: phi_ddot + q.phi72_ddot,
    q.twin(q.Omega_dot): phi_ddot + q.twin(q.phi72_ddot),
}


@cache
def _lifted() -> Mechanism:
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
def _balances() -> dict[Claimed, Expr]:
    return {e.claims: e.residual for e in claims.balances(_lifted())}


@cache
def _relations() -> dict[Quantity, Expr]:
    return claims.relations(_lifted())
