"""A sum of measures of curves over a cycle: what its smooth terms and its extremes are of, and
their derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.solvers.objective import ObjectiveSummary, find_tops
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
