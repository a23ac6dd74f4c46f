"""Elementary functions of jets under NumPy's names: generated array code as enclosures over a box of designs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from planter.optimise.proof.balls import Ball, U
from planter.optimise.proof.jets import Jet, Space


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
        return self.where(x >= 0, x, -x)

    def maximum(self, one: Any, two: Any) -> Any:
        return self.where(one >= two, one, two)

    def minimum(self, one: Any, two: Any) -> Any:
        return self.where(one <= two, one, two)

    logical_or, logical_and, logical_not = np.logical_or, np.logical_and, np.logical_not

    def divide(self, one: Any, two: Any) -> Jet:
        return self.space.constant(Ball.exact([float(one)])) / two

    @staticmethod
    def sin(x: Jet) -> Jet:
        return x.sin()

    @staticmethod
    def cos(x: Jet) -> Jet:
        return x.cos()

    @staticmethod
    def tan(x: Jet) -> Jet:
        return x.sin() / x.cos()

    @staticmethod
    def sqrt(x: Jet) -> Jet:
        return x.sqrt()

    @staticmethod
    def arctan(x: Jet) -> Jet:
        return x.arctan()

    @staticmethod
    def polyval(coefficients: Sequence[float], x: Jet) -> Jet:
        """The sum of a_k x^k, highest power first, as Taylor's polynomial about the centre: little in it cancels."""
        return x.polynomial(coefficients)

    @staticmethod
    def floor(x: Jet) -> Jet:
        return x.floor()


PI = Ball(np.array([np.pi]), np.array([2 * U]))
"""The number pi; the double below it is closer than 2^-52."""
