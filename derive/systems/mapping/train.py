"""From the angle curve to a two-stage non-circular planetary gear train (patent CN107654585B, steps 3 to 5).

Stated are that the first driver is fixed, that the arm turns with the second follower, that two external meshes on a
carrier roll at the pitch points, and that the arm returns to its position after a revolution of the carrier. The
ratios of the two stages are in a constant proportion, which the rotations of the first stage determine.
"""

from __future__ import annotations

import sympy as sp
from sympy import Abs, Expr, S, pi

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, displacement
from ...mechanics.frames import Z as UP
from ...quantity import Quantity
from . import quantities as q
from .dyads import ARM, FIXED_HINGE, MOVING_HINGE, ORIGIN, WORLD
from .quantities import MappingClaim

TURN = 2 * pi
CARRIER = Frame("carrier", WORLD, UP, q.theta)
MOTION = Motion(rates={q.theta: q.w1, q.phi: q.w2})

CARRIED_HINGE = Point("moving hinge, on the carrier", FIXED_HINGE, Vec(CARRIER, (q.L1, S.Zero, S.Zero)))
ANGLE_CURVE = ARM.angle - CARRIER.angle


def tip_position() -> dict[Quantity, Expr]:
    """Return the position of the tip: carrier and arm meet in the moving hinge."""
    by_arm, by_carrier = (displacement(ORIGIN, hinge, WORLD) for hinge in (MOVING_HINGE, CARRIED_HINGE))
    return sp.solve([by_arm[0] - by_carrier[0], by_arm[1] - by_carrier[1]], [q.d1, q.d2])


def relative_rate(frame: Frame) -> Expr:
    """Return the rate of a body relative to the carrier."""
    return MOTION.spin(frame)[2] - MOTION.spin(CARRIER)[2]


def curve_slope() -> Expr:
    """Return the slope of the angle curve."""
    return MOTION.rate(ANGLE_CURVE) / MOTION.rate(CARRIER.angle)


def total_ratio() -> Expr:
    """Return the total ratio by the rates."""
    return sp.cancel(relative_rate(WORLD) / relative_rate(ARM))


def ratio_by_slope() -> Expr:
    """Return the total ratio by the slope of the angle curve."""
    speed = sp.solve(curve_slope() - q.slope, q.w2)[0]
    return sp.cancel(total_ratio().xreplace({q.w2: speed}))


def curve_rise() -> Expr:
    """Return the change of the angle curve over a revolution of the carrier, after which the arm is as before."""
    return sp.expand(ANGLE_CURVE.xreplace({q.theta: q.theta + TURN}) - ANGLE_CURVE)


def pitch_radii(ratio: Quantity, radius: Quantity) -> tuple[Expr, Expr]:
    """Return the pitch radii: the driver's by the ratio, the follower's by the driver's, the symbol ``radius``.

    At the pitch point, between the centres, both gears have one velocity. An external mesh reverses the rotation.
    """
    driver, follower, spin = sp.Symbol("driver"), sp.Symbol("follower"), sp.Symbol("spin")
    centre = Point("centre of the driver")
    other = Point("centre of the follower", centre, Vec(CARRIER, (q.a, S.Zero, S.Zero)))
    pitch = Point("pitch point", centre, Vec(CARRIER, (driver, S.Zero, S.Zero)))
    spins = Vec(CARRIER, (S.Zero, S.Zero, spin)), Vec(CARRIER, (S.Zero, S.Zero, -spin / ratio))
    arms = displacement(centre, pitch, CARRIER), displacement(other, pitch, CARRIER)
    slip = spins[0].cross(arms[0]) - spins[1].cross(arms[1])
    (by_ratio,) = sp.solve(slip[1], driver)
    (by_driver,) = sp.solve(follower + arms[1][0], follower)
    return sp.factor(by_ratio), by_driver.xreplace({driver: radius})


def polar_rates() -> tuple[Expr, ...]:
    """Return the rates of the polar angles at the contact per carrier angle, each in its positive direction.

    The contact is fixed in the carrier; on a gear it moves opposite to the gear's rotation.
    """
    first = -relative_rate(WORLD) / q.w1
    middle = -first / q.i1
    last = -middle / q.i2
    return first, -middle, -middle, last


def split_ratios() -> dict[Quantity, Expr]:
    """Return the ratios of the stages in the proportion x_s^2; their product is the total ratio."""
    first = sp.Dummy(positive=True)
    total, share = sp.Dummy(positive=True), sp.Dummy(positive=True)
    (root,) = sp.solve(first / (total / first) - share**2, first)
    back = {total: q.i, share: q.x_s}
    return {q.i1: root.xreplace(back), q.i2: sp.simplify(total / root).xreplace(back)}


def first_follower_rotation() -> Expr:
    """Return the integral of its polar rate over a revolution; constant factors are taken out of the integral."""
    rate = polar_rates()[1].xreplace(split_ratios())
    fixed, moving = rate.as_independent(q.i)
    if sp.simplify(moving - 1 / sp.sqrt(q.i)) != 0:
        raise ValueError(f"{moving} is not the quantity of which the mean is defined")
    return TURN * fixed * q.mean_root


def second_follower_rotation() -> Expr:
    """Return the integral of its polar rate over a revolution: a multiple of the slope, whose integral is the rise."""
    rate = polar_rates()[3].xreplace({q.i2: q.i / q.i1}).xreplace({q.i: ratio_by_slope()})
    return sp.cancel(rate / q.slope) * curve_rise()


def add_train(f: Formulas) -> None:
    """Add the equations of tip path, angle curve, ratios, split and pitch curves."""
    for name, expr in tip_position().items():
        f.defines(name, expr, MappingClaim.TIP_BY_ANGLES.of(name))
    f.defines(q.y_rel, ANGLE_CURVE, MappingClaim.CURVE_ORDINATE)
    f.holds(MappingClaim.CURVE_ENDS, Abs(q.y_last - q.y_first) - Abs(curve_rise()))
    f.defines(q.slope, sp.expand(curve_slope()), MappingClaim.CURVE_SLOPE)
    f.defines(q.i, total_ratio(), MappingClaim.TOTAL_RATIO)
    f.holds(MappingClaim.TOTAL_RATIO_BY_SLOPE, q.i - ratio_by_slope())
    (closing,) = sp.solve(first_follower_rotation() - TURN, q.x_s)
    f.defines(q.x_s, closing, MappingClaim.SPLIT_PARAMETER)
    for name, expr in split_ratios().items():
        f.defines(name, expr, MappingClaim.STAGE_RATIO.of(name))
    for ratio, names in ((q.i1, (q.r1, q.r2)), (q.i2, (q.r3, q.r4))):
        for name, expr in zip(names, pitch_radii(ratio, names[0]), strict=True):
            f.defines(name, expr, MappingClaim.PITCH_RADIUS.of(name))
    for gear, name, expr in zip(q.GEARS, q.POLAR_RATES, polar_rates(), strict=True):
        f.defines(name, expr, MappingClaim.POLAR_ANGLE.of(gear))
    f.defines(q.turn2, first_follower_rotation(), MappingClaim.FIRST_FOLLOWER_TURN)
    f.defines(q.turn4, second_follower_rotation(), MappingClaim.SECOND_FOLLOWER_TURN)
