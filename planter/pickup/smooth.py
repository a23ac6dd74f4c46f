"""A law whose slope goes to zero smoothly where the dwell begins and ends, so that the tip's velocity does not jump."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.numerics.angles import TURN
from planter.pickup.law import Dwell, toothed_range

_ROUNDING = 1e-9
"""Angles this close to a joint are on the teeth [rad]."""


@dataclass(frozen=True)
class SmoothLaw:
    """Slope c (1 + p cos t), but within `transition` [rad] of the dwell a cubic that meets it, and zero, smoothly.

    c lets the arm gain one turn in a turn of the carrier. In the transitions other means than teeth must drive the
    arm: towards a slope of zero the sun's pitch radius goes to zero.
    """

    p: float
    dwell: Dwell
    transition: float
    phi1_far: float = np.pi

    def arm(self, t: Array) -> Array:
        return self._evaluate(t)[0]

    def slopes(self, t: Array) -> Array:
        return self._evaluate(t)[1:4]

    def joints(self) -> Array:
        first, last = toothed_range(self.dwell)
        return np.array([first, first + self.transition, last - self.transition, last])

    @property
    def mean_on_teeth(self) -> float:
        """c [-]."""
        return float(self._evaluate(np.zeros(1))[4, 0])

    @property
    def rises(self) -> bool:
        """Whether the slope is positive throughout both transitions."""
        h = self.transition
        for joint, sense in ((self.dwell.end + h, 1), (self.dwell.start - h, -1)):
            value, rate = 1 + self.p * np.cos(joint), -sense * self.p * np.sin(joint)
            if value <= 0 or 3 * value < rate * h:
                return False
        return True

    def _evaluate(self, t: Array) -> Array:
        """Return the arm's angle, the slope with two derivatives, and c, (5, n)."""
        angles = np.asarray(t, dtype=float)
        law = np.array([self.p, self.dwell.start, self.dwell.end, self.phi1_far, self.transition])
        return _law()(t=angles.ravel(), law=law)["outputs"].reshape(5, *angles.shape)


def compose_smooth_law(t: ca.SX, law: ca.SX) -> ca.SX:
    """Return the graph of the arm's angle, of the slope with two derivatives, and of c, (5,).

    `law` (5,) are p, the dwell's start and end, the arm's angle at t = 0, and the width of a transition [rad].
    """
    p, start, end, far, h = ca.vertsplit(law)
    first = end - TURN

    def cubic(joint: ca.SX, sense: int) -> tuple[ca.SX, ca.SX]:
        """Return the coefficients of the square and the cube of the distance from the dwell in the slope over c."""
        value, rate = 1 + p * ca.cos(joint), -sense * p * ca.sin(joint)
        return (3 * value - rate * h) / h**2, (rate * h - 2 * value) / h**3

    def integral(part: tuple[ca.SX, ca.SX], distance: ca.SX) -> ca.SX:
        return part[0] * distance**3 / 3 + part[1] * distance**4 / 4

    def plain(angle: ca.SX) -> ca.SX:
        return angle + p * ca.sin(angle)

    after, before = cubic(end + h, 1), cubic(start - h, -1)

    def gained(angle: ca.SX) -> ca.SX:
        """Return the integral of the slope over c from the dwell's end on, up to an angle of the turn after it."""
        middle = ca.fmin(ca.fmax(angle, first + h), start - h)
        beside = [ca.fmin(ca.fmax(distance, 0), h) for distance in (angle - first, start - angle)]
        rest = integral(before, h) - integral(before, beside[1])
        return integral(after, beside[0]) + plain(middle) - plain(first + h) + rest

    turned = TURN * ca.floor((t - first) / TURN)
    within, mean = t - turned, TURN / gained(start)
    angle = far + mean * (gained(within) - gained(ca.SX(0))) + turned
    tooth = ca.if_else(within > start + (end - start) / 2, first, ca.fmin(within, start))
    slopes = [1 + p * ca.cos(tooth), -p * ca.sin(tooth), -p * ca.cos(tooth)]
    for part, distance, sense in ((after, tooth - first, 1), (before, start - tooth, -1)):
        square, cube = part
        ends = [
            (square + cube * distance) * distance**2,
            sense * (2 * square + 3 * cube * distance) * distance,
            2 * square + 6 * cube * distance,
        ]
        near = distance < h - _ROUNDING
        slopes = [ca.if_else(near, end, slope) for end, slope in zip(ends, slopes, strict=True)]
    return ca.vertcat(angle, *(mean * slope for slope in slopes), mean)


@cache
def _law() -> Kernel:
    t, law = ca.SX.sym("t"), ca.SX.sym("law", 5)
    return Kernel(ca.Function("smooth", [t, law], [compose_smooth_law(t, law)], ["t", "law"], ["outputs"]), lanes=["t"])
