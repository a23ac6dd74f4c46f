"""Jets enclose value, gradient and Hessian over a box, as series of an independent interval library
have them.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_series, ctx

from planter.engine.proof.intervals import Ball
from planter.engine.proof.jets import ANYWHERE, Jet, Space, packed_indices
from planter.engine.proof.programs import record_program
from planter.kernels import Array

ctx.prec = 200
LOWER, UPPER = np.array([0.9, 0.2, 1.5]), np.array([1.0, 0.25, 1.5])
Function = Callable[[Any, Sequence[Any]], Any]


class Series:
    """Elementary functions of power series under NumPy's names."""

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
