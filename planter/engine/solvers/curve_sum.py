"""A sum of measures of curves over a cycle: what its smooth terms and its extremes are of, and
their derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from planter.engine.solvers.objective import ObjectiveSummary, find_tops
from planter.engine.solvers.response import CycleResponse
from planter.kernels import Array, Integers
from planter.numerics.statistics import Statistic, StatisticKind


@dataclass(frozen=True)
class CurveStatistic:
    """A weighted statistic of a curve, the `row` of a response, where the conditions `conditions`
    hold.
    """

    kind: StatisticKind
    row: int
    weight: float
    conditions: tuple[int, ...] = ()


@dataclass(frozen=True)
class CurveSide:
    """A side of a curve that counts in a group: its greatest value (`sign` +1), or its least with
    opposite sign.

    Only the part of the period counts on which the conditions `conditions` hold.
    """

    group: int
    row: int
    sign: int
    conditions: tuple[int, ...] = ()


@dataclass(frozen=True)
class CurveJump:
    """The greatest size of a jump of a curve, which is a group."""

    group: int
    row: int


@dataclass(frozen=True)
class CurveSum:
    """Statistics of curves, and weights (g,) of the groups that the largest of some sides, and of
    jumps, are.
    """

    statistics: tuple[CurveStatistic, ...]
    sides: tuple[CurveSide, ...]
    weights: Array
    jumps: tuple[CurveJump, ...] = ()

    @cached_property
    def groups(self) -> Integers:
        """Group of each side, (s,)."""
        return np.array([side.group for side in self.sides], dtype=np.int64)

    @cached_property
    def rows(self) -> Integers:
        """Curve of each side, (s,)."""
        return np.array([side.row for side in self.sides], dtype=np.int64)

    @cached_property
    def signs(self) -> Array:
        """Sign of each side, (s,)."""
        return np.array([float(side.sign) for side in self.sides])

    def summarise(self, smooth: SmoothSum, tops: Array) -> ObjectiveSummary:
        """Return the summary of largest values of the sides, then of the jumps."""
        groups = np.append(self.groups, [jump.group for jump in self.jumps]).astype(np.int64)
        return ObjectiveSummary(smooth.value, find_tops(tops, groups, len(self.weights)))


class SmoothSum:
    """The statistics of a sum, of values (m, n) of curves with shares (n,) of the cycle, equal ones
    if None.

    `masks` (s, n) are for each statistic the parts of the shares that count.
    """

    def __init__(
        self,
        statistics: Sequence[CurveStatistic],
        values: Array,
        shares: Array | None = None,
        masks: Sequence[Array] | None = None,
    ) -> None:
        self.values, count = values, values.shape[1]
        self.shares = np.full(count, 1 / count) if shares is None else shares
        self.masks = [np.ones(count)] * len(statistics) if masks is None else masks
        self.parts = [
            (part, Statistic(part.kind, values[part.row], self.shares * mask), mask)
            for part, mask in zip(statistics, self.masks, strict=True)
        ]
        self.value = float(sum(part.weight * statistic.value for part, statistic, _ in self.parts))

    @cached_property
    def slope(self) -> Array:
        """Derivative in each value, (m, n)."""
        slope = np.zeros_like(self.values)
        for part, statistic, _ in self.parts:
            slope[part.row] += part.weight * statistic.slope
        return slope

    @cached_property
    def share_slope(self) -> Array:
        """Derivative in each share, (n,)."""
        slope = np.zeros(len(self.shares))
        for part, statistic, mask in self.parts:
            slope += part.weight * mask * statistic.weight_slope
        return slope

    def gradient(self, slopes: Array, share_slopes: Array | None = None) -> Array:
        """Return the gradient (p,) from the gradients (m, n, p) of the values, and (n, p) of shares
        that move.
        """
        gradient = np.einsum("mn,mnp->p", self.slope, slopes)
        return gradient if share_slopes is None else gradient + self.share_slope @ share_slopes

    def squared(self, slopes: Array, share_slopes: Array | None = None) -> Array:
        """Return the part (p, p) of the Hessian due to these; the rest is the sum of their
        Hessians.
        """
        total = np.zeros((slopes.shape[2], slopes.shape[2]))
        for part, statistic, mask in self.parts:
            moving = None if share_slopes is None else mask[:, None] * share_slopes
            total += part.weight * statistic.curvature(slopes[part.row], moving)
        return total


Sampling = int | Literal["refined"]
"""A number of samples of a cycle, or its true extremes and integrals."""
DIRECTION_ANGLES = 360
"""Angles of a cycle at which insensitivity is determined, unless samples are searched over."""


class CurvePart:
    """Base of the parts of an objective that are sums over curves of a response."""

    def __init__(
        self, response: CycleResponse, total: CurveSum, angles: int = DIRECTION_ANGLES
    ) -> None:
        self.response, self.total, self._count = response, total, angles
        self.weights = total.weights

    def restart(self) -> None:
        """Discard the state of the designs evaluated so far."""
        self.response.restart()

    @cached_property
    def units(self) -> Array:
        """Spread (g,) of the curve of each group at the initial design, else its size."""
        rows = {side.group: side.row for side in self.total.sides}
        rows |= {jump.group: jump.row for jump in self.total.jumps}
        return find_spreads(self.response)[[rows[group] for group in range(len(self.weights))]]

    def columns(self, x: Array) -> Array:
        """Return gradients (n, p) of all curves at a design in shares of the bounds, each curve by
        its largest.
        """
        return scale_slopes(self.response, x, self._count)


def scale_slopes(response: CycleResponse, x: Array, samples: int) -> Array:
    """Return the gradients (n, p) of curves at samples of a turn in shares of the bounds, each
    curve by its largest.
    """
    angles = _list_angles(response, samples)
    slopes = response.curves.slopes(response.prologue(x), angles)[1][:, :, 1:]
    size = np.abs(slopes).max(axis=(1, 2), keepdims=True)
    scaled = np.concatenate(slopes / np.where(size > 0, size, 1.0))
    return np.asarray(scaled * (response.upper - response.lower))


def find_spreads(response: CycleResponse) -> Array:
    """Return by how much each curve varies at the initial design, else its size, (m,)."""
    angles = _list_angles(response, DIRECTION_ANGLES)
    values = response.curves.values(response.prologue(response.design), angles)
    spread, size = np.ptp(values, axis=1), np.abs(values).max(axis=1)
    return np.where(spread > 0, spread, np.where(size > 0, size, 1.0))


def _list_angles(response: CycleResponse, count: int) -> Array:
    return np.mod(response.turn * np.arange(count) / count, response.period)
