"""Balls and jets enclose values, and jets gradients and Hessians, of an arbitrary-precision interval
library; without rounding, or with a wrong sign, they do not.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_series, ctx

from planter.engine.proof import intervals
from planter.engine.proof.intervals import Ball, Unbounded, sum_products
from planter.engine.proof.jets import ANYWHERE, Jet, Space, packed_indices
from planter.engine.proof.programs import record_program
from planter.kernels import Array

BITS = 200
RNG = np.random.default_rng(20)
COUNT = 400
SIZES = 10.0 ** RNG.integers(-8, 3, COUNT)
MID = RNG.uniform(-1, 1, COUNT) * SIZES
RAD = np.where(RNG.random(COUNT) < 0.4, 0, np.abs(MID) * 10.0 ** RNG.integers(-17, -1, COUNT))
ONE = Ball(MID, RAD)
TWO = Ball(np.roll(MID, 7) + 0.5 * np.sign(np.roll(MID, 7)), np.roll(RAD, 7))
POSITIVE = Ball(np.abs(MID), RAD)


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with ctx.workprec(BITS):
        yield


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


def count_missed_values(name: str) -> int:
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
    assert count_missed_values(name) == 0


@pytest.mark.parametrize("name", OPERATIONS)
def test_ball_without_rounding_misses_values(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for part, value in (("U", 0.0), ("SLACK", 0.0), ("GROWTH", 1.0), ("TINY", 0.0), ("LIBM", 0.0)):
        monkeypatch.setattr(intervals, part, value)
    assert count_missed_values(name) > 0


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


LOWER, UPPER = np.array([0.9, 0.2, 1.5]), np.array([1.0, 0.25, 1.5])
Function = Callable[[Any, Sequence[Any]], Any]


class Series:
    """Elementary functions of power series under NumPy's names."""

    with ctx.workprec(BITS):
        pi = arb.pi()
    sin = staticmethod(lambda x: x.sin())
    cos = staticmethod(lambda x: x.cos())
    sqrt = staticmethod(lambda x: x.sqrt())
    arctan = staticmethod(lambda x: x.atan())


FUNCTIONS: dict[str, Function] = {
    "product": lambda xp, x: x[0] * x[1] * x[2] - 3 * x[1],
    "quotient": lambda xp, x: (1 + x[0]) / (x[1] + x[2]),
    "powers": lambda xp, x: x[0] ** 4 - 2 * x[0] ** 3 * x[1] + x[1] ** 2,
    "waves": lambda xp, x: xp.sin(3 * x[0] * x[1]) + xp.cos(x[0] - 5 * x[1]) * x[2],
    "root": lambda xp, x: xp.sqrt(x[0] * x[0] - x[1] * x[1] * xp.sin(x[2]) ** 2),
    "arc tangent": lambda xp, x: xp.arctan(x[1] * xp.sin(x[0]) / (1 - x[1] * xp.cos(x[0]))),
}


def enclosed(function: Function) -> Jet:
    return enclose(function, Space(LOWER, UPPER))


def enclose(function: Function, space: Space) -> Jet:
    program = record_program(lambda xp, x: [function(xp, x)], len(LOWER))
    vars(program)["is_compiled"] = False
    return program.enclose_smooth(space, space.parameters())[0]


def series(function: Function, x: Array, direction: Array) -> list[arb]:
    """Value, slope and half the bend of a function at a point in a direction."""
    lines = [arb_series([float(a), float(v)], prec=3) for a, v in zip(x, direction, strict=True)]
    values = function(Series, lines)
    return [values[n] for n in range(3)]


def holds(ball: Ball, value: arb) -> bool:
    return bool(arb(float(np.min(ball.low))) <= value <= arb(float(np.max(ball.high))))


def missed(name: str, jet: Jet) -> int:
    """How many values, slopes and bends at points of the box in random directions are outside of a
    jet.
    """
    rng, count = np.random.default_rng(3), 0
    rows, columns = packed_indices(len(jet.support))
    for _ in range(60):
        x = LOWER + rng.random(3) * (UPPER - LOWER)
        direction = np.append(rng.integers(-2, 3, 2).astype(float), 0.0)
        value, slope, bend = series(FUNCTIONS[name], x, direction)
        v = Ball.exact(direction[list(jet.support)])
        gradient = (jet.gradient[ANYWHERE][:, 0] * v).sum()
        twice = Ball.exact(np.where(rows == columns, 1.0, 2.0))
        quadratic = (jet.hessian[:, 0] * v[rows] * v[columns] * twice).sum()
        parts = (jet.value[ANYWHERE][0], value), (gradient, slope), (quadratic, 2 * bend)
        count += sum(not holds(ball, part) for ball, part in parts)
    return count


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_jet_holds_values_and_derivatives(name: str) -> None:
    jet = enclosed(FUNCTIONS[name])
    assert jet.support in {(0, 1), (0,)}
    assert missed(name, jet) == 0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_bounds_of_a_jet_are_bounds(name: str) -> None:
    jet, rng = enclosed(FUNCTIONS[name]), np.random.default_rng(5)
    points = LOWER + rng.random((200, 3)) * (UPPER - LOWER)
    values = [FUNCTIONS[name](np, point) for point in points]
    assert jet.lower_bound[0] <= min(values)
    assert -(-jet).lower_bound[0] >= max(values)
    assert max(values) - min(values) > 0.5 * (-(-jet).lower_bound[0] - jet.lower_bound[0])


def test_a_wrong_sign_is_noticed() -> None:
    jet = enclosed(FUNCTIONS["waves"])
    for slopes, bends in ((-jet.gradient, jet.hessian), (jet.gradient, -jet.hessian)):
        assert missed("waves", jet.space.jet(jet.support, jet.value, slopes, bends)) > 0


def test_too_small_box_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    """Widths that are forgotten leave values outside."""
    space = Space(LOWER, UPPER)
    space.half = space.half / 10
    assert missed("waves", enclose(FUNCTIONS["waves"], space)) > 0
