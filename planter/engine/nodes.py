"""Measures at single angles of a cycle: a fixed one, or an extremum of a quantity.

The angle a(x) of an extremum moves with the design. With G(phi, x) = 0 there, the derivative of the
quantity, implicit differentiation gives a' = -G_x / G_phi, and a'' = -H / G_phi, where H is the
second derivative of G along (a', 1).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Extremum, Measure
from planter.engine.response import DesignPoint, MachineResponse, open_response
from planter.engine.solvers.objective import (
    BreakpointHold,
    Conditions,
    ObjectiveSummary,
    find_tops,
)
from planter.errors import ComputationError
from planter.kernels import Array, Integers
from planter.numerics import extrema, roots
from planter.numerics.arrays import LastCallCache

SCANNED = 360
"""Samples of a cycle among which anchors are looked for, at least."""
CORNER = 1e-6
"""Share of the slopes a step away that a slope keeps at an extremum only if it jumps there: it is a
corner.
"""


@dataclass(frozen=True)
class NodeValues:
    """Quantities (m, n) at the nodes of a design in the units of their keys, with Jacobians (m, n,
    p) in the design.

    `curvature` of weights (m, n) is the weighted sum of their Hessians, (p, p).
    """

    values: Array
    slopes: Array
    curvature: Callable[[Array], Array]


class Nodes(ABC):
    """Quantities by name at nodes over designs x (p,)."""

    def __init__(self, machine: Machine, names: Sequence[str]) -> None:
        self.machine, self.names = machine, tuple(names)
        self.response = open_response(machine, names)
        self.units = np.array([quantity.factor for quantity in self.response.quantities])
        self._latest = LastCallCache(self.evaluate)

    def restart(self) -> None:
        """Forget all designs so far, as `Response.restart`."""
        self.response.restart()
        self._latest = LastCallCache(self.evaluate)

    def __call__(self, x: Array) -> NodeValues:
        """Return the quantities at a design. Raises ComputationError where loops do not close."""
        return self._latest(x)

    @abstractmethod
    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at a design x (p,), without a cache."""


class FixedNodes(Nodes):
    """Nodes at angles (n,) [rad]."""

    def __init__(self, machine: Machine, names: Sequence[str], angles: Array) -> None:
        super().__init__(machine, names)
        self.angles = angles

    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at the nodes of a design x (p,)."""
        point, units = self.response.at(x), self.units[:, None]
        values, slopes = self.response.slopes(point, self.angles)

        def curvature(weights: Array) -> Array:
            return self.response.curvature(point, self.angles, weights / units)[1:, 1:]

        return NodeValues(values / units, slopes[:, :, 1:] / units[:, :, None], curvature)


class ExtremumNode(Nodes):
    """The angle at which a quantity is greatest or least over the cycle."""

    def __init__(self, machine: Machine, names: Sequence[str], extremum: Extremum) -> None:
        super().__init__(machine, names)
        self.extremum = extremum
        self.anchor = MachineResponse(machine, [extremum.name], rates=[extremum.name])
        self.grid = machine.list_angles(max(machine.samples, SCANNED))

    def restart(self) -> None:
        """Forget all designs so far, of the extremum too."""
        super().restart()
        self.anchor.restart()

    def find_angle(self, point: DesignPoint) -> Array:
        """Return the angle (1,) of the extremum at a design.

        Raises ComputationError for one at a corner.
        """
        values = self.anchor.values(point, self.grid)[0]
        index = extrema.index_first_extremum(self.grid, values, self.extremum.sign)
        step = self.grid[1]
        bracket = self.grid[index] + np.array([-step, step])
        ends = self.anchor.values(point, bracket)[1]

        def rate(phi: Array) -> tuple[Array, Array]:
            rates, slopes = self.anchor.slopes(point, phi)
            return rates[1], slopes[1, :, 0]

        is_corner = ends[0] * ends[1] > 0
        if not is_corner:
            angle = roots.find_bracketed_roots(rate, bracket[:1], bracket[1:], (ends[:1], ends[1:]))
            is_corner = abs(float(rate(angle)[0][0])) > CORNER * np.abs(ends).max()
        if is_corner:
            degrees = np.degrees(self.grid[index])
            raise ComputationError(
                f"{self.machine.name}: {self.extremum} at a corner, near {degrees:.6g} deg"
            )
        return angle

    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at the node of a design x (p,)."""
        point, units = self.response.at(x), self.units[:, None]
        angle = self.find_angle(point)
        rise, *rest = self.anchor.slopes(point, angle)[1][1, 0]
        motion = -np.array([rest]) / rise
        values, slopes = self.response.slopes(point, angle)

        def curvature(weights: Array) -> Array:
            scaled = weights / units
            pull = np.array([[0.0], [-float((scaled * slopes[:, :, 0]).sum()) / rise]])
            bent = self.response.curvature_along(point, angle, scaled, motion)
            return bent + self.anchor.curvature_along(point, angle, pull, motion)

        gradients = (slopes[:, :, 1:] + slopes[:, :, :1] * motion) / units[:, :, None]
        return NodeValues(values / units, gradients, curvature)


