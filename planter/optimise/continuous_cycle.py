"""The turn without a grid: true extremes of the curve over phi, true integrals for its mean and variance.

The period is split at all joints into panels on which F is smooth, and the panels into pieces with Gauss-Legendre
nodes. Every change of sign of dF/dphi is one extreme: a smooth peak inside a panel, or the joint itself where F has a
kink.

First derivatives of the integrals are integrals of F_x, since F is continuous; the second have a term for each joint,

    d2/dx2 int F dphi = int F_xx dphi + sum_k (F_phi after - F_phi before) psi_k,x' psi_k,x,

and twice F times that for the integral of F squared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.kernels import Array
from planter.numerics import piecewise
from planter.numerics.arrays import Flags, Integers, LastCallCache
from planter.numerics.extrema import find_stationary_points
from planter.optimise.objective import Conditions, ModelGradients, ModelValues, ObjectiveSummary
from planter.optimise.response import (
    ONE_SIDED_OFFSET,
    CycleResponse,
    PointMotion,
    find_breakpoints,
    fixed_motion,
    gradients_along,
    hessians_along,
    peak_velocity,
)
from planter.optimise.variance import Variance

NODES = 12
MAX_PIECE = np.pi / 8
"""Nodes in a piece, and the greatest length of a piece [rad]."""
MIN_ROW_DISTANCE = 0.02
"""Fixed rows are at least this far apart [rad]."""
NO_ANGLES: Array = np.empty(0)
MIN_BREAKPOINT_DISTANCE = 1e-8
"""Joints closer than this are one [rad]."""


@dataclass(frozen=True)
class CycleExtrema:
    """Local extremes in order of angle: `angles` (m,) in one period, `peaks` (m,) True for maxima, `values` (m,).

    `joint` (m,) is the index among the joints of one that is a kink, else -1.
    """

    angles: Array
    peaks: Flags
    values: Array
    joint: Integers


class CyclePanels:
    """The curve over one period at a design, split at its joints."""

    def __init__(self, response: CycleResponse, x: Array) -> None:
        self.response, self.at = response, response.prologue(x)
        self.joints = find_breakpoints(response, self.at)
        self.folded = self.joints.folded
        self.breaks, self.order = self._breaks()
        self.nodes, self.weights, self.panel = self._quadrature()
        ends = np.stack([self.breaks[:-1] + ONE_SIDED_OFFSET, self.breaks[1:] - ONE_SIDED_OFFSET], axis=1).ravel()
        probes = np.concatenate([self.nodes, ends])
        values, rate = response.rate(self.at, np.mod(probes, response.period))
        self.values, self.node_rates = values[: len(self.nodes)], rate[: len(self.nodes)]
        self.end_values, self.end_rates = (ends[len(self.nodes) :].reshape(-1, 2) for ends in (values, rate))
        self.variance = Variance(self.values, self.weights)

    def _breaks(self) -> tuple[Array, Integers]:
        """Ends of the panels over one period, first and last the same joint, and the joint at each panel's start."""
        order = np.argsort(self.folded, kind="stable")
        if not len(order):
            return np.array([0.0, self.response.period]), np.array([-1])
        places = self.folded[order]
        separated = np.diff(places, append=places[0] + self.response.period) > MIN_BREAKPOINT_DISTANCE
        first = np.flatnonzero(np.roll(separated, 1))
        return np.append(places[first], places[first[0]] + self.response.period), order[first]

    def _quadrature(self) -> tuple[Array, Array, Integers]:
        """Nodes, weights that sum to 1 and the panel of each node."""
        pieces = np.ceil(np.diff(self.breaks) / MAX_PIECE).astype(int)
        panels = zip(self.breaks[:-1], self.breaks[1:], pieces.tolist(), strict=True)
        inner = [np.linspace(low, high, count, endpoint=False) for low, high, count in panels]
        nodes, weights = piecewise.gauss_panels(np.append(np.concatenate(inner), self.breaks[-1]), NODES)
        panel = np.repeat(np.arange(len(pieces)), pieces * NODES)
        return nodes.ravel(), weights.ravel() / self.response.period, panel

    @cached_property
    def extremes(self) -> CycleExtrema:
        angles, peaks = find_stationary_points(self._slope, *self._probes())
        before, after = np.roll(self.end_rates[:, 1], 1), self.end_rates[:, 0]
        kinks = np.flatnonzero((before > 0) != (after > 0))
        place = np.mod(np.concatenate([angles, self.breaks[kinks]]), self.response.period)
        kind = np.concatenate([peaks, before[kinks] > 0])
        joint = np.concatenate([np.full(len(angles), -1), self.order[kinks]])
        order = np.argsort(place, kind="stable")
        place, kind, joint = place[order], kind[order], joint[order]
        return CycleExtrema(place, kind, self.response.value(self.at, place), joint)

    @cached_property
    def look(self) -> ObjectiveSummary:
        mean = self.variance.mean
        values = np.append(self.extremes.values, mean)
        if (self.joints.orders == 0).any():
            values = np.append(values, self.end_values)
        return ObjectiveSummary(self.variance.value, float(values.max()), float(values.min()), mean)

    def _slope(self, phi: Array) -> tuple[Array, Array]:
        return self.response.rates(self.at, np.mod(phi, self.response.period))

    def _probes(self) -> tuple[Array, Array, Flags]:
        """Nodes and ends of all panels in order, dF/dphi there, and which neighbours lie in the same panel."""
        panels = np.arange(len(self.breaks) - 1)
        probes = np.concatenate([self.nodes, self.breaks[:-1] + ONE_SIDED_OFFSET, self.breaks[1:] - ONE_SIDED_OFFSET])
        rate = np.concatenate([self.node_rates, self.end_rates[:, 0], self.end_rates[:, 1]])
        panel = np.concatenate([self.panel, panels, panels])
        order = np.lexsort([probes, panel])
        return probes[order], rate[order], np.diff(panel[order]) == 0

    @cached_property
    def node_slopes(self) -> Array:
        """Gradients of the curve at the nodes, (n, p)."""
        return self.response.slopes(self.at, np.mod(self.nodes, self.response.period))[1][:, 1:]

    @cached_property
    def variance_gradient(self) -> Array:
        return self.variance.gradient(self.node_slopes)

    def variance_hessian(self) -> Array:
        """Return the Hessian (p, p) of the variance."""
        nodes = np.mod(self.nodes, self.response.period)
        bent = self.response.hessian(self.at, nodes, self.variance.slope)[1:, 1:]
        total: Array = bent + self.variance.squared(self.node_slopes) + self._at_joints()
        return total

    def _at_joints(self) -> Array:
        if self.order[0] < 0:
            return np.zeros((len(self.response.names),) * 2)
        velocity = self.joints.velocity[self.order]
        jump = self.end_rates[:, 0] - np.roll(self.end_rates[:, 1], 1)
        values = self.response.value(self.at, np.mod(self.breaks[:-1], self.response.period))
        weights = 2 * (values - self.variance.mean) * jump / self.response.period
        total: Array = (weights[:, None] * velocity).T @ velocity
        return total

    def row_slopes(self, angles: Array, joint: Integers) -> tuple[Array, Array, Array]:
        """Jacobians (m, 1 + p) in (phi, x), gradients (m, p) along the points, and where they were taken."""
        at_joint = joint >= 0
        velocity = np.zeros((len(angles), len(self.response.names)))
        velocity[at_joint] = self.joints.velocity[joint[at_joint]]
        place = angles + ONE_SIDED_OFFSET * at_joint
        slopes = self.response.slopes(self.at, place)[1]
        return slopes, gradients_along(slopes, velocity), place


