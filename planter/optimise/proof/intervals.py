"""Intervals as balls, midpoint and radius, over NumPy arrays: every result encloses the exact one.

What is assumed of the floating point: +, -, *, / and the square root are those of IEEE 754 in round to nearest, with an
error of at most U of the result; sin, cos and arctan err by less than `LIBM`, eight units in the last place of 1, where
NumPy promises four, arctan2 by less than twice that, exp and log by less than that share of the result. Radii are sums
of terms that are not negative, so that a factor `GROWN` covers the rounding of their own evaluation, and `TINY` what
underflows.

Branches of a response over a box: where a condition may go both ways, both are followed.

Straight-line code asks its questions (is this below zero, how many whole turns) in one order. Lanes whose question has
several answers over a box go on with one of them, and for each other answer a further lane is noted, which repeats the
answers given before and takes that one. So each lane is one smooth piece of the response, extended over the whole box,
and at every design of the box the response is that of one of its lanes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

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
    """A function has no bound over a box: a denominator or a root's argument may vanish.

    Where that is so in some lanes only, balls there are NaN.
    """


@dataclass(frozen=True)
class Ball:
    """All numbers closer to `mid` than `rad` (shapes alike or broadcast).

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
        """The ball around an interval."""
        mid = low + (high - low) / 2
        return cls(mid, np.maximum(high - mid, mid - low) * GROWTH + TINY)

    @property
    def low(self) -> Array:
        return _round_down(self.mid - self.rad)

    @property
    def high(self) -> Array:
        return -_round_down(-self.mid - self.rad)

    @property
    def most(self) -> Array:
        """No less than any absolute value in it."""
        found: Array = (np.abs(self.mid) + self.rad) * GROWTH
        return found

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
        """Return 1 / x, NaN in lanes where x may be zero. Raises Unbounded where that is so in every lane."""
        room = _require_positive(np.abs(self.mid) * (1 - 4 * U) - self.rad, "a denominator may vanish")
        mid = 1 / np.where(room > 0, self.mid, np.nan)
        return Ball(mid, (self.rad / room + SLACK) * np.abs(mid) * GROWTH + TINY)

    def power(self, exponent: int) -> Ball:
        """A whole power, at least 0."""
        mid, steep = np.ones_like(self.mid), np.ones_like(self.mid)
        most = self.most
        for k in range(exponent):
            mid = mid * self.mid
            steep = steep * most if k else steep
        rad = exponent * steep * self.rad + (exponent + 1) * U * np.abs(mid)
        return Ball(mid, rad * GROWTH + TINY)

    def square(self) -> Ball:
        """Return x^2, whose ends are squares of those of x, or zero."""
        least, most = np.maximum(_round_down(np.abs(self.mid) - self.rad), 0), self.most
        return Ball.between(np.maximum(_round_down(least * least), 0), -_round_down(-most * most))

    def sqrt(self) -> Ball:
        """NaN in lanes where x may be negative or zero; raises Unbounded where that is so in every lane."""
        room = _require_positive(self.mid * (1 - 4 * U) - self.rad, "the argument of a root may vanish")
        mid = np.sqrt(np.where(room > 0, self.mid, np.nan))
        return Ball(mid, (self.rad / (mid + np.sqrt(room)) + SLACK * mid) * GROWTH + TINY)

    def sin(self) -> Ball:
        """Return an enclosure of the sine."""
        return self._wave(np.sin(self.mid), np.cos(self.mid))

    def cos(self) -> Ball:
        """Return an enclosure of the cosine."""
        return self._wave(np.cos(self.mid), np.sin(self.mid))

    def _wave(self, mid: Array, slope: Array) -> Ball:
        """From Taylor's formula to the second order, whose second derivative is at most 1."""
        rad = (np.abs(slope) + LIBM) * self.rad + self.rad**2 / 2 + LIBM
        return Ball(mid, np.minimum(rad, 1 + np.abs(mid)) * GROWTH + TINY)

    def arctan(self) -> Ball:
        """Return an enclosure of the arc tangent."""
        low, high = np.arctan(self.low) - LIBM, np.arctan(self.high) + LIBM
        return Ball.between(_round_down(low), -_round_down(-high))

    def exp(self) -> Ball:
        """Return an enclosure of the exponential."""
        mid = np.exp(self.mid)
        return Ball(mid, mid * (self.rad * np.exp(self.rad) * (1 + LIBM) + LIBM) * (1 + 2 * LIBM) * GROWTH + TINY)

    def log(self) -> Ball:
        """NaN in lanes where x may be negative or zero; raises Unbounded where that is so in every lane."""
        room = _require_positive(self.mid * (1 - 4 * U) - self.rad, "the argument of a logarithm may vanish")
        mid = np.log(np.where(room > 0, self.mid, np.nan))
        return Ball(mid, (self.rad / room + LIBM * np.abs(mid)) * (1 + LIBM) * GROWTH + TINY)

    def nonnegative(self) -> Ball:
        """Of a quantity that cannot be negative."""
        return Ball.between(np.maximum(self.low, 0), np.maximum(self.high, 0))

    def sum(self, axis: int = -1) -> Ball:
        """Return an enclosure of the sum along an axis."""
        count = self.mid.shape[axis]
        rounding = (count + 1) * U * np.abs(self.mid).sum(axis=axis)
        return Ball(self.mid.sum(axis=axis), (self.rad.sum(axis=axis) + rounding) * _sum_growth(count) + TINY)

    def spread(self, axis: int = -1) -> Ball:
        """One ball around all those along an axis."""
        return Ball.between(self.low.min(axis=axis), self.high.max(axis=axis))


