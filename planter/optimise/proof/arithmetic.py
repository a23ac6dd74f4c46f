"""Elementary functions of jets under NumPy's names: generated array code as enclosures over a box of designs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from planter.optimise.proof.balls import LIBM, Ball, U, Unbounded
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space


class Enclosing:
    """What generated array code takes as `xp`, in one box."""

    def __init__(self, space: Space) -> None:
        self.space = space

    @cached_property
    def pi(self) -> Jet:
        return self.space.constant(PI)

    def where(self, condition: Any, yes: Any, no: Any) -> Any:
        if isinstance(yes, Jet):
            return yes.where(condition, no)
        if isinstance(no, Jet):
            return no.where(np.logical_not(condition), yes)
        return self.space.constant(Ball.exact(np.where(condition, yes, no)))

    def absolute(self, x: Any) -> Any:
        return x.where(x.reaches(0), -x) if isinstance(x, Jet) else abs(x)

    def maximum(self, one: Any, two: Any) -> Jet:
        first = self.space.lift(one)
        return first.where(first.reaches(two), two)

    def minimum(self, one: Any, two: Any) -> Jet:
        first = self.space.lift(one)
        return first.where(self.space.lift(two).reaches(first), two)

    def sign(self, x: Any) -> Any:
        return self.where(x > 0, 1, self.where(x < 0, -1, 0))

    logical_or, logical_and, logical_not = np.logical_or, np.logical_and, np.logical_not

    def divide(self, one: Any, two: Any) -> Jet:
        return self.space.lift(one) / two

    def sin(self, x: Any) -> Jet:
        return self.space.lift(x).sin()

    def cos(self, x: Any) -> Jet:
        return self.space.lift(x).cos()

    def tan(self, x: Any) -> Jet:
        return self.sin(x) / self.cos(x)

    def sqrt(self, x: Any) -> Jet:
        return self.space.lift(x).sqrt()

    def exp(self, x: Any) -> Jet:
        return self.space.lift(x).exp()

    def log(self, x: Any) -> Jet:
        return self.space.lift(x).log()

    def arctan(self, x: Any) -> Jet:
        return self.space.lift(x).arctan()

    def arcsin(self, x: Any) -> Jet:
        return self.arctan(x / self.sqrt(1 - x**2))

    def arccos(self, x: Any) -> Jet:
        return self.arctan2(self.sqrt(1 - x**2), x)

    def arctan2(self, y: Any, x: Any) -> Jet:
        """Return the angle of a point: that of a fixed direction near it, and the angle from there.

        NaN in lanes where the point may be the origin, or where the angle may jump by a turn. Raises Unbounded where
        that is so in every lane.
        """
        y, x = self.space.lift(y), self.space.lift(x)
        high, wide = y.value[ANYWHERE], x.value[ANYWHERE]
        is_apart = (wide.low > 0) | (high.low > 0) | (high.high < 0)
        if not is_apart.any():
            raise Unbounded("an angle may jump by a turn")
        angle = np.arctan2(y.value.mid[CENTRE], x.value.mid[CENTRE])
        cos, sin = np.cos(angle), np.sin(angle)
        along, across = x * cos + y * sin, y * cos - x * sin
        direction = np.arctan2(sin, cos)
        fixed = Ball(np.where(is_apart, direction, np.nan), np.full_like(direction, 2 * LIBM))
        return (across / along).arctan() + self.space.constant(fixed)

    @staticmethod
    def polyval(coefficients: Sequence[float], x: Jet) -> Jet:
        """The sum of a_k x^k, highest power first, as Taylor's polynomial about the centre: little in it cancels."""
        return x.polynomial(coefficients)

    @staticmethod
    def floor(x: Jet) -> Jet:
        return x.floor()


PI = Ball(np.array([np.pi]), np.array([2 * U]))
"""The number pi; the double below it is closer than 2^-52."""
