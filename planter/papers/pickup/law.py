"""Laws of the arm: its angle phi1 over the carrier's angle t from the farthest tip, with or without
dwell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import casadi as ca
import numpy as np
import scipy

from planter.kernels import Array, Kernel
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN

MODEL, NEEDLE = "pickup_exact", "pickup_needle"
"""The generated formulas of the pick-up."""
ROUNDING = 1e-12
"""Angles this close to an end of the dwell lie in it [rad]."""


@dataclass(frozen=True)
class Dwell:
    """Range in which the locking arcs act: carrier angles in rad, 0 <= start < 2 pi, end after
    start.
    """

    start: float
    end: float

    @property
    def width(self) -> float:
        return self.end - self.start

    def holds(self, t: Array) -> Array:
        """Whether angles lie in the dwell, its ends included; any turn."""
        inside = (t - self.start + ROUNDING) % TURN <= self.width + 2 * ROUNDING
        return np.asarray(inside)


def toothed_range(dwell: Dwell | None) -> tuple[float, float]:
    """First and last angle of the teeth: the turn without the dwell, from the dwell's end on."""
    return (0.0, TURN) if dwell is None else (dwell.end - TURN, dwell.start)


@dataclass(frozen=True)
class SplineLaw:
    """A law by its lead phi1 - t, a spline over the toothed range; `held` is phi1 in the dwell that
    follows it.
    """

    lead: scipy.interpolate.BSpline
    dwell: Dwell | None
    dwell_angle: float
    transition: ClassVar[float] = 0.0
    """Angle next to the dwell over which other means than teeth drive the arm [rad]."""

    def _fold_angle(self, t: Array) -> Array:
        """The angles brought into the turn that begins where the teeth do."""
        first, _ = toothed_range(self.dwell)
        return first + (np.asarray(t, dtype=float) - first) % TURN

    def arm(self, t: Array) -> Array:
        """Return the arm's angle (n,) [rad]."""
        folded_angle = self._fold_angle(t)
        last = toothed_range(self.dwell)[1]
        on_teeth = self.lead(np.minimum(folded_angle, last)) + folded_angle
        return np.asarray(
            np.where(folded_angle <= last, on_teeth, self.dwell_angle)
            + np.asarray(t, dtype=float)
            - folded_angle
        )

    def slopes(self, t: Array) -> Array:
        """Return the slope with two derivatives (3, n); in the dwell they continue those of the
        teeth.
        """
        folded_angle = self._fold_angle(t)
        first, last = toothed_range(self.dwell)
        if self.dwell is not None:
            closer_to_end = folded_angle > last + self.dwell.width / 2
            folded_angle = np.where(closer_to_end, first, np.minimum(folded_angle, last))
        return np.array(
            [self.lead(folded_angle, 1) + 1, self.lead(folded_angle, 2), self.lead(folded_angle, 3)]
        )

    def breakpoints(self) -> Array:
        """Return the breakpoints of the law on the teeth [rad], in order."""
        first, last = toothed_range(self.dwell)
        knots = (
            np.unique(first + (self.lead.t - first) % TURN)
            if self.dwell is None
            else np.unique(self.lead.t)
        )
        return np.concatenate([[first], knots[(knots > first) & (knots < last)], [last]])


_ROUNDING = 1e-9
"""Angles this close to a joint are on the teeth [rad]."""


