"""The angle curve that comes closest to all poses and is monotone.

Two steps. First, where on a turn of the carrier each pose is met and with which arm angle: the sum
of squares of how far both ends of the arm, tip and moving hinge, are from their places in the poses
is minimised, while between neighbouring poses the slope of the arm against the carrier stays within
its bounds. This minimum is a lower bound for every monotone curve. Then, of all C2 cubics with
those slopes through the optimal points, the one with the smallest bending integral. Derivatives are
those of the generated formulas.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import permutations

import numpy as np
import scipy
from numpy.typing import NDArray

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import extrema
from planter.numerics.arrays import TURN, to_degrees, wrap_angle
from planter.papers.mapping import model
from planter.papers.mapping.curve import AngleCurve, closed_turn
from planter.papers.mapping.dyads import Dyad
from planter.papers.mapping.linkage import one_turn
from planter.papers.mapping.results import Missed

SLOPES = (0.1, 10.0)
"""Least and largest slope of the curve."""
_MARGINS = (1.25, 1.6, 2.5)
"""Between poses the slopes keep this factor from their bounds: the first that leaves room for a
smooth curve.
"""
_ALL_ORDERS, _SWAPPED_ORDERS = 5, 20
"""Up to so many poses every order on the turn is tried, or that of the crank and exchanged
neighbours.
"""
_GAP = TURN / 60
"""Largest distance of neighbouring points of the spline."""
_GRADING = 3
"""Largest ratio of neighbouring gaps: where the slope must change within a short way, points are
close.
"""
_SAME = 1e-5
"""Points that are closer [rad] are one."""
_ROUNDING = 1e-6
"""Share by which the solver may miss a bound."""
_APART = 1e-6
"""Smallest difference of the carrier angles [rad] of two poses that a curve passes."""


@dataclass(frozen=True)
class Nearest:
    """The curve and its misses, one for each pose; `order` are the poses as the carrier meets
    them.
    """

    curve: AngleCurve
    misses: list[Missed]
    order: tuple[int, ...]


def find_nearest(dyad: Dyad, poses: Array, slopes: tuple[float, float] = SLOPES) -> Nearest:
    """Return the closest curve for a carrier dyad and poses (n, 3).

    Raises ComputationError if the search fails.
    """
    *margins, last = _MARGINS
    for margin in margins:
        with suppress(ComputationError):
            return _nearest(dyad, poses, slopes, margin)
    return _nearest(dyad, poses, slopes, last)


def _nearest(dyad: Dyad, poses: Array, slopes: tuple[float, float], margin: float) -> Nearest:
    aim = _Aim(dyad, poses, (slopes[0] * margin, slopes[1] / margin))
    trials = [trial for order in _orders(aim.crank) if (trial := aim.fit_order(order)) is not None]
    if not trials:
        raise ComputationError("no monotone angle curve was trial near the poses")
    _, theta, phi, order = min(trials, key=lambda trial: trial[0])
    curve = fit_smooth_curve(theta, phi - theta, slopes)
    return Nearest(curve, list(list_misses(dyad, poses, curve, theta)), order)


def list_misses(dyad: Dyad, poses: Array, curve: AngleCurve, theta: Array) -> Iterator[Missed]:
    """Return the miss of each pose at given carrier angles (n,)."""
    phi = curve.at(theta) + theta
    gaps = model.arm(theta, phi, dyad.vector) - _target_places(dyad, poses)
    for k, gap in enumerate(gaps.T):
        yield Missed(
            k + 1,
            to_degrees(theta[k] % TURN),
            float(np.hypot(*gap[:2])) * 1e3,
            float(np.hypot(*gap[2:])) * 1e3,
            float(np.degrees(wrap_angle(phi[k] - poses[k, 2]))),
        )


def find_misses(dyad: Dyad, poses: Array, curve: AngleCurve) -> list[Missed]:
    """Return the miss of each pose where the curve is closest to it with both ends of the arm."""
    grid = np.linspace(0, TURN, 1440, endpoint=False)
    theta = []
    for pose in _target_places(dyad, poses).T:

        def gap(angles: Array, pose: Array = pose) -> Array:
            places = model.arm(angles, curve.at(angles) + angles, dyad.vector)
            return ((places - pose[:, None]) ** 2).sum(axis=0)

        theta.append(extrema.find_minimum(gap, grid, closed=True).place)
    return list(list_misses(dyad, poses, curve, np.array(theta)))


def _target_places(dyad: Dyad, poses: Array) -> Array:
    """Places of tip and moving hinge (4, n) in the poses."""
    return np.vstack([poses[:, :2].T, model.place_point(poses, dyad.point).T])


def _orders(crank: Array) -> Iterator[tuple[int, ...]]:
    """Orders in which the poses may follow each other round the turn, that of the crank angles
    first.
    """
    natural = tuple(int(k) for k in np.argsort(np.mod(crank, TURN)))
    if len(natural) <= _ALL_ORDERS:
        yield from ((natural[0], *rest) for rest in permutations(natural[1:]))
        return
    yield natural
    for k in range(len(natural) if len(natural) <= _SWAPPED_ORDERS else 0):
        j = (k + 1) % len(natural)
        swapped = list(natural)
        swapped[k], swapped[j] = swapped[j], swapped[k]
        yield tuple(swapped)


class _Aim:
    """The first step: unknowns are carrier and arm angle (n,) of each pose, in the order they are
    met.
    """

    def __init__(self, dyad: Dyad, poses: Array, slopes: tuple[float, float]) -> None:
        self.dyad, self.poses = dyad, poses
        self.least_slope, self.largest_slope = slopes
        self.targets = _target_places(dyad, poses)
        self.crank = dyad.carrier_angles(poses)
        self.size = (
            float(np.hypot(*(poses[:, :2] - poses[:, :2].mean(axis=0)).T).max()) + dyad.radius
        )

    def fit_order(
        self, order: tuple[int, ...]
    ) -> tuple[float, Array, Array, tuple[int, ...]] | None:
        """Sum of squares, carrier and arm angles in the order of the poses; None where the search
        fails.
        """
        sequence = np.array(order)
        start = self._start(sequence)
        matrix, lower = self._steps(len(order))
        optimum = scipy.optimize.minimize(
            lambda z: self._cost(z, sequence),
            start,
            jac=True,
            method="SLSQP",
            constraints=scipy.optimize.LinearConstraint(matrix, lower, np.inf),
            options={"maxiter": 300, "ftol": 1e-15},
        )
        if (matrix @ optimum.x - lower).min() < -1e-9:
            return None
        count = len(order)
        theta, phi = np.empty(count), np.empty(count)
        theta[sequence], phi[sequence] = optimum.x[:count], optimum.x[count:]
        return float(optimum.fun), theta, phi, order

    def _start(self, sequence: Array) -> Array:
        """Carrier and arm angles as the poses have them, on one turn."""
        theta, phi = on_one_turn(self.crank, self.poses[:, 2])
        return np.concatenate([theta[sequence], phi[sequence]])

    def _steps(self, count: int) -> tuple[Array, Array]:
        """Bounds on the steps from pose to pose, the last step leading to the first pose a turn
        later.
        """
        step = np.roll(np.eye(count), 1, axis=1) - np.eye(count)
        turned = np.zeros(count)
        turned[-1] = TURN
        falls = np.hstack([step, -step])
        carrier = np.hstack([step, np.zeros_like(step)])
        matrix = np.vstack(
            [falls - self.least_slope * carrier, self.largest_slope * carrier - falls]
        )
        return matrix, np.concatenate(
            [(self.least_slope - 1) * turned, (1 - self.largest_slope) * turned]
        )

    def _cost(self, z: Array, sequence: Array) -> tuple[float, Array]:
        theta, phi = np.split(z, 2)
        places, by_theta, by_phi = model.arm_slopes(theta, phi, self.dyad.vector)
        gaps = (places - self.targets[:, sequence]) / self.size
        slopes = (
            np.concatenate([(gaps * by_theta).sum(axis=0), (gaps * by_phi).sum(axis=0)]) / self.size
        )
        return float((gaps**2).sum() / 2), slopes


def on_one_turn(crank: Array, phi: Array) -> tuple[Array, Array]:
    """Carrier and arm angles (n,) of poses with whole turns added, as they follow each other on one
    closed turn.
    """
    turn = one_turn(crank, phi)
    first = turn.order[0]
    theta, relative = np.empty(len(crank)), np.empty(len(crank))
    theta[turn.order] = np.mod(crank[first], TURN) + np.append(0, np.cumsum(turn.ahead[:-1]))
    relative[turn.order] = (
        phi[first] - np.mod(crank[first], TURN) - np.append(0, np.cumsum(turn.falls[:-1]))
    )
    return theta, relative + theta


def interpolate_poses(dyad: Dyad, poses: Array) -> AngleCurve | None:
    """Return the curve through the exact poses alone, monotone or not; None if two of them share a
    carrier angle.
    """
    theta, phi = on_one_turn(dyad.carrier_angles(poses), poses[:, 2])
    if len(poses) < 2 or np.diff(np.sort(theta)).min() < _APART:
        return None
    return closed_turn(theta, phi - theta)


def fit_smooth_curve(theta: Array, relative: Array, slopes: tuple[float, float]) -> AngleCurve:
    """Return the periodic C2 cubic of least bending through points (n,) [rad] of one falling turn,
    its slope in bounds.

    The integral of the squared second derivative is minimised over the ordinates of further points:
    a convex quadratic programme, in which every curve is a linear function of its ordinates.

    Raises ComputationError if no curve has such slopes.
    """

    angles, rest = _periodic(theta, relative)
    nodes, fixed = _nodes(angles)
    bends, slope = _operators(nodes)
    values = np.zeros(len(nodes))
    values[fixed] = rest
    free = np.logical_not(fixed)
    factor, root = np.linalg.qr(bends[:, free])
    # In the variables w = root y the objective is |w + factor' bends y0|^2 / 2: its Hessian is the
    # identity.
    target = factor.T @ bends[:, fixed] @ values[fixed]
    back = np.linalg.inv(root)
    matrix, level = -slope[:, free] @ back, 1 - slope[:, fixed] @ values[fixed]
    optimum = scipy.optimize.minimize(
        lambda w: (float(np.sum((w + target) ** 2) / 2), w + target),
        -target,
        jac=True,
        method="SLSQP",
        constraints=scipy.optimize.LinearConstraint(matrix, slopes[0] - level, slopes[1] - level),
        options={"maxiter": 200, "ftol": 1e-12},
    )
    values[free] = back @ optimum.x
    curve = closed_turn(nodes, values - nodes)
    lowest, largest = curve.extremes
    if not (
        lowest.value >= slopes[0] * (1 - _ROUNDING) and largest.value <= slopes[1] * (1 + _ROUNDING)
    ):
        raise ComputationError(
            f"no smooth curve with slopes from {slopes[0]:g} to {slopes[1]:g} passes the points "
            f"closest to the poses: its slope goes from {lowest.value:.6g} to {largest.value:.6g}"
        )
    return curve


def _periodic(theta: Array, relative: Array) -> tuple[Array, Array]:
    """Return the carrier angles within a turn, in order, and the rotation less that of a uniform
    turn.

    A turn of the carrier takes the rotation back by as much, so that their sum is periodic. Points
    that fall onto each other are one.
    """
    order = np.argsort(np.mod(theta, TURN))
    angles, rest = np.mod(theta, TURN)[order], (relative + theta)[order]
    separate = np.append(True, np.diff(angles) > _SAME) & (angles < angles[0] + TURN - _SAME)
    return angles[separate], rest[separate]


def _nodes(angles: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the points of the spline within a turn, and which of them are the points of the
    curve.
    """
    nodes = list(angles)
    while (wide := _too_wide(np.array(nodes))).any():
        widths = np.diff([*nodes, nodes[0] + TURN])
        nodes = sorted([*nodes, *(np.array(nodes) + widths / 2)[wide]])
    return np.array(nodes), np.isin(nodes, angles)


