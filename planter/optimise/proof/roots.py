"""Roots over a box: enclosed by interval Newton steps, their derivatives by Newton steps on jets."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.proof.balls import GROWN, Ball, Unbounded
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space, join_parts, packed
from planter.optimise.proof.linear import ROUNDS, BallSolver, invert_centre, multiply

Residual = Callable[[Sequence[Jet]], tuple[Sequence[Jet], Sequence[Sequence[Jet]]]]
"""a (k,) -> f(a) (k,) and its Jacobian (k, k), both over the box."""
WIDER = 1.5
"""How much wider than a Newton step each trial is."""
MOST_STEPS = 30
SMALL_STEP = 1e-9
"""Relative size of the last Newton step: the error after it goes with its square."""
NARROW = 0.02
"""Derivatives whose radii are below this share of the largest are not narrowed further."""


def roots(space: Space, start: Array, residual: Residual) -> list[Jet]:
    """Return the roots a(x) (k,) of f(a, x) near `start` (k, lanes), over the box, of jets in `space`.

    Newton's step N(A) = s - f_a(A)^-1 f(s) from a point s maps balls A into themselves: then A holds exactly one root
    at each design. Its derivatives solve f_a a' = -f_x and f_a a'' = -(f_xx + 2 f_xa a' + f_aa a' a'). On the right is,
    at each design x*, the gradient of f(a(x*), x), with constants in place of roots, and the Hessian of f along the
    lines a(x*) + a'(x*) (x - x*). Derivatives narrow the values that they are formed of, so all is done twice.

    NaN in lanes where no balls are found that are mapped into themselves; raises Unbounded where that is so in every
    lane.
    """
    at = _refine(space, start, residual)
    excess, slopes = residual([space.constant(Ball.exact(row)) for row in at])
    scale, felt = invert_centre(slopes), tuple(sorted({k for jet in excess for k in jet.felt}))

    def scaled(a: Sequence[Jet]) -> tuple[list[Jet], list[list[Jet]]]:
        """Return f(a) and its Jacobian, multiplied by the inverse of the Jacobian at the centre."""
        excess, slopes = residual(a)
        return [row[0].over(felt) for row in multiply(scale, [[jet] for jet in excess])], multiply(scale, slopes)

    middle, values = (_enclose(space, at, scaled, part) for part in (CENTRE, ANYWHERE))
    excess, jacobian = scaled([space.constant(value) for value in middle])
    centre = _divide([jet.gradient[CENTRE] for jet in excess], jacobian, CENTRE)
    flat, jets = Ball.exact(np.zeros((packed(len(felt)), 1))), list[Jet]()
    for _ in range(ROUNDS):
        excess, jacobian = scaled([space.constant(value) for value in values])
        rates = _divide([jet.gradient[ANYWHERE] for jet in excess], scaled(jets)[1] if jets else jacobian, ANYWHERE)
        lines = [
            Jet(space, felt, join_parts(value, value), join_parts(rate, rate), flat)
            for value, rate in zip(values, rates, strict=True)
        ]
        with space.at_points():
            bends = _divide([jet.hessian for jet in scaled(lines)[0]], jacobian, ANYWHERE)
        jets = [
            Jet(space, felt, join_parts(*value), join_parts(*rate), bend).cut()
            for *value, rate, bend in zip(middle, values, zip(centre, rates, strict=True), bends, strict=True)
        ]
        if all((rate.rad <= NARROW * np.abs(rate.mid).max(initial=0)).all() for rate in rates):
            break
        values = [jet.value[ANYWHERE] for jet in jets]
    return jets


def _divide(right: Sequence[Ball], matrix: Sequence[Sequence[Jet]], part: int) -> list[Ball]:
    """Return the solution of equations with a matrix of jets, anywhere in the box or at its centre, and a right -b."""
    return [-y for y in BallSolver([[jet.value[part] for jet in row] for row in matrix]).solve(right)]


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
        if not (np.abs(step) > SMALL_STEP * np.abs(at)).any():
            break
    return at


def _enclose(space: Space, start: Array, residual: Residual, part: int) -> list[Ball]:
    """Return the roots (lanes,) each: at the centre of the box, or anywhere in it.

    Equations of several unknowns are multiplied by the inverse of the Jacobian's midpoints, so that what is eliminated
    from them is small.
    """
    points = [Ball.exact(row) for row in start]
    excess, slopes = residual([space.constant(point) for point in points])
    right = [jet.value[part] for jet in excess]
    first = BallSolver([[jet.value[CENTRE] for jet in row] for row in slopes]).solve(right)
    rad = np.array([np.abs(ball.mid) + ball.rad for ball in first])
    settled: Flags = np.zeros(start.shape[1], dtype=bool)
    for _ in range(MOST_STEPS):
        rad = np.where(settled, rad, WIDER * rad + 1e-15 * np.abs(start))
        balls = [space.constant(Ball(point.mid, own)) for point, own in zip(points, rad, strict=True)]
        _, slopes = residual(balls)
        try:
            changes = BallSolver([[jet.value[part] for jet in row] for row in slopes]).solve(right)
        except Unbounded:
            break
        result = [point - change for point, change in zip(points, changes, strict=True)]
        moved = np.array([np.abs(ball.mid - point.mid) + ball.rad for ball, point in zip(result, points, strict=True)])
        settled = np.asarray((moved * GROWN < rad).all(axis=0))
        if (settled | ~np.isfinite(moved).all(axis=0)).all():
            break
    if not settled.any():
        raise Unbounded("no ball is mapped into itself by a Newton step")
    return [Ball(np.where(settled, ball.mid, np.nan), ball.rad) for ball in result]
