"""The turn without a grid: true extremes of the curves over phi, true integrals for their means and
variances.

The period is split at all breakpoints into panels on which F is smooth, and the panels into pieces with
Gauss-Legendre nodes. Every change of sign of dF/dphi is one extreme: a smooth peak inside a panel,
or the breakpoint itself where F has a kink, or a side of it where F jumps.

Nodes keep their places within a panel, whose ends move with the design: phi_k = (1 - t_k) a + t_k
b, with the weight w_k (b - a). So the derivatives of an integral are those of its sum, first and
second ones alike, whether F is smooth at a breakpoint, has a kink, jumps, or has an infinite slope as a
root has: along a moving node all of these are smooth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.solvers.curve_sum import CurveSide, CurveStatistic, CurveSum, SmoothSum
from planter.engine.solvers.objective import ObjectiveSummary
from planter.engine.solvers.response import (
    ONE_SIDED_OFFSET,
    CycleResponse,
    find_breakpoints,
    gradients_along,
)
from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers
from planter.numerics.arrays import LastCallCache
from planter.numerics.extrema import find_stationary_points
from planter.numerics.piecewise import PiecewiseFunctions

MIN_BREAKPOINT_DISTANCE = 1e-8
"""Joints closer than this are one [rad]."""
CORNER, CORNER_SHARE = -2, 1e-6
"""In place of a breakpoint: a corner that no event marks, at which a slope jumps by this share of the
largest at least.
"""
LEVEL_SHARE = 1e-9
"""A curve whose slope is below this share of its size is level, its slope rounding [1/rad]."""
MAX_PANEL = np.pi / 8
"""Greatest mean length of the panels of Gauss's nodes [rad]."""
FIXED_RANK = 10
"""Added to the order of breakpoints whose motion is not known, so that others at the same angle
count.
"""
PULL_ROUNDING = 1e-13
"""Share of what nodes add to the pull on a breakpoint below which the pull is rounding: no curve jumps
there.
"""


@dataclass(frozen=True)
class CycleExtrema:
    """Local extremes in order of angle: `angles` (m,) in one period, `peaks` (m,) True for maxima,
    `values` (m,).

    `breakpoint` (m,) is the index among the breakpoints of one that is a kink or a jump, `CORNER` or else -1;
    `smooth` (m,) marks those that move on their own: the ends of a curve that is not closed do not.
    `panels` (2, m) are the panels before and after.
    """

    angles: Array
    peaks: Flags
    values: Array
    breakpoint: Integers
    smooth: Flags
    beside_jump: Flags
    panels: Integers

    def pick(self, chosen: Flags | Integers) -> CycleExtrema:
        """Return the extremes that flags (m,) mark, or those at indices, in this order."""
        return CycleExtrema(
            self.angles[chosen],
            self.peaks[chosen],
            self.values[chosen],
            self.breakpoint[chosen],
            self.smooth[chosen],
            self.beside_jump[chosen],
            self.panels[:, chosen],
        )


