"""The angle curve that comes closest to all poses and is monotone.

Two steps. First, where on a turn of the carrier each pose is met and with which arm angle: the sum of squares of how
far both ends of the arm, tip and moving hinge, are from their places in the poses is made least, while between
neighbouring poses the arm turns against the carrier by no less than the least slope allows and no more than the
largest. This is a bound for every monotone curve. Then, of all C2 cubics with those slopes through what was found,
the one that bends least. Derivatives are those of the generated formulas.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.mapping import model
from planter.mapping.curve import AngleCurve, closed_turn
from planter.mapping.defects import one_turn
from planter.mapping.dyads import Dyad
from planter.mapping.smooth import least_bent
from planter.numerics import extremes
from planter.numerics.angles import TURN, wrapped

SLOPES = (0.1, 10.0)
"""Least and largest slope of the curve."""
_MARGINS = (1.25, 1.6, 2.5)
"""Between poses the slopes keep this factor from their bounds: the first that leaves room for a smooth curve."""
_ALL_ORDERS, _SWAPPED_ORDERS = 5, 20
"""Up to so many poses every order on the turn is tried, or that of the crank and exchanged neighbours."""


@dataclass(frozen=True)
class Miss:
    """How a pose is missed at the carrier angle [rad] where the curve meets it: tip, moving hinge [m], angle [rad]."""

    carrier: float
    tip: float
    hinge: float
    angle: float


@dataclass(frozen=True)
class Nearest:
    """The curve and its misses, one for each pose; `order` are the poses as the carrier meets them."""

    curve: AngleCurve
    misses: list[Miss]
    order: tuple[int, ...]


def nearest(dyad: Dyad, poses: Array, slopes: tuple[float, float] = SLOPES) -> Nearest:
    """The closest curve for a carrier dyad and poses (n, 3). Raises ComputationError where none is found."""
    *margins, last = _MARGINS
    for margin in margins:
        with suppress(ComputationError):
            return _nearest(dyad, poses, slopes, margin)
    return _nearest(dyad, poses, slopes, last)


def _nearest(dyad: Dyad, poses: Array, slopes: tuple[float, float], margin: float) -> Nearest:
    aim = _Aim(dyad, poses, (slopes[0] * margin, slopes[1] / margin))
    trials = [found for order in _orders(aim.crank) if (found := aim.met(order)) is not None]
    if not trials:
        raise ComputationError("no monotone angle curve was found near the poses")
    _, theta, phi, order = min(trials, key=lambda trial: trial[0])
    curve = least_bent(theta, phi - theta, slopes)
    return Nearest(curve, list(missed(dyad, poses, curve, theta)), order)


def missed(dyad: Dyad, poses: Array, curve: AngleCurve, theta: Array) -> Iterator[Miss]:
    """Return the miss of each pose at given carrier angles (n,)."""
    phi = curve.at(theta) + theta
    gaps = model.arm(theta, phi, dyad.vector) - _target_places(dyad, poses)
    for k, gap in enumerate(gaps.T):
        turned = wrapped(phi[k] - poses[k, 2])
        yield Miss(float(theta[k]), float(np.hypot(*gap[:2])), float(np.hypot(*gap[2:])), float(turned))


def met_by(dyad: Dyad, poses: Array, curve: AngleCurve) -> list[Miss]:
    """Return the miss of each pose where the curve is closest to it with both ends of the arm."""
    grid = np.linspace(0, TURN, 1440, endpoint=False)
    theta = []
    for pose in _target_places(dyad, poses).T:

        def gap(angles: Array, pose: Array = pose) -> Array:
            places = model.arm(angles, curve.at(angles) + angles, dyad.vector)
            return ((places - pose[:, None]) ** 2).sum(axis=0)

        theta.append(extremes.least(gap, grid, closed=True).place)
    return list(missed(dyad, poses, curve, np.array(theta)))


def _target_places(dyad: Dyad, poses: Array) -> Array:
    """Places of tip and moving hinge (4, n) in the poses."""
    return np.vstack([poses[:, :2].T, model.placed(poses, dyad.point).T])


def _orders(crank: Array) -> Iterator[tuple[int, ...]]:
    """Orders in which the poses may follow each other round the turn, that of the crank angles first."""
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
    """The first step: unknowns are carrier and arm angle (n,) of each pose, in the order they are met."""

    def __init__(self, dyad: Dyad, poses: Array, slopes: tuple[float, float]) -> None:
        self.dyad, self.poses = dyad, poses
        self.least, self.largest = slopes
        self.targets = _target_places(dyad, poses)
        dx, dy = self.targets[2:] - dyad.centre[:, None]
        self.crank = np.arctan2(dy, dx)
        self.size = float(np.hypot(*(poses[:, :2] - poses[:, :2].mean(axis=0)).T).max()) + dyad.radius

    def met(self, order: tuple[int, ...]) -> tuple[float, Array, Array, tuple[int, ...]] | None:
        """Sum of squares, carrier and arm angles in the order of the poses; None where the search fails."""
        from scipy.optimize import LinearConstraint, minimize

        sequence = np.array(order)
        start = self._start(sequence)
        matrix, lower = self._steps(len(order))
        found = minimize(
            lambda z: self._cost(z, sequence), start, jac=True, method="SLSQP",
            constraints=LinearConstraint(matrix, lower, np.inf), options={"maxiter": 300, "ftol": 1e-15},
        )  # fmt: skip
        if (matrix @ found.x - lower).min() < -1e-9:
            return None
        count = len(order)
        theta, phi = np.empty(count), np.empty(count)
        theta[sequence], phi[sequence] = found.x[:count], found.x[count:]
        return float(found.fun), theta, phi, order

    def _start(self, sequence: Array) -> Array:
        """Carrier and arm angles as the poses have them, on one turn."""
        theta, phi = on_one_turn(self.crank, self.poses[:, 2])
        return np.concatenate([theta[sequence], phi[sequence]])

    def _steps(self, count: int) -> tuple[Array, Array]:
        """Bounds on the steps from pose to pose, the last step leading to the first pose a turn later."""
        step = np.roll(np.eye(count), 1, axis=1) - np.eye(count)
        turned = np.zeros(count)
        turned[-1] = TURN
        falls = np.hstack([step, -step])
        carrier = np.hstack([step, np.zeros_like(step)])
        matrix = np.vstack([falls - self.least * carrier, self.largest * carrier - falls])
        return matrix, np.concatenate([(self.least - 1) * turned, (1 - self.largest) * turned])

    def _cost(self, z: Array, sequence: Array) -> tuple[float, Array]:
        theta, phi = np.split(z, 2)
        places, by_theta, by_phi = model.arm_slopes(theta, phi, self.dyad.vector)
        gaps = (places - self.targets[:, sequence]) / self.size
        slopes = np.concatenate([(gaps * by_theta).sum(axis=0), (gaps * by_phi).sum(axis=0)]) / self.size
        return float((gaps**2).sum() / 2), slopes


def on_one_turn(crank: Array, phi: Array) -> tuple[Array, Array]:
    """Carrier and arm angles (n,) of poses with whole turns added, as they follow each other on one closed turn."""
    turn = one_turn(crank, phi)
    first = turn.order[0]
    theta, relative = np.empty(len(crank)), np.empty(len(crank))
    theta[turn.order] = np.mod(crank[first], TURN) + np.append(0, np.cumsum(turn.ahead[:-1]))
    relative[turn.order] = phi[first] - np.mod(crank[first], TURN) - np.append(0, np.cumsum(turn.falls[:-1]))
    return theta, relative + theta


def through_poses(dyad: Dyad, poses: Array) -> AngleCurve | None:
    """The curve through the exact poses and nothing between, monotone or not; None where two share a carrier angle."""
    dx, dy = (model.placed(poses, dyad.point) - dyad.centre[None, :]).T
    theta, phi = on_one_turn(np.arctan2(dy, dx), poses[:, 2])
    if len(poses) < 2 or np.diff(np.sort(theta)).min() < _APART:
        return None
    return closed_turn(theta, phi - theta)


_APART = 1e-6