def build_nodes(machine: Machine, measure: Measure) -> Nodes:
    """Return the nodes of a measure at a fixed angle, or where a quantity is greatest or least."""
    if measure.where is not None:
        return ExtremumNode(machine, [measure.name], measure.where)
    assert measure.angle is not None
    if machine.motion is not None:
        return FixedNodes(
            machine, [measure.name], np.array([machine.turn * measure.angle / machine.motion.span])
        )
    return FixedNodes(machine, [measure.name], np.radians([measure.angle % 360]))


class NodeMeasure:
    """A measure at nodes as part of an objective: its value, or the largest size of its values as a
    group of rows.
    """

    windows, kinks = False, None

    def __init__(self, machine: Machine, measure: Measure) -> None:
        self.machine, self.measure = machine, measure
        self.nodes = build_nodes(machine, measure)
        self.weights = np.full(int(measure.size), measure.weight)
        self.bounds = np.empty((2, 0))

    def restart(self) -> None:
        """Forget all designs so far."""
        self.nodes.restart()

    @cached_property
    def units(self) -> Array:
        """The size (g,) of the rows at the machine's own design."""
        size = float(np.abs(self.nodes(self.machine.design).values).max())
        return np.full(len(self.weights), size or 1.0)

    @cached_property
    def groups(self) -> Integers:
        """Groups (r,) of the rows: values, then values with the opposite sign."""
        count = 2 * self.nodes(self.machine.design).values.shape[1] if self.measure.size else 0
        return np.zeros(count, dtype=np.int64)

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary at a design x (p,)."""
        values = self.values(x)
        tops = find_tops(values[1:], self.groups, len(self.weights))
        return ObjectiveSummary(float(values[0]), tops)

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> NodeMeasure:
        """Return the local model near a design x (p,): the measure itself."""
        return self

    def coarse(self, x: Array) -> NodeMeasure:
        """Return the measure itself, which has no samples."""
        return self

    def extended(self, x: Array, tops: Array) -> NodeMeasure:
        """Return the model, which has all its rows."""
        return self

    def values(self, x: Array) -> Array:
        """Return the smooth value, then the rows, (1 + r,), at a design x (p,)."""
        values = self.nodes(x).values[0]
        if self.measure.size:
            return np.concatenate([[0.0], values, -values])
        return self.measure.weight * values

    def slopes(self, x: Array) -> Array:
        """Return their gradients (1 + r, p) at a design x (p,)."""
        slopes = self.nodes(x).slopes[0]
        if self.measure.size:
            return np.vstack([np.zeros(len(x)), slopes, -slopes])
        return self.measure.weight * slopes

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (1 + r,)."""
        if self.measure.size:
            values, opposite = np.split(weights[1:], 2)
            return self.nodes(x).curvature((values - opposite)[None])
        return self.nodes(x).curvature(weights[None] * self.measure.weight)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        values, slopes = self.values(x), self.slopes(x)
        return Conditions(values[1:], self.groups, slopes[1:], slopes[0], np.empty((0, len(x))))

    def columns(self, x: Array) -> Array:
        """Return gradients (n, p) at a design in shares of the bounds, by their largest."""
        slopes = self.nodes(x).slopes[0]
        scaled: Array = (
            slopes / (np.abs(slopes).max() or 1.0) * (self.machine.upper - self.machine.lower)
        )
        return scaled
