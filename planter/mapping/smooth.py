"""The periodic C2 cubic that bends least, of all that pass given points with slopes between two bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planter.errors import ComputationError
from planter.kernels import Array
from planter.mapping.curve import AngleCurve, closed_turn
from planter.numerics.angles import TURN

_GAP = TURN / 60
"""Largest distance of neighbouring points of the spline."""
_GRADING = 3
"""Largest ratio of neighbouring gaps: where the slope must change within a short way, points are close."""
_SAME = 1e-5
"""Points that are closer [rad] are one."""
_ROUNDING = 1e-6
"""Share by which the solver may miss a bound."""


def least_bent(theta: Array, relative: Array, slopes: tuple[float, float]) -> AngleCurve:
    """The curve through points (n,) [rad] of one falling turn, its slope between the two bounds.

    The integral of the squared second derivative is made least over the ordinates of further points: a convex
    quadratic programme, in which every curve is a linear function of its ordinates.

    Raises ComputationError where no curve has such slopes.
    """
    from scipy.optimize import LinearConstraint, minimize

    given, rest = _periodic(theta, relative)
    nodes, fixed = _nodes(given)
    bends, slope = _operators(nodes)
    values = np.zeros(len(nodes))
    values[fixed] = rest
    free = np.logical_not(fixed)
    factor, root = np.linalg.qr(bends[:, free])
    # In the variables w = root y the objective is |w + factor' bends y0|^2 / 2: its Hessian is the identity.
    target = factor.T @ bends[:, fixed] @ values[fixed]
    back = np.linalg.inv(root)
    matrix, level = -slope[:, free] @ back, 1 - slope[:, fixed] @ values[fixed]
    found = minimize(
        lambda w: (float(np.sum((w + target) ** 2) / 2), w + target), -target, jac=True, method="SLSQP",
        constraints=LinearConstraint(matrix, slopes[0] - level, slopes[1] - level),
        options={"maxiter": 200, "ftol": 1e-12},
    )  # fmt: skip
    values[free] = back @ found.x
    curve = closed_turn(nodes, values - nodes)
    least, largest = curve.extremes
    if not (least.value >= slopes[0] * (1 - _ROUNDING) and largest.value <= slopes[1] * (1 + _ROUNDING)):
        raise ComputationError(
            f"no smooth curve with slopes from {slopes[0]:g} to {slopes[1]:g} passes what is closest to the poses: "
            f"its slope goes from {least.value:.6g} to {largest.value:.6g}"
        )
    return curve


def _periodic(theta: Array, relative: Array) -> tuple[Array, Array]:
    """Carrier angles within a turn, in order, and what is left of the rotation beside a uniform turn.

    A turn of the carrier takes the rotation back by as much, so that their sum is periodic. Points that fall onto
    each other are one.
    """
    order = np.argsort(np.mod(theta, TURN))
    angles, rest = np.mod(theta, TURN)[order], (relative + theta)[order]
    kept = np.append(True, np.diff(angles) > _SAME) & (angles < angles[0] + TURN - _SAME)
    return angles[kept], rest[kept]


def _nodes(given: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Places of the points of the spline within a turn, and which of them are the given ones."""
    nodes = list(given)
    while (wide := _too_wide(np.array(nodes))).any():
        widths = np.diff([*nodes, nodes[0] + TURN])
        nodes = sorted([*nodes, *(np.array(nodes) + widths / 2)[wide]])
    return np.array(nodes), np.isin(nodes, given)


def _too_wide(nodes: Array) -> NDArray[np.bool_]:
    """Which gaps to halve: large ones, and those that are much larger than a neighbour."""
    widths = np.diff([*nodes, nodes[0] + TURN])
    beside = np.minimum(np.roll(widths, 1), np.roll(widths, -1))
    return np.asarray(widths > np.minimum(_GAP, _GRADING * beside))


def _operators(nodes: Array) -> tuple[Array, Array]:
    """Matrices that take ordinates (n,) to the root of the bending and to the Bezier ordinates of the slope (2 n, n).

    Between two points the slope is a parabola, and no further out than its three Bezier ordinates.
    """
    from scipy.interpolate import CubicSpline

    closed = np.append(nodes, nodes[0] + TURN)
    ordinates = np.vstack([np.eye(len(nodes)), np.eye(len(nodes))[:1]])
    spline = CubicSpline(closed, ordinates, bc_type="periodic")
    widths = np.diff(closed)
    # The second derivative is linear between points: Gauss' two places integrate its square exactly.
    gauss = (nodes[:, None] + widths[:, None] * (1 + np.array([-1, 1]) / np.sqrt(3)) / 2).ravel()
    weights = np.sqrt(np.repeat(widths / 2, 2))
    ends = spline(nodes, 1)
    middles = ends + spline(nodes, 2) * widths[:, None] / 2
    return spline(gauss, 2) * weights[:, None], np.vstack([ends, middles])
