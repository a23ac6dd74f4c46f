"""Objectives by true extremes and integrals, and their rows near a design.

Rows are the extremes of each curve in windows, both sides of its jumps, and places near its
extremes.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy

from planter.engine.solvers.curve_sum import CurvePart, CurveSide, CurveSum, SmoothSum
from planter.engine.solvers.cycle_panels import CORNER, CyclePanels, PanelCache
from planter.engine.solvers.objective import (
    NO_GROUPS,
    BreakpointHold,
    Conditions,
    LocalModel,
    ObjectiveSummary,
)
from planter.engine.solvers.response import (
    ONE_SIDED_OFFSET,
    PointMotion,
    fixed_motion,
    hessians_along,
    peak_velocity,
)
from planter.engine.solvers.sampled_cycle import SampledRows, sample_angles
from planter.kernels import Array, Flags, Integers
from planter.numerics.arrays import LastCallCache, wrap_angle

MIN_ROW_DISTANCE = 0.02
"""Fixed rows are at least this far apart [rad]."""
NEAR_SHARE, MIN_HIGH_DISTANCE = 0.05, 0.04
"""Nodes within this share of the spread from an extreme are rows, at least so far apart [rad]."""
NO_ANGLES: Array = np.empty(0)


COARSE = 72
"""Samples of a cycle over which a search glides."""


class ContinuousCycle(CurvePart):
    """A sum over curves by their true extremes and integrals. Implements `ObjectivePart`."""

    windows, kinks = True, None

    def __init__(self, find_panels: PanelCache, total: CurveSum) -> None:
        super().__init__(find_panels.response, total)
        self.find_panels = find_panels
        self.panels = LastCallCache(self._prepare)

    def restart(self) -> None:
        """Discard the state of the designs evaluated so far."""
        super().restart()
        self.find_panels.restart()
        self.panels = LastCallCache(self._prepare)

    def _prepare(self, x: Array) -> tuple[CyclePanels, SmoothSum]:
        panels = self.find_panels(x)
        return panels, panels.smooth(self.total.statistics)

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        panels, smooth = self.panels(x)
        return panels.summarise(self.total, smooth)

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> ExtremumRows:
        """Return the local model of the objective near a design x (p,)."""
        return ExtremumRows(self, self.panels(x)[0])

    def coarse(self, x: Array) -> LocalModel | None:
        """Return the local model over few samples, all of them rows; None if parts of the cycle
        count.
        """
        if self.total.jumps:  # which are rows of few places, none of them samples
            return self.local(x)
        conditions = [part.conditions for part in self.total.statistics]
        if any([*conditions, *(side.conditions for side in self.total.sides)]):
            return None
        angles = sample_angles(COARSE, self.response.period, self.response.turn)
        chosen = np.ones((len(self.total.sides), len(angles)), dtype=bool)
        return SampledRows(self.response, self.total, angles, chosen)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        (panels, smooth), total = self.panels(x), self.total
        rows, groups, gradients = [np.empty(0)], [NO_GROUPS], [np.empty((0, len(x)))]
        for side in total.sides:
            extremes = panels.extremes(side)
            extremes = extremes.pick(extremes.peaks == (side.sign > 0))
            count = len(extremes.values)
            rows.append(side.sign * extremes.values)
            groups.append(np.full(count, side.group))
            curve = np.full(count, side.row)
            gradients.append(
                side.sign * panels.row_slopes(curve, extremes.angles, extremes.breakpoint)[1]
            )
        for jump in total.jumps:
            angles, values, breakpoint, _ = _jump_rows(
                panels, CurveSide(jump.group, jump.row, 1), _find_jumps(panels)
            )
            combine = _subtract_sides(len(angles) // 2)
            rows.append(combine @ values)
            groups.append(np.full(len(combine), jump.group))
            curve = np.full(len(angles), jump.row)
            gradients.append(combine @ panels.row_slopes(curve, angles, breakpoint)[1])
        return Conditions(
            np.concatenate(rows),
            np.concatenate(groups),
            np.vstack(gradients),
            panels.gradient(smooth),
            np.empty((0, len(x))),
        )


class ExtremumRows:
    """Rows of each side, one for each window between fixed angles: the greatest value, or the
    least. A `LocalModel`.

    The windows of maxima are parted by the angles of the minima where the rows were made, and
    conversely. All windows together cover the period, so no new extreme can be missed. Two peaks in
    one window give its row a kink where they change places: `fixed` are for each side the angles of
    further rows, smooth ones, which keep both in sight until each has its own window, and those
    near an extreme, among which another would be born. A side of a part of the period has the
    largest of its values in place of those beyond it. Rows are linear in the values at points: a
    jump is the difference of both sides of one.
    """

    def __init__(
        self, cycle: ContinuousCycle, panels: CyclePanels, fixed: Sequence[Array] | None = None
    ) -> None:
        self.cycle, self.total = cycle, cycle.total
        sides = self.total.sides
        self.fixed = (
            tuple(_find_high_nodes(panels, side) for side in sides)
            if fixed is None
            else tuple(fixed)
        )
        self.edges = [_find_edges(panels, side) for side in sides]
        self.jumps = panels.breaks[panels.jumps]
        jumps = 2 * len(self.jumps)
        counts = [
            len(edges) + len(fixed) + jumps
            for edges, fixed in zip(self.edges, self.fixed, strict=True)
        ]
        chosen, angles = np.repeat(np.arange(len(sides)), counts), _find_jumps(panels)
        blocks = [np.diag(self.total.signs[chosen])]
        blocks += [_subtract_sides(len(angles))] * len(self.total.jumps)
        self.combine: Array = scipy.linalg.block_diag(*blocks)
        of_jumps = [(jump.group, jump.row) for jump in self.total.jumps]
        pairs = np.array(of_jumps, dtype=np.int64).reshape(-1, 2).repeat(2 * len(angles), axis=0)
        self.groups = np.append(self.total.groups[chosen], pairs[:, 0])
        self.curves = np.append(self.total.rows[chosen], pairs[:, 1])
        self.jump_angles, self.bounds = angles, np.empty((2, 0))
        self._seen: list[list[float]] = [[] for _ in sides]
        self._state = LastCallCache(lambda x: _ExtremumState(self, x))

    def extended(self, x: Array, tops: Array) -> ExtremumRows:
        """Return a copy with the windows of this design and rows at the extremes of the previous
        designs.
        """
        fixed = [
            drop_close_angles(np.append(angles, seen), MIN_ROW_DISTANCE)
            for angles, seen in zip(self.fixed, self._seen, strict=True)
        ]
        return ExtremumRows(self.cycle, self._state(x).panels, fixed)

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self.cycle.summarise(x)

    def values(self, x: Array) -> Array:
        """Return the smooth value, then the rows, (1 + r,), at a design x (p,)."""
        state = self._state(x)
        return np.append(state.smooth_sum.value, self.combine @ state.values)

    def slopes(self, x: Array) -> Array:
        """Return their gradients (1 + r, p) at a design x (p,)."""
        state = self._state(x)
        for seen, side in zip(self._seen, self.total.sides, strict=True):
            extremes = state.panels.extremes(side)
            if len(extremes.values) and not side.conditions:
                seen.append(float(extremes.angles[(side.sign * extremes.values).argmax()]))
        return np.vstack([state.panels.gradient(state.smooth_sum), self.combine @ state.slopes[1]])

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (1 + r,)."""
        state, smooth = self._state(x), weights[0]
        rows = state.hessian(weights[1:] @ self.combine)
        return rows + smooth * state.panels.hessian(state.smooth_sum) if smooth else rows