class ContinuousCycle:
    """A turn of the curve by its true extremes and integrals. Implements `Turn`."""

    def __init__(self, response: CycleResponse) -> None:
        self.response = response
        self.panels = LastCallCache(lambda x: CyclePanels(response, x))

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self.panels(x).look

    def local(self, x: Array) -> ExtremumRows:
        """Return the local model of the objective near a design x (p,)."""
        return ExtremumRows(self.panels, self.panels(x).extremes)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        panels = self.panels(x)
        extremes = panels.extremes
        _, gradients, _ = panels.row_slopes(extremes.angles, extremes.joint)
        return Conditions(extremes.values[extremes.peaks], gradients[extremes.peaks], extremes.values[~extremes.peaks],
                          gradients[~extremes.peaks], panels.variance_gradient,
                          np.empty((0, len(x))))  # fmt: skip


class ExtremumRows:
    """One row for each window between fixed angles: its greatest value, or its least. Implements `Local`.

    The windows of maxima are parted by `valleys`, those of minima by `peaks`: the angles of the extremes where the rows
    were made. All windows together cover the period, so no new extreme can be missed. Two peaks in one window give its
    row a kink where they change places: `upper` and `lower` are the fixed angles of further rows, smooth ones, which
    keep both in sight until each has its own window.
    """

    def __init__(
        self,
        panels: Callable[[Array], CyclePanels],
        extremes: CycleExtrema,
        upper: Array = NO_ANGLES,
        lower: Array = NO_ANGLES,
    ) -> None:
        self.panels, self.upper, self.lower = panels, upper, lower
        self.valleys, self.peaks = extremes.angles[~extremes.peaks], extremes.angles[extremes.peaks]
        self.bounds = np.empty((2, 0))
        self._seen: list[tuple[float, float]] = []
        self._state = LastCallCache(lambda x: _ExtremumState(self, x))

    def grown(self, x: Array, high: float, low: float) -> ExtremumRows:
        """Return a copy with the windows of this design and rows at the extremes of the previous designs."""
        tops, bottoms = (np.array(angles) for angles in zip(*self._seen, strict=True))
        upper, lower = (
            drop_close_angles(np.concatenate(a), MIN_ROW_DISTANCE) for a in ((self.upper, tops), (self.lower, bottoms))
        )
        return ExtremumRows(self.panels, self._state(x).panels.extremes, upper, lower)

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self._state(x).panels.look

    def values(self, x: Array) -> ModelValues:
        """Return the values of the smooth function, rows and holds at a design x (p,)."""
        state = self._state(x)
        return ModelValues(
            state.panels.variance.value, state.values[state.tops], state.values[~state.tops], np.empty(0)
        )

    def slopes(self, x: Array) -> ModelGradients:
        """Return the gradients of the smooth function, rows and holds at a design x (p,)."""
        state = self._state(x)
        extremes = state.panels.extremes
        high, low = extremes.values.argmax(), extremes.values.argmin()
        self._seen.append((float(extremes.angles[high]), float(extremes.angles[low])))
        _, gradients, _ = state.slopes
        empty = np.empty((0, len(x)))
        return ModelGradients(state.panels.variance_gradient, gradients[state.tops], gradients[~state.tops], empty)

    def curvature(self, x: Array, weights: ModelValues) -> Array:
        """Return the weighted sum (p, p) of the Hessians at a design x (p,)."""
        state = self._state(x)
        each = np.concatenate([weights.upper, weights.lower])
        return weights.smooth * state.panels.variance_hessian() + np.tensordot(each, state.hessians(each != 0), 1)


