"""Roots over a box: enclosed by an interval Newton step, their derivatives by Newton steps on jets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.optimise.proof.balls import GROWN, Ball, Unbounded
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space, packed

Residual = Callable[[Jet], tuple[Jet, Jet]]
"""a -> (f(a), its derivative in a), both over the box."""
WIDER = 1.5
"""How much wider than a Newton step each trial is."""
MOST_STEPS = 30


def root(space: Space, start: float, residual: Residual) -> Jet:
    """The root a(x) of f(a, x) near `start`, over the box.

    Newton's step N(A) = s - f(s) / f'(A) from a point s maps a ball A into itself: then A holds exactly one root at
    each design. Let b be a function whose value, or whose value and gradient, are those of a at one design x*: then
    b - f(b) / f'(b) has gradient, or gradient and Hessian, of a there, since the error of a Newton step goes with the
    square of that before. So the derivatives anywhere are enclosed by steps on all constants a(x*), and then on all
    lines a(x*) + a'(x*) (x - x*).

    Raises Unbounded where no ball is found that is mapped into itself.
    """
    at = _refined(space, start, residual)
    values = [_enclosed(space, at, residual, part) for part in (CENTRE, ANYWHERE)]
    steps = [_step(space.constant(value), residual) for value in values]
    slopes = [steps[part].gradient[part] for part in (CENTRE, ANYWHERE)]
    felt, slope = steps[ANYWHERE].felt, slopes[ANYWHERE]
    moved = 2 * (space.half[list(felt)] @ slope.most) * GROWN
    line = Jet(
        space, felt, _twice(Ball(values[ANYWHERE].mid, (values[ANYWHERE].rad + moved) * GROWN)), _twice(slope),
        Ball.exact(np.zeros((packed(len(felt)), 1))),
    )  # fmt: skip
    return Jet(space, felt, _pair(*values), _pair(*slopes), _step(line, residual).hessian).cut()


def _step(at: Jet, residual: Residual) -> Jet:
    excess, slope = residual(at)
    return at - excess / slope


def _refined(space: Space, start: float, residual: Residual) -> float:
    """Closer to the root at the box's centre: Newton's method in plain numbers."""
    at = start
    for _ in range(MOST_STEPS):
        excess, slope = residual(space.constant(Ball.exact([at])))
        step = float(excess.value.mid[0, 0] / slope.value.mid[0, 0])
        at -= step
        if abs(step) <= 1e-15 * abs(at):
            break
    return at


def _enclosed(space: Space, start: float, residual: Residual, part: int) -> Ball:
    """The root, (1,): at the centre of the box, or anywhere in it."""
    point = Ball.exact([start])
    excess, slope = residual(space.constant(point))
    first = excess.value[part] / slope.value[part]
    rad = np.abs(first.mid) + first.rad
    for _ in range(MOST_STEPS):
        rad = WIDER * rad + 1e-15 * abs(start)
        _, slope = residual(space.constant(Ball(point.mid, rad)))
        step = point - excess.value[part] / slope.value[part]
        if np.all((np.abs(step.mid - point.mid) + step.rad) * GROWN < rad):
            return step
    raise Unbounded("no ball is mapped into itself by a Newton step")


def _twice(ball: Ball) -> Ball:
    return _pair(ball, ball)


def _pair(centre: Ball, anywhere: Ball) -> Ball:
    return Ball(np.stack([centre.mid, anywhere.mid]), np.stack([centre.rad, anywhere.rad]))