def _too_wide(nodes: Array) -> NDArray[np.bool_]:
    """Return which gaps to halve: large ones, and those that are much larger than a neighbour."""
    widths = np.diff([*nodes, nodes[0] + TURN])
    neighbours = np.minimum(np.roll(widths, 1), np.roll(widths, -1))
    return np.asarray(widths > np.minimum(_GAP, _GRADING * neighbours))


def _operators(nodes: Array) -> tuple[Array, Array]:
    """Matrices that take ordinates (n,) to the root of the bending and to the Bezier ordinates of
    the slope (2 n, n).

    Between two points the slope is a parabola, and no further out than its three Bezier ordinates.
    """

    closed = np.append(nodes, nodes[0] + TURN)
    ordinates = np.vstack([np.eye(len(nodes)), np.eye(len(nodes))[:1]])
    spline = scipy.interpolate.CubicSpline(closed, ordinates, bc_type="periodic")
    widths = np.diff(closed)
    # The second derivative is linear between points: Gauss' two places integrate its square
    # exactly.
    gauss = (nodes[:, None] + widths[:, None] * (1 + np.array([-1, 1]) / np.sqrt(3)) / 2).ravel()
    weights = np.sqrt(np.repeat(widths / 2, 2))
    ends = spline(nodes, 1)
    middles = ends + spline(nodes, 2) * widths[:, None] / 2
    return spline(gauss, 2) * weights[:, None], np.vstack([ends, middles])
