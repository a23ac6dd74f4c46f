"""Gear train of the seedling pick-up: pitch curves that roll without slip, ratios, curvature.

Everything is seen along the two centre lines, whose frames turn with the carrier.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, pi

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Vec, Z
from . import quantities as q
from .geometry import ARM, CARRIER, TO_M1, WORLD, along
from .vocabulary import PickupClaim

SUN = Frame("sun, x along O-M1 at phi5 = 0", WORLD, Z, q.beta1)
BACK = Frame("line M1-O", TO_M1, Z, pi)
MIDDLE = Frame("intermediate gear", BACK, Z, q.phi2)
TURNING = Motion({q.phi5: q.dphi5, q.phi2: q.dphi2, q.phi1: q.dphi1})


def turn(frame: Frame, motion: Motion = TURNING) -> Expr:
    """Increment of a frame's angle as seen from the carrier."""
    return motion.spin(frame)[2] - motion.spin(CARRIER)[2]


def slip_on_sun() -> Expr:
    """Speed at which the intermediate gear would slip on the sun, which is at rest, at their contact."""
    axis = TURNING.derivative(along(TO_M1, q.a1))
    contact = TURNING.spin(MIDDLE).resolved(TO_M1).cross(along(TO_M1, -q.R2))
    return (axis + contact)[1]


def helical_slip(motion: Motion) -> Expr:
    """Speed at which the helical gears, equal ones, would slip on each other, seen from the carrier."""
    radius = q.a2 / 2
    return sp.expand(turn(MIDDLE, motion) * radius - turn(ARM, motion) * (-radius))


def ratios(f: Formulas) -> None:
    """Ratios and pitch radii; the ratio of an external pair is counted positive."""
    stage1 = -turn(WORLD) / turn(MIDDLE)
    total = turn(WORLD) / turn(ARM)
    helical = sp.solve(helical_slip(TURNING), q.dphi2)[0]
    carrier = sp.solve(stage1 - q.i1, q.dphi5)[0]
    through = total.subs(q.dphi1, sp.solve(helical_slip(TURNING), q.dphi1)[0]).subs(q.dphi5, carrier)
    still = sp.solve(helical_slip(Motion({**TURNING.rates, q.phi2: S.Zero})), q.dphi1)[0]
    radius = sp.solve(slip_on_sun().subs(q.dphi5, carrier), q.R2)[0]
    gap = along(TO_M1, q.a1) + along(BACK, q.R2).resolved(TO_M1) - along(TO_M1, q.R1)
    f.defines(q.dphi2, helical, PickupClaim.MIDDLE_TURN)
    f.defines(q.i1, stage1, PickupClaim.RATIO_1)
    f.defines(q.iZ, total, PickupClaim.TOTAL_RATIO, named=True)
    f.defines(q.iZ, sp.cancel(through), PickupClaim.TOTAL_RATIO_BY_STAGES)
    f.defines(q.g_locked, (1 / total).subs(q.dphi1, still), PickupClaim.DWELL_RATIO)
    f.defines(q.R2, sp.factor(radius), PickupClaim.MIDDLE_PITCH_RADIUS)
    f.defines(q.R1, sp.solve(gap[0], q.R1)[0], PickupClaim.SUN_PITCH_RADIUS)


def contacts() -> tuple[Vec, Vec]:
    """The contact on the sun and on the intermediate gear, each in its own frame."""
    return along(TO_M1, q.R1).resolved(SUN), along(BACK, q.R2).resolved(MIDDLE)


def curvature_radius(curve: Vec, motion: Motion) -> Expr:
    """Radius of curvature of a plane curve that is run through counter-clockwise as the motion goes."""
    x, y = curve.components[:2]
    dx, dy = motion.rate(x), motion.rate(y)
    ddx, ddy = motion.rate(dx), motion.rate(dy)
    bend = sp.simplify(dx * ddy - dy * ddx)
    return sp.simplify(dx**2 + dy**2) ** sp.Rational(3, 2) / bend


def curves(f: Formulas) -> None:
    """Pitch curves and their curvature; contacts run counter-clockwise on the sun, clockwise on the other gear."""
    sun, middle = contacts()
    rolling = Motion({q.phi5: S.One, q.phi2: q.R1 / q.R2, q.R1: q.dR1, q.R2: -q.dR1, q.dR1: q.ddR1})
    f.defines(q.x1, sun[0], PickupClaim.PITCH_CURVE.of("sun", "x"))
    f.defines(q.y1, sun[1], PickupClaim.PITCH_CURVE.of("sun", "y"))
    f.defines(q.x2, middle[0], PickupClaim.PITCH_CURVE.of("intermediate gear", "x"))
    f.defines(q.y2, middle[1], PickupClaim.PITCH_CURVE.of("intermediate gear", "y"))
    f.defines(q.rho1, curvature_radius(sun, rolling), PickupClaim.CURVATURE_RADIUS.of("sun"))
    f.defines(q.rho2, -curvature_radius(middle, rolling), PickupClaim.CURVATURE_RADIUS.of("intermediate gear"))


def state(f: Formulas) -> None:
    """Claims about the gear train."""
    ratios(f)
    curves(f)