def sum_products(*pairs: tuple[Ball, Ball]) -> Ball:
    """The sum of up to four products."""
    (one, two), *others = pairs
    mid, rad = one.mid * two.mid, _product_error(one, two)
    for one, two in others:
        mid, rad = mid + one.mid * two.mid, rad + _product_error(one, two)
    return Ball(mid, rad * GROWTH + TINY)


def _product_error(one: Ball, two: Ball) -> Array:
    """Of a product, its rounding and its part in that of the sum included."""
    size = np.abs(two.mid)
    found: Array = (np.abs(one.mid) + one.rad) * (two.rad + SLACK * size) + one.rad * size
    return found


def _require_positive(room: Array, message: str) -> Array:
    """Return what is positive, NaN elsewhere. Raises Unbounded, with a message, if no lane, the last axis, is."""
    is_positive = np.asarray(room > 0)
    if not is_positive.all(axis=tuple(range(is_positive.ndim - 1))).any():
        raise Unbounded(message)
    found: Array = np.where(is_positive, room, np.nan)
    return found


def intersect_balls(one: Ball, two: Ball) -> Ball:
    """Of two balls that enclose the same, everywhere the smaller."""
    first = one.rad <= two.rad
    return Ball(np.where(first, one.mid, two.mid), np.where(first, one.rad, two.rad))


def select_balls(condition: Flags, one: Ball, two: Ball) -> Ball:
    """Return the first ball where the condition holds, else the second."""
    return Ball(np.where(condition, one.mid, two.mid), np.where(condition, one.rad, two.rad))


def _round_down(value: Array) -> Array:
    """Below the exact value of what was rounded to `value`."""
    found: Array = value - (2 * U * np.abs(value) + TINY)
    return found


def _sum_growth(count: int) -> float:
    return GROWTH + 4 * U * count


MAX_ANSWERS = 3
"""Answers of one question above which a box is too wide to follow them."""


@dataclass
class Branches:
    """Questions of so many lanes; `script` (q, lanes) holds answers that are given, NaN where the box tells."""

    lanes: int
    script: Array
    answers: list[Array] = field(default_factory=list)
    others: list[tuple[int, int, float]] = field(default_factory=list)
    """(lane, question, another answer)."""
    jumping: Flags = field(init=False)
    """Lanes (lanes,) in which some value may jump where an answer changes."""

    def __post_init__(self) -> None:
        self.jumping = np.zeros(self.lanes, dtype=bool)

    @classmethod
    def none(cls, lanes: int) -> Self:
        """Return branches without a script."""
        return cls(lanes, np.empty((0, lanes)))

    def below(self, value: Ball, strictly: bool, jumps: bool = True) -> Flags:
        """Whether values are below zero (or at it); `jumps` where the response may, as the answer changes."""
        never = ~(value.low < 0 if strictly else value.low <= 0)  # so a ball without bounds asks nothing
        always = value.high < 0 if strictly else value.high <= 0
        usual = np.where(value.mid < 0, 1.0, 0.0)
        found: Flags = self._asked(np.where(never, 0.0, 1.0), np.where(always, 1.0, 0.0), usual, jumps) > 0
        return found

    def floor(self, value: Ball) -> Array:
        """Return an enclosure of the largest integers below the values."""
        high, low, mid = (np.nan_to_num(np.floor(side)) for side in (value.high, value.low, value.mid))
        return self._asked(high, low, mid)

    def _asked(self, largest: Array, least: Array, usual: Array, jumps: bool = True) -> Array:
        """The answer of each lane, between the least and the largest."""
        question = len(self.answers)
        given = self.script[question] if question < len(self.script) else None
        open_ = largest != least
        if given is None and not open_.any():
            self.answers.append(np.broadcast_to(least, (self.lanes,)))
            return least
        self.jumping |= open_ & jumps
        free = np.ones(self.lanes, dtype=bool) if given is None else np.isnan(given)
        answer = np.where(free, np.broadcast_to(usual, free.shape), 0 if given is None else given)
        self.answers.append(answer)
        if (largest - least).max(where=np.broadcast_to(open_, largest.shape), initial=0) >= MAX_ANSWERS:
            raise Unbounded("a box goes through many branches")
        for lane in np.flatnonzero(np.broadcast_to(open_, (self.lanes,)) & free):
            low, high = (np.broadcast_to(side, (self.lanes,))[lane] for side in (least, largest))
            for other in np.arange(low, high + 1):
                if other != answer[lane]:
                    self.others.append((int(lane), question, float(other)))
        return answer

    def further(self) -> tuple[Integers, Array]:
        """Lanes to be followed besides, by the lane they leave, with their scripts (q, further)."""
        lanes = np.array([lane for lane, _, _ in self.others], dtype=np.int64)
        script = np.full((len(self.answers), len(lanes)), np.nan)
        for k, (lane, question, other) in enumerate(self.others):
            script[:question, k] = [answer[lane] for answer in self.answers[:question]]
            script[question, k] = other
        return lanes, script


class Unbranched(Branches):
    """Questions of what cannot be followed along several answers. Raises Unbounded where there are any."""

    def _asked(self, largest: Array, least: Array, usual: Array, jumps: bool = True) -> Array:
        if (largest != least).any():
            raise Unbounded("the gaps of a loop have several branches")
        return least