class _ExtremumState:
    """All rows at one design: angle, value, joint or -1, and whether it is a smooth peak, which moves on its own."""

    def __init__(self, rows: ExtremumRows, x: Array) -> None:
        self.panels = rows.panels(x)
        extremes = self.panels.extremes
        picked = [
            _select_window_rows(self.panels, rows.valleys, extremes, True),
            _fixed_rows(self.panels, rows.upper),
            _select_window_rows(self.panels, rows.peaks, extremes, False),
            _fixed_rows(self.panels, rows.lower),
        ]
        self.angles, self.values, self.joint, self.smooth = (np.concatenate(part) for part in zip(*picked, strict=True))
        self.tops = np.arange(len(self.angles)) < len(rows.valleys) + len(rows.upper)

    @cached_property
    def slopes(self) -> tuple[Array, Array, Array]:
        return self.panels.row_slopes(self.angles, self.joint)

    def hessians(self, selected: Flags) -> Array:
        """Return the Hessians (m, p, p) of the selected rows, zero for the others."""
        slopes, _, place = self.slopes
        size = len(self.panels.response.names)
        total = np.zeros((len(place), size, size))
        if selected.any():
            second = self.panels.response.hessians(self.panels.at, place[selected])
            motion = self._motion(second, selected)
            total[selected] = hessians_along(slopes[selected], second, motion)
        return total

    def _motion(self, second: Array, selected: Flags) -> PointMotion:
        panels, joint, smooth = self.panels, self.joint[selected], self.smooth[selected]
        motion = fixed_motion(len(joint), second.shape[1] - 1)
        motion.velocity[smooth] = peak_velocity(second[smooth])
        at_joint = joint >= 0
        if at_joint.any():
            motion.velocity[at_joint] = panels.joints.velocity[joint[at_joint]]
            motion.acceleration[at_joint] = panels.joints.acceleration(joint[at_joint])
        return motion


def _select_window_rows(
    panels: CyclePanels, edges: Array, extremes: CycleExtrema, peaks: bool
) -> tuple[Array, Array, Integers, Flags]:
    """The row of each window up to an edge: its extreme, or the edge if that is more.

    A window without an extreme inside has it at an edge: the right one here, the left one in the window before.
    """
    sign = 1 if peaks else -1
    inside = np.flatnonzero(extremes.peaks == peaks)
    window = np.searchsorted(edges, extremes.angles[inside]) % max(len(edges), 1)
    angles, values, joint, smooth = _fixed_rows(panels, edges)
    for i, w in zip(inside, window, strict=True):
        if sign * extremes.values[i] > sign * values[w]:
            angles[w], values[w], joint[w] = extremes.angles[i], extremes.values[i], extremes.joint[i]
            smooth[w] = joint[w] < 0
    return angles, values, joint, smooth


def _fixed_rows(panels: CyclePanels, angles: Array) -> tuple[Array, Array, Integers, Flags]:
    """Rows at fixed angles."""
    count = len(angles)
    values = panels.response.value(panels.at, angles) if count else np.empty(0)
    return angles.copy(), values, np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=bool)


def drop_close_angles(angles: Array, distance: float) -> Array:
    """The angles in order, less those closer than `distance` to the one before [rad]."""
    separated: list[float] = []
    for angle in np.sort(angles):
        if not separated or angle - separated[-1] > distance:
            separated.append(float(angle))
    return np.array(separated)
