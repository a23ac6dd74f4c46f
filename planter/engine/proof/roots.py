"""Linear and nonlinear equations of balls and jets, solved in every lane.

Roots over a box are enclosed by interval Newton steps, and their derivatives by Newton steps on
jets. The absence of roots in a domain is shown by bisection: parts that cannot contain a root are
discarded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add, mul
from typing import Any

import numpy as np

from planter.engine.proof.intervals import GROWTH, TINY, Ball, Unbounded, sum_products
from planter.engine.proof.jets import (
    ANYWHERE,
    CENTRE,
    Jet,
    Space,
    join_parts,
    packed_indices,
    packed_size,
    unite_supports,
)
from planter.kernels import Array, Flags, Integers


def solve_by_elimination(
    matrix: Sequence[Sequence[Any]], right: Sequence[Sequence[Any]]
) -> list[list[Any]]:
    """Return X (k, m) of A X = B, of jets or of balls, by elimination without pivoting: the matrix
    A (k, k) is close to the identity.

    Raises Unbounded if it may be singular.
    """
    size = len(matrix)
    rows = [[*row, *sides] for row, sides in zip(matrix, right, strict=True)]
    for k in range(size):
        for i in range(k + 1, size):
            share = rows[i][k] / rows[k][k]
            pairs = zip(rows[i][k + 1 :], rows[k][k + 1 :], strict=True)
            rows[i] = [*rows[i][: k + 1], *(a - share * b for a, b in pairs)]
    solution: list[list[Any]] = []
    for k in reversed(range(size)):
        values = rows[k][size:]
        for factor, solved in zip(reversed(rows[k][k + 1 : size]), solution, strict=True):
            values = [value - factor * y for value, y in zip(values, solved, strict=True)]
        solution.append([value / rows[k][k] for value in values])
    return solution[::-1]


def invert_balls(matrix: Sequence[Sequence[Jet]], part: int) -> list[list[Ball]]:
    """Return the inverse (k, k) of a matrix that is close to the identity, at the centre of the box
    or anywhere in it.
    """
    size, lanes = len(matrix), max(jet.lanes for row in matrix for jet in row)
    unit = [[Ball.exact(np.full(lanes, float(i == j))) for j in range(size)] for i in range(size)]
    return solve_by_elimination([[jet.value[part] for jet in row] for row in matrix], unit)


def invert_centre(matrix: Sequence[Sequence[Jet]]) -> list[list[Jet]]:
    """Return the inverse (k, k) of the midpoints of a matrix at the centre of the box, NaN in
    singular lanes.

    Raises Unbounded if the matrix is singular in every lane.
    """
    lanes = max(jet.lanes for row in matrix for jet in row)
    midpoints = np.array(
        [[np.broadcast_to(jet.value.mid[CENTRE], lanes) for jet in row] for row in matrix]
    )
    matrices = midpoints.transpose(2, 0, 1)
    with np.errstate(all="ignore"):
        is_regular = np.isfinite(matrices).all(axis=(1, 2)) & (np.linalg.det(matrices) != 0)
    if not is_regular.any():
        raise Unbounded("a matrix is singular")
    inverse = np.full(matrices.shape, np.nan)
    inverse[is_regular] = np.linalg.inv(matrices[is_regular])
    inverse = inverse.transpose(1, 2, 0)
    return [[matrix[0][0].space.constant(Ball.exact(entry)) for entry in row] for row in inverse]


def apply_matrix(matrix: Sequence[Sequence[Any]], vector: Sequence[Any]) -> list[Any]:
    """Return the product (k,) of a matrix and a vector of jets, or of balls."""
    return [reduce(add, map(mul, row, vector)) for row in matrix]


def multiply_matrices(
    left: Sequence[Sequence[Any]], right: Sequence[Sequence[Any]]
) -> list[list[Any]]:
    """Return the product (k, m) of two matrices of jets, or of balls."""
    columns = [apply_matrix(left, column) for column in zip(*right, strict=True)]
    return [list(row) for row in zip(*columns, strict=True)]


def solve_linear_jets(
    space: Space, matrix: Sequence[Sequence[Any]], right: Sequence[Any]
) -> list[Jet]:
    """Return the solution y (k,) of simultaneous equations A y = b of jets and numbers over a box.

    Its derivatives solve A y' = b' - A' y and A y'' = b'' - A'' y - 2 A' y'. Raises Unbounded if
    the matrix may be singular.
    """
    pairs = zip(matrix, right, strict=True)
    jets = [[space.lift(entry) for entry in (*row, value)] for row, value in pairs]
    support = unite_supports(jet for row in jets for jet in row)
    jets = [[jet.over(support) for jet in row] for row in jets]
    jets = multiply_matrices(invert_centre([row[:-1] for row in jets]), jets)
    rows, sides = [row[:-1] for row in jets], [row[-1] for row in jets]
    parts = (CENTRE, ANYWHERE)
    inverses = [invert_balls(rows, part) for part in parts]
    values = [apply_matrix(inverses[part], [jet.value[part] for jet in sides]) for part in parts]
    low, high = packed_indices(len(support))
    solution: list[Jet] = []
    for _ in range(ROUNDS):
        slopes = []
        for part in parts:
            changes = apply_matrix([[a.gradient[part] for a in row] for row in rows], values[part])
            rates = [side.gradient[part] - y for side, y in zip(sides, changes, strict=True)]
            slopes.append(apply_matrix(inverses[part], rates))
        y, slope = values[ANYWHERE], slopes[ANYWHERE]
        bends = []
        for row, side in zip(rows, sides, strict=True):
            terms = [
                sum_products(
                    (a.hessian, y[j]),
                    (a.gradient[ANYWHERE][low], slope[j][high]),
                    (a.gradient[ANYWHERE][high], slope[j][low]),
                )
                for j, a in enumerate(row)
            ]
            bends.append(side.hessian - reduce(add, terms))
        bends = apply_matrix(inverses[ANYWHERE], bends)
        solution = _build_jets(space, support, *values, *slopes, bends)
        if not support:
            break
        values = [[jet.value[part] for jet in solution] for part in parts]
    return solution


def _build_jets(space: Space, support: tuple[int, ...], *parts: Sequence[Ball]) -> list[Jet]:
    """Return jets (k,) from values at the centre of the box and anywhere in it, slopes there, and
    bends.
    """
    return [
        space.jet(support, join_parts(at, value), join_parts(slope, rate), bend).cut()
        for at, value, slope, rate, bend in zip(*parts, strict=True)
    ]


BallEquations = Callable[
    [Sequence[Ball], Integers], tuple[Sequence[Ball], Sequence[Sequence[Ball]]]
]
"""Balls (k,) of unknowns in some lanes -> f (k,) and its Jacobian (k, k) there, enclosed."""
MAX_DIVISIONS = 12
"""Maximum number of bisections of a domain."""
MAX_PARTS = 4096
"""Maximum number of parts that are bisected further; lanes with few parts come first."""


def has_rootless_lane(equations: BallEquations, low: Array, high: Array, lanes: int) -> bool:
    """Return whether equations certainly have no root between `low` and `high` (k,) in at least one
    of the lanes.
    """
    lane, open_lanes = np.arange(lanes), np.arange(lanes)
    below, above = (np.repeat(side[:, None], lanes, axis=1) for side in (low, high))
    for _ in range(MAX_DIVISIONS):
        with np.errstate(all="ignore"):  # parts without a root are empty
            below, above = _contract(equations, below, above, lane)
        remaining = np.flatnonzero((below <= above).all(axis=0))
        counts = np.bincount(lane[remaining], minlength=lanes)[open_lanes]
        if not counts.all():
            return True
        order = np.argsort(counts, kind="stable")
        open_lanes = open_lanes[order[np.cumsum(counts[order]) <= MAX_PARTS]]
        remaining = remaining[np.isin(lane[remaining], open_lanes)]
        if not len(remaining):
            return False
        below, above, lane = below[:, remaining], above[:, remaining], lane[remaining]
        widest = ((above - below) / (high - low)[:, None]).argmax(axis=0)
        indices, middle = np.arange(len(lane)), below + (above - below) / 2
        ends, starts = above.copy(), below.copy()
        ends[widest, indices] = starts[widest, indices] = middle[widest, indices]
        below, above = (
            np.concatenate([below, starts], axis=1),
            np.concatenate([ends, above], axis=1),
        )
        lane = np.concatenate([lane, lane])
    return False


def _contract(
    equations: BallEquations, low: Array, high: Array, lane: Integers
) -> tuple[Array, Array]:
    """Return parts (k, n) without margins that contain no root; a part without a root gets `low`
    above `high`.

    By the mean value theorem, a root lies in m - f(m) / f' in each unknown, for a point m and all
    others anywhere.
    """
    low, high = low.copy(), high.copy()
    values, slopes = equations([Ball.between(*side) for side in zip(low, high, strict=True)], lane)
    for value in values:
        rootless = (value.low > 0) | (value.high < 0)
        low[:, rootless], high[:, rootless] = np.inf, -np.inf
    for j in range(len(low)):
        point = [Ball.between(*side) for side in zip(low, high, strict=True)]
        point[j] = Ball.exact(point[j].mid)
        values, _ = equations(point, lane)
        for value, row in zip(values, slopes, strict=True):
            try:
                root = point[j] - value / row[j]
            except Unbounded:
                continue
            low[j], high[j] = np.fmax(low[j], root.low), np.fmin(high[j], root.high)
    return low, high


Residual = Callable[[Sequence[Jet]], tuple[Sequence[Jet], Sequence[Sequence[Jet]]]]
"""a (k,) -> f(a) (k,) and its Jacobian (k, k), both over the box."""
WIDER = 1.5
"""Width of each trial relative to the Newton step."""
MAX_NEWTON_STEPS = 30
SMALL_STEP = 1e-9
"""Relative size of the last Newton step; the remaining error is of the order of its square."""
ROUNDS = 2
"""Passes over roots on a box; each starts from values narrowed by the derivatives of the one before."""
NARROW = 0.02
"""Derivatives whose radii are below this share of the largest are not narrowed further."""


@dataclass(frozen=True)
class EnclosedRoots:
    """Roots (k,) over a box, each the only one, at every design, within `radii` (k, lanes) of
    `points` (k, lanes).
    """

    jets: list[Jet]
    points: Array
    radii: Array


def enclose_roots(space: Space, start: Array, residual: Residual) -> EnclosedRoots:
    """Return the roots a(x) (k,) of f(a, x) near `start` (k, lanes), over the box, of jets in
    `space`.

    Newton's step N(A) = s - f_a(A)^-1 f(s) from a point s maps balls A into themselves: then A
    holds exactly one root at each design. Its derivatives solve f_a a' = -f_x and f_a a'' = -(f_xx
    + 2 f_xa a' + f_aa a' a'). On the right is, at each design x*, the gradient of f(a(x*), x), with
    constants in place of roots, and the Hessian of f along the lines a(x*) + a'(x*) (x - x*).
    Derivatives narrow the values from which they are computed; therefore two passes.

    Lanes without a ball that is mapped into itself are NaN. Raises Unbounded if no lane has one.
    """
    at = _refine(space, start, residual)
    excess, slopes = residual([space.constant(Ball.exact(row)) for row in at])
    scale, support = invert_centre(slopes), unite_supports(excess)

    def scaled(a: Sequence[Jet]) -> tuple[list[Jet], list[list[Jet]]]:
        """Return f(a) and its Jacobian, multiplied by the inverse of the Jacobian at the centre."""
        excess, slopes = residual(a)
        rows = apply_matrix(scale, excess)
        return [row.over(support) for row in rows], multiply_matrices(scale, slopes)

    def divide(right: Sequence[Ball], matrix: Sequence[Sequence[Jet]], part: int) -> list[Ball]:
        return [-y for y in apply_matrix(invert_balls(matrix, part), right)]

    middle, _ = _enclose(space, at, scaled, CENTRE)
    values, radii = _enclose(space, at, scaled, ANYWHERE)
    excess, jacobian = scaled([space.constant(value) for value in middle])
    centre = divide([jet.gradient[CENTRE] for jet in excess], jacobian, CENTRE)
    flat, jets = Ball.exact(np.zeros((packed_size(len(support)), 1))), list[Jet]()
    for _ in range(ROUNDS):
        excess, jacobian = scaled([space.constant(value) for value in values])
        matrix = scaled(jets)[1] if jets else jacobian
        rates = divide([jet.gradient[ANYWHERE] for jet in excess], matrix, ANYWHERE)
        lines = [
            space.jet(support, join_parts(value, value), join_parts(rate, rate), flat)
            for value, rate in zip(values, rates, strict=True)
        ]
        space.is_cutting = False  # lines hold at single designs, where Taylor forms do not
        try:
            excess, _ = scaled(lines)
        finally:
            space.is_cutting = True
        bends = divide([jet.hessian for jet in excess], jacobian, ANYWHERE)
        jets = _build_jets(space, support, middle, values, centre, rates, bends)
        if all((rate.rad <= NARROW * np.abs(rate.mid).max(initial=0)).all() for rate in rates):
            break
        values = [jet.value[ANYWHERE] for jet in jets]
    return EnclosedRoots(jets, at, radii)


def _refine(space: Space, start: Array, residual: Residual) -> Array:
    """Return a point (k, lanes) closer to the roots at the box's centre, by Newton's method in
    plain numbers.
    """
    at = np.array(start, dtype=float)
    for _ in range(MAX_NEWTON_STEPS):
        excess, slopes = residual([space.constant(Ball.exact(row)) for row in at])
        right, *matrix = (
            np.array([np.broadcast_to(jet.value.mid[CENTRE], at.shape[1]) for jet in row])
            for row in (excess, *slopes)
        )
        try:
            step = np.linalg.solve(np.array(matrix).transpose(2, 0, 1), right.T[..., None])
        except np.linalg.LinAlgError:
            raise Unbounded("a Jacobian is singular") from None
        at = at - step[..., 0].T
        if not (np.abs(step[..., 0].T) > SMALL_STEP * np.abs(at)).any():
            break
    return at


def _enclose(space: Space, start: Array, residual: Residual, part: int) -> tuple[list[Ball], Array]:
    """Return the roots (lanes,) each: at the centre of the box, or anywhere in it, and the radii
    (k, lanes) about `start` of balls that hold no other.

    Equations of several unknowns are multiplied by the inverse of the Jacobian's midpoints, so that
    elimination changes them little.
    """
    points = [Ball.exact(row) for row in start]
    excess, slopes = residual([space.constant(point) for point in points])
    right = [jet.value[part] for jet in excess]
    first = apply_matrix(invert_balls(slopes, CENTRE), right)
    rad, moved = np.zeros(start.shape), np.array([np.abs(ball.mid) + ball.rad for ball in first])
    settled: Flags = np.zeros(start.shape[1], dtype=bool)
    for _ in range(MAX_NEWTON_STEPS):
        rad = np.where(moved * GROWTH < rad, rad, WIDER * moved + 1e-15 * np.abs(start) + TINY)
        _, slopes = residual([space.constant(Ball(*pair)) for pair in zip(start, rad, strict=True)])
        try:
            changes = apply_matrix(invert_balls(slopes, part), right)
        except Unbounded:
            break
        result = [point - change for point, change in zip(points, changes, strict=True)]
        moved = np.abs([b.mid for b in result] - start) + [b.rad for b in result]
        settled = np.asarray((moved * GROWTH < rad).all(axis=0))
        if (settled | ~np.isfinite(moved).all(axis=0)).all():
            break
    if not settled.any():
        raise Unbounded("no ball is mapped into itself by a Newton step")
    balls = [Ball(np.where(settled, ball.mid, np.nan), ball.rad) for ball in result]
    return balls, np.where(settled, rad, np.nan)
