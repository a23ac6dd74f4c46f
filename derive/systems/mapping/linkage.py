"""Two dyads that carry one arm: the four-bar linkage with the arm as its coupler, from its closed loop.

Stated here: a second hinge of the arm keeps its distance from a second fixed hinge, while the crank, which is the
first dyad, turns by ``theta``.
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, S

from ...mechanics.frames import Point, Vec, displacement
from ...quantity import Quantity, Vector
from . import quantities as q
from .dyads import ARM, MOVING_HINGE, ORIGIN, TIP, WORLD
from .train import tip


def _derived(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: four-bar linkage of two dyads")


x_f = _derived("x_f", "m", "follower's moving hinge in the moving frame, x")
y_f = _derived("y_f", "m", "follower's moving hinge in the moving frame, y")
X_f = _derived("X_f", "m", "follower's fixed hinge, X")
Y_f = _derived("Y_f", "m", "follower's fixed hinge, Y")
L_f = _derived("L_f", "m", "length of the follower")
CRANK = Vector("crank", (q.x, q.y, q.X_c, q.Y_c, q.L1))
FOLLOWER = Vector("follower", (x_f, y_f, X_f, Y_f, L_f))

u = _derived("u", "m", "from the crank's moving hinge to the follower's, in the moving frame, x")
v = _derived("v", "m", "from the crank's moving hinge to the follower's, in the moving frame, y")
U = _derived("U", "m", "from the crank's fixed hinge to the follower's, X")
V = _derived("V", "m", "from the crank's fixed hinge to the follower's, Y")
GAPS: dict[Quantity, Expr] = {u: x_f - q.x, v: y_f - q.y, U: X_f - q.X_c, V: Y_f - q.Y_c}
"""Coupler and frame: only they enter the loop, not where the hinges lie."""

of_cos = _derived("of_cos", "m2", "what cos(phi) is multiplied by in the loop")
of_sin = _derived("of_sin", "m2", "what sin(phi) is multiplied by in the loop")
alone = _derived("alone", "m2", "the term of the loop without phi")
closure = _derived("closure", "m2", "square of the distance that the follower bridges, less the square of its length")
by_theta = _derived("by_theta", "m2", "derivative of the closure in the angle of the crank")
by_phi = _derived("by_phi", "m2", "derivative of the closure in the angle of the arm")
across = _derived("across", "m2", "coupler times follower times the sine of the angle from coupler to follower")
along = _derived("along", "m2", "coupler times follower times the cosine of the angle from coupler to follower")

FOLLOWED = Point("follower's moving hinge", TIP, Vec(ARM, (x_f, y_f, S.Zero)))
PIVOT = Point("follower's fixed hinge", ORIGIN, Vec(WORLD, (X_f, Y_f, S.Zero)))
COS, SIN = sp.Symbol("COS", real=True), sp.Symbol("SIN", real=True)


def _driven(vector: Vec) -> Vec:
    """The vector where the crank holds the tip, by coupler and frame."""
    by_gaps = {x_f: q.x + u, y_f: q.y + v, X_f: q.X_c + U, Y_f: q.Y_c + V}
    x, y, z = (sp.expand(c.xreplace(tip()).xreplace(by_gaps)) for c in vector.components)
    return Vec(vector.frame, (x, y, z))


@cache
def residual() -> Expr:
    """What vanishes where the follower fits."""
    gap = _driven(displacement(PIVOT, FOLLOWED, WORLD))
    return gap.dot(gap) - L_f**2


@cache
def loop() -> dict[Quantity, Expr]:
    """The closure as ``of_cos cos(phi) + of_sin sin(phi) + alone``."""
    named = residual().subs({sp.cos(q.phi): COS, sp.sin(q.phi): SIN})
    poly = sp.Poly(sp.rem(sp.expand(named), SIN**2 + COS**2 - 1, SIN), COS, SIN)
    first, second, last = (sp.factor_terms(sp.trigsimp(poly.coeff_monomial(m))) for m in (COS, SIN, 1))
    rest = poly - sp.Poly(first * COS + second * SIN + last, COS, SIN)
    if sp.simplify(rest.as_expr()) != 0:
        raise ValueError(f"the loop holds {rest.as_expr()} besides")
    return {of_cos: first, of_sin: second, alone: last}


def closed() -> dict[Quantity, Expr]:
    """The closure and its derivatives."""
    parts = loop()
    expr = parts[of_cos] * sp.cos(q.phi) + parts[of_sin] * sp.sin(q.phi) + parts[alone]
    return {closure: expr, by_theta: expr.diff(q.theta), by_phi: expr.diff(q.phi)}


def transmission() -> dict[Quantity, Expr]:
    """Angle between coupler and follower at the hinge that joins them, by its sine and cosine."""
    coupler = _driven(displacement(MOVING_HINGE, FOLLOWED, WORLD))
    follower = _driven(displacement(PIVOT, FOLLOWED, WORLD))
    return {across: coupler.cross(follower)[2], along: coupler.dot(follower)}
