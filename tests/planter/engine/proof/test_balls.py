"""Balls enclose what an arbitrary-precision interval library finds; without their rounding they do
not.
"""

from collections.abc import Callable

import numpy as np
import pytest
from flint import arb, ctx

from planter.engine.proof import intervals
from planter.engine.proof.intervals import Ball, Unbounded, sum_products
from planter.kernels import Array

ctx.prec = 200
RNG = np.random.default_rng(20)
COUNT = 400
SIZES = 10.0 ** RNG.integers(-8, 3, COUNT)
MID = RNG.uniform(-1, 1, COUNT) * SIZES
RAD = np.where(RNG.random(COUNT) < 0.4, 0, np.abs(MID) * 10.0 ** RNG.integers(-17, -1, COUNT))
ONE = Ball(MID, RAD)
TWO = Ball(np.roll(MID, 7) + 0.5 * np.sign(np.roll(MID, 7)), np.roll(RAD, 7))
POSITIVE = Ball(np.abs(MID), RAD)

Operation = tuple[Callable[..., Ball], Callable[..., arb], tuple[Ball, ...]]
OPERATIONS: dict[str, Operation] = {
    "sum": (lambda a, b: a + b, lambda x, y: x + y, (ONE, TWO)),
    "difference": (lambda a, b: a - b, lambda x, y: x - y, (ONE, TWO)),
    "product": (lambda a, b: a * b, lambda x, y: x * y, (ONE, TWO)),
    "quotient": (lambda a, b: a / b, lambda x, y: x / y, (ONE, TWO)),
    "sum of products": (
        lambda a, b: sum_products((a, b), (b, b), (a, a)),
        lambda x, y: x * y + y * y + x * x,
        (ONE, TWO),
    ),
    "square": (lambda a: a.power(2), lambda x: x * x, (ONE,)),
    "square by its ends": (lambda a: a.square(), lambda x: x * x, (ONE,)),
    "fourth power": (lambda a: a.power(4), lambda x: x**4, (ONE,)),
    "root": (lambda a: a.sqrt(), lambda x: x.sqrt(), (POSITIVE,)),
    "sine": (lambda a: a.sin(), lambda x: x.sin(), (ONE,)),
    "cosine": (lambda a: a.cos(), lambda x: x.cos(), (ONE,)),
    "arc tangent": (lambda a: a.arctan(), lambda x: x.atan(), (ONE,)),
}


def missed(name: str) -> int:
    """How many values at ends and within are outside of an operation's balls."""
    ours, theirs, arguments = OPERATIONS[name]
    ball = ours(*arguments)
    low, high = ball.low, ball.high
    count = 0
    for share in (-1.0, -0.3, 0.0, 1.0):
        for i in range(COUNT):
            values = [arb(float(b.mid[i])) + arb(share) * arb(float(b.rad[i])) for b in arguments]
            value = theirs(*values)
            count += not (arb(float(low[i])) < value < arb(float(high[i])))
    return count


@pytest.mark.parametrize("name", OPERATIONS)
def test_a_ball_holds_every_value(name: str) -> None:
    assert missed(name) == 0


@pytest.mark.parametrize("name", OPERATIONS)
def test_ball_without_rounding_misses_values(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for part, value in (("U", 0.0), ("SLACK", 0.0), ("GROWTH", 1.0), ("TINY", 0.0), ("LIBM", 0.0)):
        monkeypatch.setattr(intervals, part, value)
    assert missed(name) > 0


def test_a_sum_over_many_lanes_and_a_hull_hold_every_value() -> None:
    total = sum((arb(float(m)) for m in MID), arb(0))
    ball = Ball.exact(MID).sum()
    assert arb(float(ball.low)) < total < arb(float(ball.high))
    assert (ONE.spread().low <= ONE.low.min()) & (ONE.spread().high >= ONE.high.max())


def zero(rad: float) -> Array:
    return Ball(np.array([0.1]), np.array([rad]))


def test_unbounded_operation_is_refused() -> None:
    with pytest.raises(Unbounded, match="a denominator may vanish"):
        zero(0.2).inverse()
    with pytest.raises(Unbounded, match="the argument of a root may vanish"):
        zero(0.2).sqrt()
