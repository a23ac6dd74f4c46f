"""Intervals in midpoint-radius form over NumPy arrays, and branches of a response over a box of
designs.

Every result encloses the exact one under these assumptions: +, -, *, / and the square root are
those of IEEE 754 in round to nearest, with a relative error of at most U; the error of sin, cos and
arctan is below `LIBM`, eight units in the last place of 1 (NumPy promises four), that of arctan2
below twice `LIBM`, and the relative error of exp and log below `LIBM`. Radii are sums of
nonnegative terms, so that a factor `GROWTH` covers the rounding of their evaluation, and `TINY`
underflow.

Straight-line code evaluates its conditions (sign, number of revolutions) in a fixed order. If a
condition has several answers over a box, its lane continues with one of them, and each other answer
yields a further lane, which repeats the previous answers. Each lane is thus a smooth piece of the
response, extended over the box, and at each design of the box the response is that of one of its
lanes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers

U = 2.0**-53
"""Largest relative error of one operation."""
SLACK = 4 * U
"""Covers the rounding of a sum of up to four products, as a share of each."""
GROWTH = 1 + 2.0**-44
"""Covers the rounding of a radius: a sum of less than 500 terms."""
TINY = 1e-300
LIBM = 2.0**-49
"""Largest error of sin, cos and arctan [-], and of exp and log as a share of their result."""


class Unbounded(ComputationError):
    """A function has no bound over a box, because a denominator or the argument of a root may
    vanish.

    If only some lanes have no bound, their balls are NaN instead.
    """


@dataclass(frozen=True)
class Ball:
    """All numbers within `rad` of `mid` (arrays of equal or broadcast shapes).

    >>> third = Ball.exact(1.0) / Ball.exact(3.0)
    >>> bool(third.low * 3 < 1 < third.high * 3)
    True
    """

    mid: Array
    rad: Array

    @classmethod
    def exact(cls, value: Any) -> Ball:
        """Return a ball of radius zero."""
        mid = np.asarray(value, dtype=float)
        return cls(mid, np.zeros_like(mid))

    @classmethod
    def between(cls, low: Array, high: Array) -> Ball:
        """Return the smallest ball around an interval, with rounding."""
        mid = low + (high - low) / 2
        return cls(mid, np.maximum(high - mid, mid - low) * GROWTH + TINY)

    @property
    def low(self) -> Array:
        return round_down(self.mid - self.rad)

    @property
    def high(self) -> Array:
        return -round_down(-self.mid - self.rad)

    @property
    def magnitude(self) -> Array:
        """Upper bound of the absolute values in the ball."""
        bound: Array = (np.abs(self.mid) + self.rad) * GROWTH
        return bound

    def map(self, function: Callable[[Array], Array]) -> Ball:
        """Return a ball whose midpoints and radii are rearranged by the same function."""
        return Ball(function(self.mid), function(self.rad))

    def __getitem__(self, key: Any) -> Ball:
        return Ball(self.mid[key], self.rad[key])

    def __neg__(self) -> Ball:
        return Ball(-self.mid, self.rad)

    def __add__(self, other: Ball) -> Ball:
        mid = self.mid + other.mid
        return Ball(mid, (self.rad + other.rad + U * np.abs(mid)) * GROWTH + TINY)

    def __sub__(self, other: Ball) -> Ball:
        return self + (-other)

    def __mul__(self, other: Ball) -> Ball:
        return sum_products((self, other))

    def __truediv__(self, other: Ball) -> Ball:
        return self * other.inverse()

    def inverse(self) -> Ball:
        """Return 1 / x, NaN in lanes where x may be zero.

        Raises Unbounded if x may be zero in every lane.
        """
        margin = _require_positive(
            np.abs(self.mid) * (1 - 4 * U) - self.rad, "a denominator may vanish"
        )
        mid = 1 / np.where(margin > 0, self.mid, np.nan)
        return Ball(mid, (self.rad / margin + SLACK) * np.abs(mid) * GROWTH + TINY)

    def power(self, exponent: int) -> Ball:
        """Return x^exponent for an integer exponent of at least 0."""
        mid, steep = np.ones_like(self.mid), np.ones_like(self.mid)
        magnitude = self.magnitude
        for k in range(exponent):
            mid = mid * self.mid
            steep = steep * magnitude if k else steep
        rad = exponent * steep * self.rad + (exponent + 1) * U * np.abs(mid)
        return Ball(mid, rad * GROWTH + TINY)

    def square(self) -> Ball:
        """Return x^2, whose ends are squares of those of x, or zero."""
        low, high = np.maximum(round_down(np.abs(self.mid) - self.rad), 0), self.magnitude
        return Ball.between(np.maximum(round_down(low * low), 0), -round_down(-high * high))

    def sqrt(self) -> Ball:
        """NaN in lanes where x may be negative or zero; raises Unbounded where that is so in every
        lane.
        """
        margin = self._require_positive("a root")
        mid = np.sqrt(np.where(margin > 0, self.mid, np.nan))
        return Ball(mid, (self.rad / (mid + np.sqrt(margin)) + SLACK * mid) * GROWTH + TINY)

    def _require_positive(self, function: str) -> Array:
        margin = self.mid * (1 - 4 * U) - self.rad
        return _require_positive(margin, f"the argument of {function} may vanish")

    def sin(self) -> Ball:
        """Return an enclosure of the sine."""
        return self._wave(np.sin(self.mid), np.cos(self.mid))

    def cos(self) -> Ball:
        """Return an enclosure of the cosine."""
        return self._wave(np.cos(self.mid), np.sin(self.mid))

    def _wave(self, mid: Array, slope: Array) -> Ball:
        """Return sine or cosine by Taylor's formula of order 2, whose second derivative is at most
        1.
        """
        rad = (np.abs(slope) + LIBM) * self.rad + self.rad**2 / 2 + LIBM
        return Ball(mid, np.minimum(rad, 1 + np.abs(mid)) * GROWTH + TINY)

    def arctan(self) -> Ball:
        """Return an enclosure of the arc tangent."""
        low, high = np.arctan(self.low) - LIBM, np.arctan(self.high) + LIBM
        return Ball.between(round_down(low), -round_down(-high))

    def exp(self) -> Ball:
        """Return an enclosure of the exponential."""
        mid = np.exp(self.mid)
        return Ball(
            mid,
            mid * (self.rad * np.exp(self.rad) * (1 + LIBM) + LIBM) * (1 + 2 * LIBM) * GROWTH
            + TINY,
        )

    def log(self) -> Ball:
        """NaN in lanes where x may be negative or zero; raises Unbounded where that is so in every
        lane.
        """
        margin = self._require_positive("a logarithm")
        mid = np.log(np.where(margin > 0, self.mid, np.nan))
        return Ball(mid, (self.rad / margin + LIBM * np.abs(mid)) * (1 + LIBM) * GROWTH + TINY)

    def nonnegative(self) -> Ball:
        """Return the nonnegative part of the ball."""
        return Ball.between(np.maximum(self.low, 0), np.maximum(self.high, 0))

    def sum(self, axis: int = -1) -> Ball:
        """Return an enclosure of the sum along an axis."""
        count = self.mid.shape[axis]
        rounding = (count + 1) * U * np.abs(self.mid).sum(axis=axis)
        return Ball(
            self.mid.sum(axis=axis),
            (self.rad.sum(axis=axis) + rounding) * (GROWTH + 4 * U * count) + TINY,
        )

    def spread(self, axis: int = -1) -> Ball:
        """Return a ball around all balls along an axis."""
        return Ball.between(self.low.min(axis=axis), self.high.max(axis=axis))


PI = Ball(np.array([np.pi]), np.array([2 * U]))
"""The number pi; the nearest double is closer than 2^-52."""


def sum_products(*pairs: tuple[Ball, Ball]) -> Ball:
    """Return an enclosure of the sum of up to four products."""
    (a, b), *rest = pairs
    mid, rad = a.mid * b.mid, _product_error(a, b)
    for a, b in rest:
        mid, rad = mid + a.mid * b.mid, rad + _product_error(a, b)
    return Ball(mid, rad * GROWTH + TINY)


def _product_error(a: Ball, b: Ball) -> Array:
    """Return the radius of a product, including its rounding and its share in the rounding of the
    sum.
    """
    size = np.abs(b.mid)
    error: Array = (np.abs(a.mid) + a.rad) * (b.rad + SLACK * size) + a.rad * size
    return error


def _require_positive(margin: Array, message: str) -> Array:
    """Return positive margins, NaN elsewhere.

    Raises Unbounded(message) if no lane (last axis) is all positive.
    """
    is_positive = np.asarray(margin > 0)
    if not is_positive.all(axis=tuple(range(is_positive.ndim - 1))).any():
        raise Unbounded(message)
    positive: Array = np.where(is_positive, margin, np.nan)
    return positive


def intersect_balls(a: Ball, b: Ball) -> Ball:
    """Return, entry by entry, the smaller of two balls that enclose the same quantity."""
    first = a.rad <= b.rad
    return Ball(np.where(first, a.mid, b.mid), np.where(first, a.rad, b.rad))


def select_balls(condition: Flags, a: Ball, b: Ball) -> Ball:
    """Return the first ball where the condition holds, else the second."""
    return Ball(np.where(condition, a.mid, b.mid), np.where(condition, a.rad, b.rad))


def round_down(value: Array) -> Array:
    """Return a lower bound of the exact value whose rounding is `value`."""
    lower: Array = value - (2 * U * np.abs(value) + TINY)
    return lower


MAX_ANSWERS = 3
"""Number of answers to a condition above which a box is too wide to follow them."""


class Branches:
    """Answers (q, lanes) to the conditions of a program in lanes, between the `smallest` and the
    `largest` that a box allows.

    A script (m, lanes) prescribes the first answers, NaN where the box determines them; `jumps`
    says of each condition whether the response may jump where its answer changes.

    Raises Unbounded if a condition has many answers.
    """

    def __init__(
        self, largest: Array, smallest: Array, answers: Array, script: Array, jumps: Sequence[bool]
    ) -> None:
        open_ = largest != smallest
        if (largest - smallest).max(where=open_, initial=0) >= MAX_ANSWERS:
            raise Unbounded("a box goes through many branches")
        self.answers = answers
        self.jumping: Flags = (open_ & np.array(jumps, dtype=bool)[:, None]).any(axis=0)
        """Lanes (lanes,) in which a value may jump where an answer changes."""
        free = open_.copy()
        free[: len(script)] &= np.isnan(script[: len(free)])
        self.alternatives = [
            (int(lane), int(question), float(other))
            for question, lane in zip(*np.nonzero(free), strict=True)
            for other in np.arange(smallest[question, lane], largest[question, lane] + 1)
            if other != answers[question, lane]
        ]
        """(lane, index of the condition, alternative answer)."""

    def further(self) -> tuple[Integers, Array]:
        """Return the lanes from which further lanes branch off, (n,), and the scripts of these (q,
        n).
        """
        lanes = np.array([lane for lane, _, _ in self.alternatives], dtype=np.int64)
        script = np.full((len(self.answers), len(lanes)), np.nan)
        for k, (lane, question, other) in enumerate(self.alternatives):
            script[:question, k] = self.answers[:question, lane]
            script[question, k] = other
        return lanes, script