class CyclePanels:
    """The curves over one period at a design, split at their breakpoints."""

    def __init__(self, response: CycleResponse, x: Array) -> None:
        self.response, self.at = response, response.prologue(x)
        self.breakpoints = find_breakpoints(response, self.at)
        self.folded = self.breakpoints.folded
        self.breaks, self.order = self._breaks()
        self._place_nodes()
        self.jumps = np.flatnonzero(self._is_jump())
        before = (
            self.end_values[:, self.jumps - 1, 1]
            + ONE_SIDED_OFFSET * self.end_rates[:, self.jumps - 1, 1]
        )
        after = (
            self.end_values[:, self.jumps, 0] - ONE_SIDED_OFFSET * self.end_rates[:, self.jumps, 0]
        )
        self.sides = np.hstack([before, after])

    def fold(self, angles: Array) -> Array:
        """Return angles modulo the period of closed curves [rad]."""
        return np.mod(angles, self.response.period) if self.response.is_closed else angles

    def _is_jump(self) -> Flags:
        """Return which panels begin at a breakpoint where the curves themselves may jump."""
        at_breakpoint = self.order >= 0
        flags = np.zeros(len(self.order), dtype=bool)
        flags[at_breakpoint] = self.breakpoints.orders[self.order[at_breakpoint]] == 0
        return flags

    def _breaks(self) -> tuple[Array, Integers]:
        """Ends of the panels over one period, and the breakpoint at each panel's start, -1 for none.

        First and last are the same breakpoint; without breakpoints, or if the curves are not closed, the ends
        of the period. Of breakpoints that are one, the roughest counts.
        """
        order, period = np.argsort(self.folded, kind="stable"), self.response.period
        places = self.folded[order]
        if not self.response.is_closed:
            inside = (places > MIN_BREAKPOINT_DISTANCE) & (
                places < period - MIN_BREAKPOINT_DISTANCE
            )
            outer = order[~inside]
            first = (
                self._select_roughest(outer, np.zeros(1, dtype=np.int64))[:1]
                if len(outer)
                else np.array([-1])
            )
            order, places = order[inside], places[inside]
            starts = np.flatnonzero(np.diff(places, prepend=-1.0) > MIN_BREAKPOINT_DISTANCE)
            breakpoints = self._select_roughest(order, starts)
            return np.concatenate([[0.0], self.folded[breakpoints], [period]]), np.append(
                first, breakpoints
            )
        if not len(order):
            return np.array([0.0, period]), np.array([-1])
        separated = np.diff(places, append=places[0] + period) > MIN_BREAKPOINT_DISTANCE
        starts = np.flatnonzero(np.roll(separated, 1))
        breakpoints = self._select_roughest(np.roll(order, -starts[0]), starts - starts[0])
        breakpoints = breakpoints[np.argsort(self.folded[breakpoints], kind="stable")]
        return np.append(
            self.folded[breakpoints], self.folded[breakpoints[0]] + period
        ), breakpoints

    def _select_roughest(self, order: Integers, starts: Integers) -> Integers:
        """Return of each group of breakpoints, which begin at `starts` of `order`, that of the least
        order that moves.
        """
        groups = np.split(order, starts[1:]) if len(starts) else []
        rank = self.breakpoints.orders + FIXED_RANK * ~self.breakpoints.is_regular
        return np.array([group[rank[group].argmin()] for group in groups], dtype=np.int64)

    def _place_nodes(self) -> None:
        """Set nodes (n,) in order, their places and weights in their panels, shares of sum 1,
        values and slopes; and values and slopes (m, panels, 2) beside the ends of panels.

        Raises ComputationError where a curve is not finite.
        """
        period = self.response.period
        self._pieces = pieces = PiecewiseFunctions(
            lambda phi: self.response.curves.derivatives(self.at, self.fold(phi), is_loose=True),
            self.breaks[1:-1],
            period,
            self.breaks[0],
            int(np.ceil(period / MAX_PANEL)),
        )
        if pieces.poles:  # of which the response says what they are
            angles = self.fold(np.array(list(pieces.poles.values())))
            self.response.curves.derivatives(self.at, angles)
            raise ComputationError(f"a curve has a pole at {np.degrees(angles[0]):.6g} deg")
        inner, ends = np.flatnonzero(pieces.weights > 0), np.flatnonzero(pieces.weights == 0)
        self.nodes, self.panel = pieces.nodes[inner], pieces.owner[inner]
        self.shares = pieces.weights[inner]
        lengths = np.diff(self.breaks)[self.panel]
        self.mix = (self.nodes - self.breaks[self.panel]) / lengths
        self._weights = self.shares * period / lengths
        self.values, self.node_rates = pieces.values[:, inner], pieces.slopes[:, inner]
        self.end_values, self.end_rates = (
            part[:, ends].reshape(len(part), -1, 2) for part in (pieces.values, pieces.slopes)
        )

    # --- parts of the period
    # -------------------------------------------------------------------------

    @cached_property
    def _holding(self) -> Flags:
        """Whether each condition holds on each panel, (c, panels)."""
        flags: Flags = (
            self.response.misses(self.at, self.fold((self.breaks[:-1] + self.breaks[1:]) / 2)) <= 0
        )
        return flags

    def inside(self, conditions: tuple[int, ...]) -> Flags:
        """Return on which panels conditions hold, (panels,)."""
        return np.asarray(self._holding[list(conditions)].all(axis=0))

    def is_empty(self, conditions: tuple[int, ...]) -> bool:
        """Return whether conditions never hold all."""
        return not self.inside(conditions).any()

    def _nearest(self, conditions: tuple[int, ...]) -> int:
        """Return the node at which conditions that never hold are missed least."""
        return int(
            self.response.misses(self.at, self.fold(self.nodes))[list(conditions)]
            .max(axis=0)
            .argmin()
        )

    def mask(self, statistic: CurveStatistic) -> Array:
        """Return which nodes count in a statistic, (n,); where none would, the nearest does, but in
        no integral.
        """
        if not self.is_empty(statistic.conditions):
            return self.inside(statistic.conditions)[self.panel].astype(float)
        mask = np.zeros(len(self.nodes))
        mask[self._nearest(statistic.conditions)] = float(statistic.kind != "integral")
        return mask

    # --- integrals
    # -----------------------------------------------------------------------------------

    def smooth(self, statistics: Sequence[CurveStatistic]) -> SmoothSum:
        """Return the sum of statistics."""
        return SmoothSum(
            statistics, self.values, self.shares, [self.mask(statistic) for statistic in statistics]
        )

    @cached_property
    def _velocity(self) -> Array:
        """Derivatives of the breaks in the design, (panels + 1, p)."""
        velocity = np.zeros((len(self.breaks), len(self.response.names)))
        moving = np.flatnonzero(self.order >= 0)
        velocity[moving] = self.breakpoints.velocity[self.order[moving]]
        velocity[-1] = velocity[0]
        return velocity

    @cached_property
    def _node_velocity(self) -> Array:
        before, after = self._velocity[self.panel], self._velocity[self.panel + 1]
        return before + self.mix[:, None] * (after - before)

    @cached_property
    def _node_slopes(self) -> Array:
        """Gradients of the curves along the nodes, (m, n, p)."""
        slopes = self.response.curves.slopes(self.at, self.fold(self.nodes))[1]
        return gradients_along(slopes, self._node_velocity)

    @cached_property
    def _share_slopes(self) -> Array:
        growth = np.diff(self._velocity, axis=0) / self.response.period
        slopes: Array = self._weights[:, None] * growth[self.panel]
        return slopes

    def gradient(self, smooth: SmoothSum) -> Array:
        """Return the gradient (p,) of a sum of statistics."""
        if not smooth.parts:
            return np.zeros(len(self.response.names))
        return smooth.gradient(self._node_slopes, self._share_slopes)

    def hessian(self, smooth: SmoothSum) -> Array:
        """Return the Hessian (p, p) of a sum of statistics."""
        size = len(self.response.names)
        if not smooth.parts:
            return np.zeros((size, size))
        angles = self.fold(self.nodes)
        bent = self.response.curves.curvature_along(
            self.at, angles, smooth.slope, self._node_velocity
        )
        return (
            bent
            + smooth.squared(self._node_slopes, self._share_slopes)
            + self._bend_breakpoints(smooth)
        )

    def _bend_breakpoints(self, smooth: SmoothSum) -> Array:
        """Return the part of a Hessian (p, p) due to the second derivatives of the breakpoints.

        What a breakpoint moves is the sum of its nodes and of their weights. It vanishes where no curve
        jumps.
        """
        count, size = len(self.breaks), len(self.response.names)
        pull = (smooth.slope * self.node_rates).sum(axis=0)
        gain = smooth.share_slope * self._weights / self.response.period
        parts = [
            (self.panel, (1 - self.mix) * pull - gain),
            (self.panel + 1, self.mix * pull + gain),
        ]
        pulls, sizes = np.zeros(count), np.zeros(count)
        for panel, part in parts:
            pulls += np.bincount(panel, part, count)
            sizes += np.bincount(panel, np.abs(part), count)
        for total in (pulls, sizes):
            total[0] += total[-1]
        moving = np.flatnonzero(
            (self.order >= 0) & (np.abs(pulls[:-1]) > PULL_ROUNDING * sizes[:-1])
        )
        if not len(moving):
            return np.zeros((size, size))
        bent: Array = np.tensordot(
            pulls[moving], self.breakpoints.acceleration(self.order[moving]), 1
        )
        return bent

    # --- extremes
    # ------------------------------------------------------------------------------------

    @cached_property
    def _extremes(self) -> dict[int, CycleExtrema]:
        return {}

    def extremes(self, side: CurveSide) -> CycleExtrema:
        """Return the local extremes of the curve of a side, in the part of the period that
        counts.
        """
        row = side.row
        if row not in self._extremes:
            self._extremes[row] = self._find_extremes(row)
        extremes = self._extremes[row]
        if not side.conditions:
            return extremes
        inside = self.inside(side.conditions)
        if not inside.any():
            return self._stand_in(side, self._nearest(side.conditions))
        before, after = extremes.panels
        extremes = extremes.pick(inside[before] | inside[after])
        if not (extremes.peaks == (side.sign > 0)).any():
            values = np.where(inside[self.panel], side.sign * self.values[side.row], -np.inf)
            return self._stand_in(side, int(values.argmax()))
        return extremes

    def _stand_in(self, side: CurveSide, node: int) -> CycleExtrema:
        """Return a node as the only extreme, a peak and a valley: where a curve is level, or
        conditions never hold.
        """
        twice = np.full(2, node)
        no = np.zeros(2, dtype=bool)
        return CycleExtrema(
            self.fold(self.nodes[twice]),
            np.array([True, False]),
            self.values[side.row, twice],
            np.full(2, -1),
            no,
            no,
            np.tile(self.panel[twice], (2, 1)),
        )

    def top(self, side: CurveSide) -> float:
        """Return the largest value of a side."""
        extremes = self.extremes(side)
        chosen = extremes.peaks == (side.sign > 0)
        if chosen.any():
            return float((side.sign * extremes.values[chosen]).max())
        return float((side.sign * self.values[side.row]).max())

    def _find_extremes(self, row: int) -> CycleExtrema:
        def slope(phi: Array) -> tuple[Array, Array]:
            first, second = self.response.curves.rates(self.at, self.fold(phi))
            return first[row], second[row]

        pieces = self._pieces
        angles, peaks = find_stationary_points(
            slope, pieces.nodes, pieces.slopes[row], pieces.is_joined
        )
        before, after = np.roll(self.end_rates[row, :, 1], 1), self.end_rates[row, :, 0]
        changes = (before > 0) != (after > 0)
        changes[self.jumps] = False
        count = len(self.breaks) - 1
        if self.response.is_closed:
            kinks, ends, falls = np.flatnonzero(changes), np.empty(0), np.empty(0, dtype=bool)
        else:
            kinks = 1 + np.flatnonzero(changes[1:])
            ends, falls = (
                np.array([0.0, self.response.period]),
                np.array([after[0] < 0, before[0] > 0]),
            )
        inner = np.clip(np.searchsorted(self.breaks, angles, "right") - 1, 0, count - 1)
        outer = np.array([0, count - 1])[: len(ends)]
        place = np.concatenate([self.fold(np.concatenate([angles, self.breaks[kinks]])), ends])
        kind = np.concatenate([peaks, before[kinks] > 0, falls])
        breakpoint = np.concatenate(
            [np.full(len(angles), -1), self.order[kinks], np.full(len(ends), -1)]
        )
        panels = np.array(
            [[*inner, *((kinks - 1) % count), *outer], [*inner, *kinks, *outer]], dtype=np.int64
        )
        is_corner = self._find_corners(row, angles)
        breakpoint[: len(angles)][is_corner] = CORNER
        smooth = np.arange(len(place)) < len(angles)
        smooth[: len(angles)] = ~is_corner
        values = self._evaluate_extremes(row, place, kinks, len(angles))
        if len(self.jumps):
            probes, left = self.breaks[self.jumps], (self.jumps - 1) % count
            place = np.concatenate(
                [place, self.fold(probes - ONE_SIDED_OFFSET), self.fold(probes + ONE_SIDED_OFFSET)]
            )
            kind = np.concatenate([kind, before[self.jumps] > 0, after[self.jumps] < 0])
            breakpoint = np.concatenate([breakpoint, *[self.order[self.jumps]] * 2])
            panels = np.hstack([panels, np.tile(np.concatenate([left, self.jumps]), (2, 1))])
            values = np.append(values, self.sides[row])
        beside_jump = np.arange(len(place)) >= len(smooth)
        smooth = np.append(smooth, np.zeros(len(place) - len(smooth), dtype=bool))
        order = np.argsort(place, kind="stable")
        return CycleExtrema(place, kind, values, breakpoint, smooth, beside_jump, panels).pick(
            order
        )

    def _evaluate_extremes(self, row: int, places: Array, kinks: Integers, count: int) -> Array:
        """Return values at `count` smooth extremes, at kinks and at ends; at a kink that is not
        finite, beside it.
        """
        if not len(places):
            return np.empty(0)
        values: Array = self.response.curves.derivatives(self.at, places, is_loose=True)[0][
            row
        ].copy()
        at_kinks = slice(count, count + len(kinks))
        values[at_kinks] = np.where(
            np.isfinite(values[at_kinks]), values[at_kinks], self.end_values[row, kinks, 0]
        )
        return values

    def _find_corners(self, row: int, angles: Array) -> Flags:
        """Return which stationary angles are corners that no event marks, as of the nearest place
        of a polyline.
        """
        if not len(angles):
            return np.zeros(0, dtype=bool)
        probes = np.concatenate([angles - ONE_SIDED_OFFSET, angles + ONE_SIDED_OFFSET])
        before, after = np.split(
            self.response.curves.derivatives(self.at, self.fold(probes))[1][row], 2
        )
        steepest, largest = np.abs(self.node_rates[row]).max(), np.abs(self.values[row]).max()
        flags: Flags = np.abs(after - before) > max(CORNER_SHARE * steepest, LEVEL_SHARE * largest)
        return flags

    def summarise(self, total: CurveSum, smooth: SmoothSum) -> ObjectiveSummary:
        """Return the summary of a sum."""
        tops = [self.top(side) for side in total.sides]
        for jump in total.jumps:
            before, after = np.split(self.sides[jump.row], 2)
            tops.append(float(np.abs(after - before).max(initial=0.0)))
        return total.summarise(smooth, np.array(tops))

    def row_slopes(
        self, rows: Integers, angles: Array, breakpoint: Integers
    ) -> tuple[Array, Array, Array, Array]:
        """Return Jacobians (k, 1 + p) of curves in (phi, x), gradients along the points, where and
        how these move.

        A corner is where two branches have one value: both have the same gradient along its motion.
        """
        at_breakpoint, size = breakpoint >= 0, len(self.response.names)
        if not len(angles):
            return np.empty((0, 1 + size)), np.empty((0, size)), angles, np.empty((0, size))
        velocity = np.zeros((len(angles), size))
        velocity[at_breakpoint] = self.breakpoints.velocity[breakpoint[at_breakpoint]]
        place = angles.copy()
        corner = breakpoint == CORNER
        if corner.any():
            probes = np.concatenate(
                [angles[corner] - ONE_SIDED_OFFSET, angles[corner] + ONE_SIDED_OFFSET]
            )
            both = self.response.curves.slopes(self.at, self.fold(probes))[1]
            before, after = np.split(both[np.tile(rows[corner], 2), np.arange(len(probes))], 2)
            change = after - before
            velocity[corner] = -change[:, 1:] / change[:, :1]
            place[corner] += ONE_SIDED_OFFSET
        at_breakpoint[at_breakpoint] = (
            np.abs(angles[at_breakpoint] - self.folded[breakpoint[at_breakpoint]])
            < ONE_SIDED_OFFSET / 2
        )
        place[at_breakpoint] += ONE_SIDED_OFFSET
        slopes = self.response.curves.slopes(self.at, place)[1][rows, np.arange(len(place))]
        return slopes, gradients_along(slopes, velocity), place, velocity


class PanelCache:
    """The panels of a response at the latest design x (p,), which several sums may share."""

    def __init__(self, response: CycleResponse) -> None:
        self.response = response
        self.restart()

    def __call__(self, x: Array) -> CyclePanels:
        """Return the panels at a design x (p,)."""
        return self._latest(x)

    def restart(self) -> None:
        """Forget the latest design."""
        self._latest = LastCallCache(lambda x: CyclePanels(self.response, x))
