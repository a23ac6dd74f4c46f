"""From the angle curve to a two-stage non-circular planetary gear train (patent CN107654585B, steps 3 to 5).

Stated here: the first driver stands still, the arm turns with the second follower, two external meshes on a carrier
roll at the pitch points, the arm comes back to its place after a turn of the carrier. The ratios of the two stages
stand in a fixed proportion, which the turns of the first stage decide.
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


def tip() -> dict[Quantity, Expr]:
    """Place of the tip: carrier and arm meet in the moving hinge."""
    by_arm, by_carrier = (displacement(ORIGIN, hinge, WORLD) for hinge in (MOVING_HINGE, CARRIED_HINGE))
    return sp.solve([by_arm[0] - by_carrier[0], by_arm[1] - by_carrier[1]], [q.d1, q.d2])


def relative_rate(frame: Frame) -> Expr:
    """Rate of a body relative to the carrier."""
    return MOTION.spin(frame)[2] - MOTION.spin(CARRIER)[2]


def curve_slope() -> Expr:
    return MOTION.rate(ANGLE_CURVE) / MOTION.rate(CARRIER.angle)


def total_ratio() -> Expr:
    return sp.cancel(relative_rate(WORLD) / relative_rate(ARM))


def ratio_by_slope() -> Expr:
    speed = sp.solve(curve_slope() - q.slope, q.w2)[0]
    return sp.cancel(total_ratio().xreplace({q.w2: speed}))


def rise() -> Expr:
    """Change of the angle curve over a turn of the carrier, after which the arm stands as before."""
    return sp.expand(ANGLE_CURVE.xreplace({q.theta: q.theta + TURN}) - ANGLE_CURVE)


def pitch_radii(ratio: Quantity, radius: Quantity) -> tuple[Expr, Expr]:
    """Pitch radii: the driver's by the ratio, the follower's by that of the driver, which is named ``radius``.

    The pitch point lies between the centres; there both gears have one velocity. An external mesh reverses the sense.
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
    """Rates of the polar angles at the contact, per carrier angle, each in the sense that makes it positive.

    The contact stands in the carrier; on a gear it moves against the gear's own rotation.
    """
    first = -relative_rate(WORLD) / q.w1
    middle = -first / q.i1
    last = -middle / q.i2
    return first, -middle, -middle, last


def split() -> dict[Quantity, Expr]:
    """Ratios of the stages in a fixed proportion, x_s^2, their product being the total ratio."""
    first = sp.Dummy(positive=True)
    total, share = sp.Dummy(positive=True), sp.Dummy(positive=True)
    (root,) = sp.solve(first / (total / first) - share**2, first)
    back = {total: q.i, share: q.x_s}
    return {q.i1: root.xreplace(back), q.i2: sp.simplify(total / root).xreplace(back)}


def turn_of_first_follower() -> Expr:
    """Integral of its polar rate over a turn; what does not change with the carrier angle leaves the integral."""
    rate = polar_rates()[1].xreplace(split())
    fixed, moving = rate.as_independent(q.i)
    if sp.simplify(moving - 1 / sp.sqrt(q.i)) != 0:
        raise ValueError(f"{moving} is not what the mean is taken of")
    return TURN * fixed * q.mean_root


def turn_of_second_follower() -> Expr:
    """Integral of its polar rate over a turn: the rate is a multiple of the slope, whose integral is the rise."""
    rate = polar_rates()[3].xreplace({q.i2: q.i / q.i1}).xreplace({q.i: ratio_by_slope()})
    return sp.cancel(rate / q.slope) * rise()


def state(f: Formulas) -> None:
    """Tip path, angle curve, ratios, split, pitch curves."""
    for name, expr in tip().items():
        f.defines(name, expr, MappingClaim.TIP_BY_ANGLES.of(name))
    f.defines(q.y_rel, ANGLE_CURVE, MappingClaim.CURVE_ORDINATE)
    f.holds(MappingClaim.CURVE_ENDS, Abs(q.y_last - q.y_first) - Abs(rise()))
    f.defines(q.slope, sp.expand(curve_slope()), MappingClaim.CURVE_SLOPE)
    f.defines(q.i, total_ratio(), MappingClaim.TOTAL_RATIO)
    f.holds(MappingClaim.TOTAL_RATIO_BY_SLOPE, q.i - ratio_by_slope())
    (closing,) = sp.solve(turn_of_first_follower() - TURN, q.x_s)
    f.defines(q.x_s, closing, MappingClaim.SPLIT_PARAMETER)
    for name, expr in split().items():
        f.defines(name, expr, MappingClaim.STAGE_RATIO.of(name))
    for ratio, names in ((q.i1, (q.r1, q.r2)), (q.i2, (q.r3, q.r4))):
        for name, expr in zip(names, pitch_radii(ratio, names[0]), strict=True):
            f.defines(name, expr, MappingClaim.PITCH_RADIUS.of(name))
    for gear, name, expr in zip(q.GEARS, q.POLAR_RATES, polar_rates(), strict=True):
        f.defines(name, expr, MappingClaim.POLAR_ANGLE.of(gear))
    f.defines(q.turn2, turn_of_first_follower(), MappingClaim.FIRST_FOLLOWER_TURN)
    f.defines(q.turn4, turn_of_second_follower(), MappingClaim.SECOND_FOLLOWER_TURN)