@dataclass(frozen=True)
class CosineLaw:
    """Slope c (1 + p cos t) on the teeth, but within `transition` [rad] of the dwell a cubic that
    meets it, and zero, smoothly; without a transition the slope jumps.

    c lets the arm gain one turn in a turn of the carrier. In the transitions other means than teeth
    must drive the arm: towards a slope of zero the sun's pitch radius goes to zero.
    """

    p: float
    dwell: Dwell
    phi1_far: float = np.pi
    transition: float = 0.0

    def arm(self, t: Array) -> Array:
        """Return the arm's angle (n,) [rad]."""
        return self._evaluate(t)[0]

    def slopes(self, t: Array) -> Array:
        """Return the slope with two derivatives (3, n)."""
        return self._evaluate(t)[1:4]

    def breakpoints(self) -> Array:
        """Return the breakpoints of the law on the teeth [rad], in order."""
        first, last = toothed_range(self.dwell)
        inner = (first + self.transition, last - self.transition) if self.transition else ()
        return np.array([first, *inner, last])

    @property
    def mean_on_teeth(self) -> float:
        """c [-]."""
        return float(self.slopes(np.array([np.pi / 2]))[0, 0])

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
        """Return the arm's angle and the slope with two derivatives, (4, n)."""
        angles = np.asarray(t, dtype=float)
        law = np.array([self.p, self.dwell.start, self.dwell.end, self.phi1_far])
        if not self.transition:
            values = load(MODEL)("law", t=angles, law=law)
            return np.array([values[name] for name in ("phi1", "g", "dg", "ddg")])
        smooth = _law()(t=angles.ravel(), law=np.append(law, self.transition))
        return smooth["outputs"].reshape(4, *angles.shape)


ArmLaw = SplineLaw | CosineLaw
"""phi1(t) with phi1(t + 2 pi) = phi1(t) + 2 pi."""


def compose_smooth_law(t: ca.SX, law: ca.SX) -> ca.SX:
    """Return the graph of the arm's angle and of the slope with two derivatives, (4,).

    `law` (5,) are p, the dwell's start and end, the arm's angle at t = 0, and the width of a
    transition [rad].
    """
    p, start, end, far, h = ca.vertsplit(law)
    first = end - TURN

    def cubic(joint: ca.SX, sense: int) -> tuple[ca.SX, ca.SX]:
        """Return the coefficients of the square and the cube of the distance from the dwell in the
        slope over c.
        """
        value, rate = 1 + p * ca.cos(joint), -sense * p * ca.sin(joint)
        return (3 * value - rate * h) / h**2, (rate * h - 2 * value) / h**3

    def integral(part: tuple[ca.SX, ca.SX], distance: ca.SX) -> ca.SX:
        return part[0] * distance**3 / 3 + part[1] * distance**4 / 4

    def plain(angle: ca.SX) -> ca.SX:
        return angle + p * ca.sin(angle)

    after, before = cubic(end + h, 1), cubic(start - h, -1)

    def gained(angle: ca.SX) -> ca.SX:
        """Return the integral of the slope over c from the dwell's end on, up to an angle of the
        turn after it.
        """
        middle = ca.fmin(ca.fmax(angle, first + h), start - h)
        distances = [
            ca.fmin(ca.fmax(distance, 0), h) for distance in (angle - first, start - angle)
        ]
        rest = integral(before, h) - integral(before, distances[1])
        return integral(after, distances[0]) + plain(middle) - plain(first + h) + rest

    turned = TURN * ca.floor((t - first) / TURN)
    folded_angle, mean = t - turned, TURN / gained(start)
    angle = far + mean * (gained(folded_angle) - gained(ca.SX(0))) + turned
    tooth = ca.if_else(
        folded_angle > start + (end - start) / 2, first, ca.fmin(folded_angle, start)
    )
    slopes = [1 + p * ca.cos(tooth), -p * ca.sin(tooth), -p * ca.cos(tooth)]
    for part, distance, sense in ((after, tooth - first, 1), (before, start - tooth, -1)):
        square, cube = part
        ends = [
            (square + cube * distance) * distance**2,
            sense * (2 * square + 3 * cube * distance) * distance,
            2 * square + 6 * cube * distance,
        ]
        in_transition = distance < h - _ROUNDING
        slopes = [
            ca.if_else(in_transition, end, slope) for end, slope in zip(ends, slopes, strict=True)
        ]
    return ca.vertcat(angle, *(mean * slope for slope in slopes))


@cache
def _law() -> Kernel:
    t, law = ca.SX.sym("t"), ca.SX.sym("law", 5)
    return Kernel(
        ca.Function("smooth", [t, law], [compose_smooth_law(t, law)], ["t", "law"], ["outputs"]),
        lanes=["t"],
    )
