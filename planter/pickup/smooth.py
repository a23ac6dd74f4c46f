"""A law whose slope goes to zero smoothly where the dwell begins and ends, so that the tip's velocity does not jump."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.pickup.law import Dwell, toothed_range

_ROUNDING = 1e-9
"""Angles this close to a joint are on the teeth [rad]."""


@dataclass(frozen=True)
class SmoothLaw:
    """Slope c (1 + p cos t), but within `transition` [rad] of the dwell a cubic that meets it, and zero, smoothly.

    c lets the arm gain one turn in a turn of the carrier. In the transitions other means than teeth must drive the
    arm: towards a slope of zero the sun's pitch radius goes to zero.
    """

    p: float
    dwell: Dwell
    transition: float
    phi1_far: float = np.pi

    def arm(self, t: Array) -> Array:
        turned = np.asarray(t, dtype=float)
        within = self._within(turned)
        start = self._grown(np.zeros(1))[0]
        return np.asarray(self.phi1_far + self.mean_on_teeth * (self._grown(within) - start) + turned - within)

    def slopes(self, t: Array) -> Array:
        within = self._within(np.asarray(t, dtype=float))
        first, last = toothed_range(self.dwell)
        within = np.where(within > last + self.dwell.width / 2, first, np.minimum(within, last))
        swing = [1 + self.p * np.cos(within), -self.p * np.sin(within), -self.p * np.cos(within)]
        after, before = within - first, last - within
        for order in range(3):
            swing[order] = np.where(after < self.transition - _ROUNDING, self._after.deriv(order)(after), swing[order])
            mirrored = (-1) ** order * self._before.deriv(order)(before)
            swing[order] = np.where(before < self.transition - _ROUNDING, mirrored, swing[order])
        return self.mean_on_teeth * np.array(swing)

    def joints(self) -> Array:
        first, last = toothed_range(self.dwell)
        return np.array([first, first + self.transition, last - self.transition, last])

    @cached_property
    def mean_on_teeth(self) -> float:
        """c [-]."""
        return float(TURN / self._grown(np.array([toothed_range(self.dwell)[1]]))[0])

    @property
    def rises(self) -> bool:
        """Whether the slope is positive throughout both transitions."""
        own = [part(self.transition) for part in (self._after, self._before)]
        return bool(min(own) > 0 and min(part.coef[2] for part in (self._after, self._before)) >= 0)

    def _within(self, t: Array) -> Array:
        first, _ = toothed_range(self.dwell)
        return np.asarray(first + (t - first) % TURN)

    @cached_property
    def _after(self) -> Polynomial:
        """The slope over c in powers of the distance from the dwell's end."""
        return self._cubic(self.dwell.end + self.transition, 1)

    @cached_property
    def _before(self) -> Polynomial:
        """The slope over c in powers of the distance back from the dwell's start."""
        return self._cubic(self.dwell.start - self.transition, -1)

    def _cubic(self, joint: float, sense: int) -> Polynomial:
        h, value, rate = self.transition, 1 + self.p * np.cos(joint), -sense * self.p * np.sin(joint)
        return Polynomial([0, 0, (3 * value - rate * h) / h**2, (rate * h - 2 * value) / h**3])

    def _grown(self, within: Array) -> Array:
        """Integral of the slope over c from the dwell's end on, up to angles (n,) of the turn after it."""
        first, last = toothed_range(self.dwell)
        h, after, before = self.transition, self._after.integ(), self._before.integ()

        def plain(t: Any) -> Any:
            return t + self.p * np.sin(t)

        middle = np.clip(within, first + h, last - h)
        rest = before(h) - before(np.clip(last - within, 0, h))
        return np.asarray(after(np.clip(within - first, 0, h)) + plain(middle) - plain(first + h) + rest)