class _ExtremumState:
    """All rows at one design: angle, value, breakpoint or -1, and whether it is a smooth peak, which
    moves on its own.
    """

    def __init__(self, rows: ExtremumRows, x: Array) -> None:
        self.panels, self.smooth_sum = rows.cycle.panels(x)
        self.curves = rows.curves
        picked = [_NO_POINTS]
        for side, edges, fixed in zip(rows.total.sides, rows.edges, rows.fixed, strict=True):
            points = [
                _select_window_rows(self.panels, side, edges),
                _fixed_rows(self.panels, side, fixed),
            ]
            if len(rows.jumps):
                points.append(_jump_rows(self.panels, side, rows.jumps))
            picked += points
        for jump in rows.total.jumps:
            side = CurveSide(jump.group, jump.row, 1)
            picked.append(_jump_rows(self.panels, side, rows.jump_angles))
        self.angles, self.values, self.breakpoint, self.smooth = (
            np.concatenate(part) for part in zip(*picked, strict=True)
        )

    @cached_property
    def slopes(self) -> tuple[Array, Array, Array, Array]:
        return self.panels.row_slopes(self.curves, self.angles, self.breakpoint)

    def hessian(self, weights: Array) -> Array:
        """Return the sum (p, p) of the Hessians of the curves at the points, with weights (k,)."""
        size, selected = len(self.panels.response.names), np.flatnonzero(weights)
        if not len(selected):
            return np.zeros((size, size))
        slopes, _, place, _ = self.slopes
        ones = np.zeros((self.panels.response.count, len(selected)))
        ones[self.curves[selected], np.arange(len(selected))] = 1.0
        second = self.panels.response.curves.curvatures(self.panels.at, place[selected], ones)
        total = hessians_along(slopes[selected], second, self._motion(second, selected))
        bent: Array = np.tensordot(weights[selected], total, 1)
        return bent

    def _motion(self, second: Array, selected: Integers) -> PointMotion:
        panels, breakpoint, smooth = self.panels, self.breakpoint[selected], self.smooth[selected]
        motion = fixed_motion(len(breakpoint), second.shape[1] - 1)
        motion.velocity[:] = self.slopes[3][selected]
        motion.velocity[smooth] = peak_velocity(second[smooth])
        at_breakpoint = breakpoint >= 0
        if at_breakpoint.any():
            motion.acceleration[at_breakpoint] = panels.breakpoints.acceleration(
                breakpoint[at_breakpoint]
            )
        corner = np.flatnonzero(breakpoint == CORNER)
        if len(corner):
            motion.acceleration[corner] = self._bend_corners(selected[corner], second[corner])
        return motion

    def _bend_corners(self, chosen: Integers, after: Array) -> Array:
        """Return the second derivatives (k, p, p) of corners, at which two branches of a curve have
        one value.
        """
        panels, angles = self.panels, self.angles[chosen] - ONE_SIDED_OFFSET
        lanes, curves = np.arange(len(chosen)), self.curves[chosen]
        ones = np.zeros((panels.response.count, len(chosen)))
        ones[curves, lanes] = 1.0
        change = after - panels.response.curves.curvatures(panels.at, panels.fold(angles), ones)
        before = panels.response.curves.slopes(panels.at, panels.fold(angles))[1][curves, lanes, 0]
        rise = self.slopes[0][chosen, 0] - before
        size = change.shape[1] - 1
        path = np.concatenate(
            [self.slopes[3][chosen][:, None], np.tile(np.eye(size), (len(chosen), 1, 1))], axis=1
        )
        bent: Array = -np.einsum("kap,kab,kbq->kpq", path, change, path) / rise[:, None, None]
        return bent


