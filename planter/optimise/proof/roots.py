"""Roots over a box: enclosed by interval Newton steps, their derivatives by Newton steps on jets."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.proof.balls import GROWN, Ball, Unbounded
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space, packed
from planter.optimise.proof.linear import eliminate, find_preconditioner, scale_rows, solve

Residual = Callable[[Sequence[Jet]], tuple[Sequence[Jet], Sequence[Sequence[Jet]]]]
"""a (k,) -> f(a) (k,) and its Jacobian (k, k), both over the box."""
WIDER = 1.5
"""How much wider than a Newton step each trial is."""
MOST_STEPS = 30


def roots(space: Space, start: Array, residual: Residual) -> list[Jet]:
    """Return the roots a(x) (k,) of f(a, x) near `start` (k, lanes), over the box.

    Newton's step N(A) = s - f'(A)^-1 f(s) from a point s maps balls A into themselves: then A holds exactly one root at
    each design. Let b be functions whose values, or whose values and gradients, are those of a at one design x*: then
    b - f'(b)^-1 f(b) have gradients, or gradients and Hessians, of a there, since the error of a Newton step goes with
    the square of that before. So the derivatives anywhere are enclosed by steps on all constants a(x*), and then on all
    lines a(x*) + a'(x*) (x - x*).

    Raises Unbounded where no balls are found that are mapped into themselves.
    """
    at = _refine(space, start, residual)
    values = [_enclose(space, at, residual, part) for part in (CENTRE, ANYWHERE)]
    steps = [_step([space.constant(value) for value in part], residual) for part in values]
    lines, felts = [], []
    for k, jet in enumerate(steps[ANYWHERE]):
        slope, value = jet.gradient[ANYWHERE], values[ANYWHERE][k]
        moved = 2 * (space.half[list(jet.felt)] @ slope.most) * GROWN
        bent = Ball.exact(np.zeros((packed(len(jet.felt)), 1)))
        wide = Ball(value.mid + 0 * moved, (value.rad + moved) * GROWN)
        lines.append(Jet(space, jet.felt, _twice(wide), _twice(slope), bent))
        felts.append(jet.felt)
    ends = _step(lines, residual)
    return [
        Jet(
            space, felt, _pair(values[CENTRE][k], values[ANYWHERE][k]),
            _pair(steps[CENTRE][k].over(felt).gradient[CENTRE], steps[ANYWHERE][k].gradient[ANYWHERE]),
            ends[k].over(felt).hessian,
        ).cut()
        for k, felt in enumerate(felts)
    ]  # fmt: skip


def _step(at: Sequence[Jet], residual: Residual) -> list[Jet]:
    excess, slopes = residual(at)
    return [a - change for a, change in zip(at, solve(at[0].space, slopes, excess), strict=True)]


def _refine(space: Space, start: Array, residual: Residual) -> Array:
    """Return a point (k, lanes) closer to the roots at the box's centre, by Newton's method in plain numbers."""
    at = np.array(start, dtype=float)
    for _ in range(MOST_STEPS):
        excess, slopes = residual([space.constant(Ball.exact(row)) for row in at])
        lanes = at.shape[1]
        right = np.array([np.broadcast_to(jet.value.mid[0], lanes) for jet in excess])
        matrix = np.array([[np.broadcast_to(jet.value.mid[0], lanes) for jet in row] for row in slopes])
        try:
            step = np.linalg.solve(matrix.transpose(2, 0, 1), right.T[..., None])[..., 0].T
        except np.linalg.LinAlgError:
            raise Unbounded("a Jacobian is singular") from None
        at = at - step
        if (np.abs(step) <= 1e-15 * np.abs(at)).all():
            break
    return at


def _enclose(space: Space, start: Array, residual: Residual, part: int) -> list[Ball]:
    """Return the roots (lanes,) each: at the centre of the box, or anywhere in it.

    Equations of several unknowns are multiplied by the inverse of the Jacobian's midpoints, so that what is eliminated
    from them is small.
    """
    points = [Ball.exact(row) for row in start]
    excess, slopes = residual([space.constant(point) for point in points])
    scale = find_preconditioner([[jet.value[part].mid for jet in row] for row in slopes], start.shape[1])
    right = scale_rows(scale, [[jet.value[part]] for jet in excess])
    first = eliminate(
        scale_rows(scale, [[jet.value[part] for jet in row] for row in slopes]), [row[0] for row in right]
    )
    rad = np.array([np.abs(ball.mid) + ball.rad for ball in first])
    settled: Flags = np.zeros(start.shape[1], dtype=bool)
    result: list[Ball] = []
    for _ in range(MOST_STEPS):
        rad = np.where(settled, rad, WIDER * rad + 1e-15 * np.abs(start))
        balls = [space.constant(Ball(point.mid, own)) for point, own in zip(points, rad, strict=True)]
        _, slopes = residual(balls)
        matrix = scale_rows(scale, [[jet.value[part] for jet in row] for row in slopes])
        try:
            changes = eliminate(matrix, [row[0] for row in right])
        except Unbounded:
            break
        result = [point - change for point, change in zip(points, changes, strict=True)]
        moved = np.array([np.abs(ball.mid - point.mid) + ball.rad for ball, point in zip(result, points, strict=True)])
        settled = np.asarray((moved * GROWN < rad).all(axis=0))
        if settled.all():
            return result
    raise Unbounded("no ball is mapped into itself by a Newton step")


def _twice(ball: Ball) -> Ball:
    return _pair(ball, ball)


def _pair(centre: Ball, anywhere: Ball) -> Ball:
    return Ball(np.stack([centre.mid, anywhere.mid]), np.stack([centre.rad, anywhere.rad]))
