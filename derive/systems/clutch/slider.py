"""Crank, rod and sleeve of the clutch on their way, and the rod and gears for a travel (shi2021 2.4), derived.

The x axis is the guide AC, from the crank's axis A to the sleeve's pin C; the crank comes back to it as C moves away.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, cos, pi, sin, sqrt

from ...branches import clip
from ...formulas import Formulas
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from ...model import let
from ...quantity import Quantity, Vector
from . import quantities as q
from .motion import MESH, WORLD, crank_angle, gear_rate


def _found(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: clutch")


CRANK = Vector("crank", (q.l_AB, q.l_BC, q.l_AC))
SHIFT = _found("shift", "m", "way of the sleeve from its engaged place")
ANGLE = _found("crank_angle", "rad", "angle of the crank from the guide AC")
X_B = _found("pin_x", "m", "crank pin B, along the guide")
Y_B = _found("pin_y", "m", "crank pin B, across the guide")
ROD = _found("rod_angle", "rad", "angle of the rod with the guide")
LEVER = _found("lever", "m", "way of the sleeve per rotation of the crank")
TOOTH = _found("tooth_force", "N", "tangential force of the rack on the crank gear while the sleeve is pushed")
SIDE = _found("side_force", "N", "force of the guide on the sleeve, across the way")
SPAN = _found("span", "m", "distance of the crank gear's axis from the hinge of the link: both pitch radii")
LIFT = _found("lift", "rad", "turn of the link while the sleeve makes its travel")
LIMIT = _found("alpha_max", "rad", "inclination of the link when the sleeve has made its travel")
SHARE = _found("share", "1", "travel as a share of the largest that this crank makes in that rotation")
RODS = (_found("l_BC_1", "m", "rod, the one"), _found("l_BC_2", "m", "rod, the other"))


def slider(f: Formulas) -> None:
    """The linkage along the way, what it takes to push the sleeve, its gears, and its rod for a wanted travel."""
    crank = Frame("crank", WORLD, Z, ANGLE)
    A = Point("A")
    B = Point("B", A, Vec(crank, (q.l_AB, S.Zero, S.Zero)))
    C = Point("C", A, Vec(WORLD, (q.l_AC + SHIFT, S.Zero, S.Zero)))
    pin, rod = displacement(A, B, WORLD), displacement(C, B, WORLD)
    angle = crank_angle(q.l_AC + SHIFT)
    pose = (
        let(ANGLE, angle, "the loop A-B-C closes"),
        let(X_B, pin[0], "the loop A-B-C closes"),
        let(Y_B, pin[1], "the loop A-B-C closes"),
        let(ROD, sp.atan2(rod[1], -rod[0]), "the loop A-B-C closes"),
        let(LEVER, -1 / angle.diff(SHIFT), "the loop A-B-C closes"),
    )
    torque = sp.Dummy("torque")
    (needed,) = sp.solve(torque - q.F1 * LEVER, torque)
    push = (
        *pose,
        let(TOOTH, needed / q.r_A, "virtual work of rack and sleeve"),
        let(SIDE, q.F1 * sp.tan(ROD), "balance of the sleeve: the rod pulls along itself"),
    )
    f.function("slider", (SHIFT, CRANK), *pose)
    f.function("push", (SHIFT, CRANK, q.F1, q.r_A), *push, gives=(LEVER, ROD, TOOTH, SIDE))
    _drive(f)
    _rod(f)


def pin_distance(angle: Expr) -> Expr:
    """Distance of the sleeve's pin C from the crank's axis A at an angle of the crank: the loop A-B-C closes."""
    distance = sp.Dummy("distance")
    A = Point("A")
    B = Point("B", A, Vec(Frame("crank", WORLD, Z, angle), (q.l_AB, S.Zero, S.Zero)))
    rod = displacement(B, Point("C", A, Vec(WORLD, (distance, S.Zero, S.Zero))), WORLD)
    ends = sp.solve(sp.expand(rod.dot(rod)) - q.l_BC**2, distance)
    return next(end for end in ends if end.subs({q.l_AB: 1, q.l_BC: 2, angle: pi / 2}) > 0)


def _drive(f: Formulas) -> None:
    """Pitch radii for a ratio at a fixed distance of axes, and how far the link turns for a rotation of the crank."""
    radii = sp.solve([q.r_A + q.r_D - SPAN, q.r_A - q.k * q.r_D], (q.r_A, q.r_D))
    (alpha,) = sp.solve((gear_rate() - 1) * (q.alpha - MESH) - q.theta_Amax, q.alpha)
    steps = (
        let(q.r_A, radii[q.r_A], "both pitch circles touch"),
        let(q.r_D, radii[q.r_D], "both pitch circles touch"),
        let(LIMIT, alpha, "rotation of the crank gear relative to the link"),
        let(LIFT, sp.expand(alpha - MESH), "rotation of the crank gear relative to the link"),
    )
    f.function("drive", (q.k, SPAN, q.gamma, q.theta_Amax), *steps)


def _rod(f: Formulas) -> None:
    """Both rods with which the crank makes a travel in a rotation: B is as far from C before as after.

    P cos(angle) + Q sin(angle) = K at the engaged place; both sides of the direction of (P, Q) solve it.
    """
    start = sp.Dummy("start", real=True)

    def squared(angle: Expr, distance: Expr) -> Expr:
        return (distance - q.l_AB * cos(angle)) ** 2 + (q.l_AB * sin(angle)) ** 2

    gap = squared(start, q.l_AC) - squared(start - q.theta_Amax, q.l_AC + q.c)
    opened = sp.expand(sp.expand(gap, trig=True))
    opened = sp.expand(
        opened.subs(sin(start) ** 2, 1 - cos(start) ** 2).subs(sin(q.theta_Amax) ** 2, 1 - cos(q.theta_Amax) ** 2)
    )
    P, Q = opened.coeff(cos(start)), opened.coeff(sin(start))
    K = -sp.expand(opened - P * cos(start) - Q * sin(start))
    if K.has(start):
        raise ValueError("the condition on the rod is not linear in the crank's direction")
    share = K / sqrt(P**2 + Q**2)
    aside = sp.acos(clip(SHARE, S.NegativeOne, S.One))
    rods = (
        let(symbol, sqrt(squared(sp.atan2(Q, P) + sign * aside, q.l_AC)), "rod for a travel in a rotation")
        for symbol, sign in zip(RODS, (1, -1), strict=True)
    )
    steps = (let(SHARE, share, "rod for a travel in a rotation"), *rods)
    f.function("rod", (q.l_AB, q.l_AC, q.c, q.theta_Amax), *steps)