_Points = tuple[Array, Array, Integers, Flags]
"""Points of rows: angles, values, breakpoints or -1, whether they are smooth peaks."""
_NO_POINTS: _Points = np.empty(0), np.empty(0), np.empty(0, dtype=np.int64), np.empty(0, dtype=bool)


def _find_high_nodes(panels: CyclePanels, side: CurveSide) -> Array:
    """Return angles at which a curve is near its extreme: a peak that is not yet there would be
    born among them.
    """
    if side.conditions:
        return NO_ANGLES
    values = side.sign * panels.values[side.row]
    high = panels.nodes[values >= values.max() - NEAR_SHARE * np.ptp(values)]
    if len(panels.jumps):  # a jump that passes a fixed angle would be one of its row
        gaps = wrap_angle(high[:, None] - panels.breaks[panels.jumps], panels.response.period)
        high = high[np.abs(gaps).min(axis=1) > MIN_HIGH_DISTANCE]
    return drop_close_angles(panels.fold(high), MIN_HIGH_DISTANCE)


EDGE_SHARES = np.array([0.25, 0.5, 0.75])
"""Where an end of a window may be between two peaks that only a jump parts."""


def _find_edges(panels: CyclePanels, side: CurveSide) -> Array:
    """Return the ends of the windows of a side: the extremes of the other, or the first angle
    without any.

    A jump is no end, since it moves: between two peaks that it parts the end is a place far from
    jumps.
    """
    extremes, period = panels.extremes(side), panels.response.period
    is_peak = extremes.peaks == (side.sign > 0)
    edges = extremes.angles[~is_peak & ~extremes.beside_jump]
    peaks = extremes.angles[is_peak & ~extremes.beside_jump]
    if len(panels.jumps) and len(peaks) > 1:
        lengths = np.diff(peaks, append=peaks[0] + period)
        between = np.mod(edges - peaks[:, None], period) < lengths[:, None]
        bare = np.flatnonzero(~between.any(axis=1))
        places = peaks[bare, None] + EDGE_SHARES * lengths[bare, None]
        gaps = np.abs(wrap_angle(places[..., None] - panels.breaks[panels.jumps], period)).min(
            axis=-1
        )
        chosen = places[np.arange(len(bare)), gaps.argmax(axis=1)]
        edges = np.sort(np.append(edges, np.mod(chosen, period)))
    return edges if len(edges) else np.zeros(1)


