"""The angle curve: rotation of the arm relative to the carrier over one turn of it, a periodic C2 cubic."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.numerics.extrema import index_first_extremum

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


@dataclass(frozen=True)
class SlopeExtreme:
    """An extreme of the slope [-] and its carrier angle [rad]."""

    value: float
    angle: float


@dataclass(frozen=True)
class AngleCurve:
    """Points (n,) [rad] of a turn, the last one a turn of the carrier after the first.

    `sense` is -1 where the arm falls behind by a turn, as two external meshes have it, +1 where it gains one.
    Slopes are d(relative rotation)/d(carrier angle), taken positive along `sense`.
    """

    carrier: Array
    relative: Array
    sense: int = -1

    @cached_property
    def _periodic(self) -> CubicSpline:
        """The rotation less that of a uniform turn."""
        from scipy.interpolate import CubicSpline

        rest = self.relative - self.sense * self.carrier
        return CubicSpline(self.carrier, np.append(rest[:-1], rest[0]), bc_type="periodic")

    def at(self, theta: Array) -> Array:
        """Relative rotation [rad] at any carrier angles [rad]."""
        return self._periodic(theta) + self.sense * np.asarray(theta)

    def slopes(self, theta: Array) -> Array:
        """Slope and its first two derivatives (3, n); at a point of the curve, the last is that to the right."""
        uniform = np.array([[1.0], [0.0], [0.0]])
        orders = (self.sense * self._periodic(np.atleast_1d(theta), order) for order in (1, 2, 3))
        return np.array(list(orders)) + uniform

    @cached_property
    def extremes(self) -> tuple[SlopeExtreme, SlopeExtreme]:
        """Least and largest slope, the first of equal ones: parabolas have them at the points or at a vertex."""
        starts, widths = self.carrier[:-1], np.diff(self.carrier)
        slope, first, second = self.slopes(starts)
        inside = np.clip(np.divide(-first, second, out=np.zeros_like(first), where=second != 0), 0, widths)
        angles = np.concatenate([starts, starts + inside])
        values = np.concatenate([slope, slope + first * inside + second * inside**2 / 2])
        low, high = (index_first_extremum(angles, values, sign) for sign in (-1, 1))
        return (
            SlopeExtreme(float(values[low]), float(angles[low])),
            SlopeExtreme(float(values[high]), float(angles[high])),
        )

    @property
    def monotone(self) -> bool:
        return self.extremes[0].value > 0

    def find_zero_slope(self) -> float:
        """The first carrier angle [rad] at which the slope is not positive."""
        theta = np.unique(np.concatenate([np.linspace(self.carrier[0], self.carrier[-1], 7201), self.carrier]))
        slope = self.slopes(theta)[0]
        stopped = np.flatnonzero(slope <= 0)
        return float(theta[stopped[0]]) if len(stopped) else self.extremes[0].angle


def unwrap_rotations(relative: Array, sense: int = -1) -> Array:
    """Relative rotations [rad] with whole turns added so that each lies less than a turn on from the one before."""
    angles = [float(relative[0])]
    for value in relative[1:]:
        angles.append(angles[-1] + sense * float(np.mod(sense * (value - angles[-1]), TURN)))
    return np.array(angles)


def closed_turn(carrier: Array, relative: Array, sense: int = -1) -> AngleCurve:
    """The curve through points (n,) within a turn of the carrier, ordered by its angle, and the first one again."""
    order = np.argsort(carrier)
    theta, y = carrier[order], relative[order]
    return AngleCurve(np.append(theta, theta[0] + TURN), np.append(y, y[0] + sense * TURN), sense)