def _select_window_rows(panels: CyclePanels, side: CurveSide, edges: Array) -> _Points:
    """The row of each window up to an edge: its extreme, or the edge if that is more.

    A window without an extreme inside has it at an edge: the right one here, the left one in the
    window before.
    """
    extremes = panels.extremes(side)
    inside = np.flatnonzero((extremes.peaks == (side.sign > 0)) & ~extremes.beside_jump)
    window = np.searchsorted(edges, extremes.angles[inside]) % max(len(edges), 1)
    angles, values, breakpoint, smooth = (
        _top_rows(panels, side, len(edges)) if side.conditions else _fixed_rows(panels, side, edges)
    )
    taken = np.zeros(len(edges), dtype=bool)
    for i, w in zip(inside, window, strict=True):
        is_first = bool(side.conditions) and not taken[w]
        if is_first or side.sign * extremes.values[i] > side.sign * values[w]:
            angles[w], values[w], breakpoint[w] = (
                extremes.angles[i],
                extremes.values[i],
                extremes.breakpoint[i],
            )
            smooth[w], taken[w] = extremes.smooth[i], True
    return angles, values, breakpoint, smooth


def _top_rows(panels: CyclePanels, side: CurveSide, count: int) -> _Points:
    """Rows that are all the largest value of a side."""
    extremes = panels.extremes(side)
    best = int(
        np.where(extremes.peaks == (side.sign > 0), side.sign * extremes.values, -np.inf).argmax()
    )
    chosen = np.full(count, best)
    return (
        extremes.angles[chosen],
        extremes.values[chosen],
        extremes.breakpoint[chosen],
        extremes.smooth[chosen],
    )


def _find_jumps(panels: CyclePanels) -> Array:
    """Return the angles (k,) at which curves may jump, one that does not matter without any."""
    return panels.breaks[panels.jumps] if len(panels.jumps) else np.zeros(1)


def _subtract_sides(count: int) -> Array:
    """Return the matrix (2 count, 2 count) from values before and after jumps to these, of either
    sign.
    """
    eye = np.eye(count)
    return np.block([[-eye, eye], [eye, -eye]])


def _jump_rows(panels: CyclePanels, side: CurveSide, angles: Array) -> _Points:
    """Rows on both sides of the jumps that are nearest to angles (k,); where there are none, at
    these angles.
    """
    if not len(panels.jumps):
        return (
            _top_rows(panels, side, 2 * len(angles))
            if side.conditions
            else _fixed_rows(panels, side, np.tile(angles, 2))
        )
    gaps = np.abs(wrap_angle(panels.breaks[panels.jumps] - angles[:, None], panels.response.period))
    nearest = gaps.argmin(axis=1)
    places = panels.breaks[panels.jumps][nearest]
    places = panels.fold(np.concatenate([places - ONE_SIDED_OFFSET, places + ONE_SIDED_OFFSET]))
    values = panels.sides[side.row].reshape(2, -1)[:, nearest].ravel()
    breakpoints = np.tile(panels.order[panels.jumps][nearest], 2)
    points = places, values, breakpoints, np.zeros(len(places), dtype=bool)
    if not side.conditions:
        return points
    count = len(panels.breaks) - 1
    probes = np.concatenate([(panels.jumps[nearest] - 1) % count, panels.jumps[nearest]])
    outside = ~panels.inside(side.conditions)[probes]
    for part, top in zip(points, _top_rows(panels, side, len(places)), strict=True):
        part[outside] = top[outside]
    return points


def _fixed_rows(panels: CyclePanels, side: CurveSide, angles: Array) -> _Points:
    """Rows at fixed angles."""
    count = len(angles)
    values = panels.response.curves.values(panels.at, angles)[side.row] if count else np.empty(0)
    return angles.copy(), values, np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=bool)


def drop_close_angles(angles: Array, distance: float) -> Array:
    """The angles in order, less those closer than `distance` to the one before [rad]."""
    separated: list[float] = []
    for angle in np.sort(angles):
        if not separated or angle - separated[-1] > distance:
            separated.append(float(angle))
    return np.array(separated)
