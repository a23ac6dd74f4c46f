"""Measures at single angles of a cycle: a fixed one, an extremum of a quantity, jumps; and sums of
them.

Angles that move with the design are linear in a few anchors: angles at which an event happens, or
at which the derivative of a quantity vanishes. With G(phi, x) = 0 at an anchor a(x), implicit
differentiation gives a' = -G_x / G_phi, and a'' = -H / G_phi, where H is the second derivative of G
along (a', 1).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Extremum, Measure
from planter.engine.response import DesignPoint, MachineResponse, Switchings
from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import extrema, roots
from planter.numerics.arrays import Integers, LastCallCache
from planter.optimise.objective import (
    BreakpointHold,
    Conditions,
    ObjectiveSummary,
    find_tops,
)

SCANNED = 360
"""Samples of a cycle among which anchors are looked for, at least."""
SIDE = 1e-9
"""Distance of the nodes on both sides of a switching point [rad]."""
CORNER = 1e-6
"""Share of the slopes a step away that a slope keeps at an extremum only if it jumps there: it is a
corner.
"""
SPARE_EVENTS = 2
"""Switching points that may appear beyond those of the machine's own design."""


@dataclass(frozen=True)
class NodeValues:
    """Quantities (m, n) at the nodes of a design in the units of their keys, with Jacobians (m, n,
    p) in the design.

    `curvature` of weights (m, n) is the weighted sum of their Hessians, (p, p). `is_empty` holds if
    there are no nodes.
    """

    values: Array
    slopes: Array
    curvature: Callable[[Array], Array]
    is_empty: bool = False


class Nodes(ABC):
    """Quantities by name at nodes over designs x (p,)."""

    def __init__(self, machine: Machine, names: Sequence[str]) -> None:
        self.machine, self.names = machine, tuple(names)
        self.response = MachineResponse(machine, names)
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


@dataclass(frozen=True)
class Placement:
    """Nodes as linear functions of anchors (a,): angles = fixed + mix @ anchors.

    `rows` (a,) are the rows of the anchors' response that vanish there, or pass a constant.
    """

    anchors: Array
    rows: Integers
    fixed: Array
    mix: Array
    is_empty: bool = False


class MovingNodes(Nodes):
    """Nodes that move with the design by anchors, which are zeros of rows of another response."""

    def __init__(self, machine: Machine, names: Sequence[str], anchors: MachineResponse) -> None:
        super().__init__(machine, names)
        self.anchors = anchors
        count = max(machine.samples, SCANNED)
        self.grid = machine.list_angles(count)

    def restart(self) -> None:
        """Forget all designs so far, of the anchors too."""
        super().restart()
        self.anchors.restart()

    @abstractmethod
    def place(self, point: DesignPoint) -> Placement:
        """Return where the nodes are at a design."""

    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at the nodes of a design x (p,)."""
        point, units = self.response.at(x), self.units[:, None]
        placement = self.place(point)
        angles = placement.fixed + placement.mix @ placement.anchors
        count = np.arange(len(placement.anchors))
        rises, moving = np.ones(len(count)), np.empty((len(count), len(x)))
        if len(count):
            slopes = self.anchors.slopes(point, placement.anchors)[1][placement.rows, count]
            rises = slopes[:, 0]
            moving = -slopes[:, 1:] / rises[:, None]
        angle_slopes = placement.mix @ moving
        values, slopes = self.response.slopes(point, angles)

        def curvature(weights: Array) -> Array:
            scaled = weights / units
            total = self.response.curvature_along(point, angles, scaled, angle_slopes)
            if len(count):
                rows = np.zeros((len(self.anchors.quantities), len(count)))
                rows[placement.rows, count] = (
                    -placement.mix.T @ (scaled * slopes[:, :, 0]).sum(axis=0) / rises
                )
                total = total + self.anchors.curvature_along(point, placement.anchors, rows, moving)
            return total

        gradients = (slopes[:, :, 1:] + slopes[:, :, :1] * angle_slopes) / units[:, :, None]
        return NodeValues(values / units, gradients, curvature, placement.is_empty)


class ExtremumNode(MovingNodes):
    """The angle at which a quantity is greatest or least over the cycle."""

    def __init__(self, machine: Machine, names: Sequence[str], extremum: Extremum) -> None:
        super().__init__(
            machine, names, MachineResponse(machine, [extremum.name], rates=[extremum.name])
        )
        self.extremum = extremum

    def place(self, point: DesignPoint) -> Placement:
        """Return the placement of the nodes at a design."""
        values = self.anchors.values(point, self.grid)[0]
        index = extrema.index_first_extremum(self.grid, values, self.extremum.sign)
        step = self.grid[1]
        bracket = self.grid[index] + np.array([-step, step])
        ends = self.anchors.values(point, bracket)[1]

        def rate(phi: Array) -> tuple[Array, Array]:
            rates, slopes = self.anchors.slopes(point, phi)
            return rates[1], slopes[1, :, 0]

        is_corner = ends[0] * ends[1] > 0
        if not is_corner:
            anchor = roots.find_bracketed_roots(
                rate, bracket[:1], bracket[1:], (ends[:1], ends[1:])
            )
            is_corner = abs(float(rate(anchor)[0][0])) > CORNER * np.abs(ends).max()
        if is_corner:
            angle = np.degrees(self.grid[index])
            raise ComputationError(
                f"{self.machine.name}: {self.extremum} at a corner, near {angle:.6g} deg"
            )
        return Placement(anchor, np.array([1]), np.zeros(1), np.ones((1, 1)))


class JumpNodes(MovingNodes):
    """The jumps of quantities where a law of a machine changes, one a node, in place of their
    values.

    Events of order 0 count: it is the order of the forces, and no result is rougher than they.
    One-sided values are continued from two points of a side up to the event, so that what does not
    jump there has no jump but rounding. There are as many nodes as events at the machine's own
    design, and some to spare; those that are missing are the first event's. Without events every
    jump is zero.
    """

    SIDES = SIDE * np.array([-2.0, -1.0, 1.0, 2.0])
    SHARES = np.array([1.0, -2.0, 2.0, -1.0])

    def __init__(self, machine: Machine, names: Sequence[str]) -> None:
        self.switchings = Switchings(machine, max(machine.samples, SCANNED))
        super().__init__(machine, names, self.switchings.response)
        rough = [row for row, kind in enumerate(self.switchings.kinds) if kind.get("order", 0) == 0]
        self.rough = np.array(rough, dtype=np.int64)
        events = len(self._find(self.response.at(machine.design))[0])
        self.count = events + SPARE_EVENTS if len(self.rough) else 1

    def _find(self, point: DesignPoint) -> tuple[Array, Integers]:
        """Return the angles (s,) at which forces jump, and the rows of these events."""
        angles, rows = self.switchings.find(point)
        chosen = np.isin(rows, self.rough)
        return angles[chosen], rows[chosen]

    def place(self, point: DesignPoint) -> Placement:
        """Return two nodes on each side of every event."""
        angles, rows = self._find(point)
        if not len(angles):
            count = len(self.SIDES) * self.count
            return Placement(
                np.empty(0), rows, np.zeros(count), np.empty((count, 0)), is_empty=True
            )
        if len(angles) > self.count:
            raise ComputationError(
                f"{self.machine.name}: a law changes {len(angles)} times in the cycle"
            )
        chosen = np.arange(self.count)
        chosen[len(angles) :] = 0
        mix = np.repeat(np.eye(len(angles))[chosen], len(self.SIDES), axis=0)
        return Placement(angles, rows, np.tile(self.SIDES, self.count), mix)

    def evaluate(self, x: Array) -> NodeValues:
        """Return the jumps in place of values."""
        at = super().evaluate(x)
        shares = np.kron(np.eye(self.count), 0 * self.SHARES if at.is_empty else self.SHARES)

        def curvature(weights: Array) -> Array:
            return at.curvature(weights @ shares)

        return NodeValues(
            at.values @ shares.T,
            np.einsum("kn,mnp->mkp", shares, at.slopes),
            curvature,
            at.is_empty,
        )


def build_nodes(machine: Machine, measure: Measure) -> Nodes:
    """Return the nodes of a measure at a fixed angle, where a quantity is greatest or least, or of
    a jump.
    """
    if measure.kind == "jump":
        return JumpNodes(machine, [measure.name])
    if measure.where is not None:
        return ExtremumNode(machine, [measure.name], measure.where)
    assert measure.angle is not None
    return FixedNodes(machine, [measure.name], np.radians([measure.angle % 360]))


class NodeMeasure:
    """A measure at nodes as part of an objective: its value, or the largest size of its values as a
    group of rows.
    """

    windows, kinks = False, None

    def __init__(self, machine: Machine, measure: Measure) -> None:
        self.machine, self.measure = machine, measure
        self.nodes = build_nodes(machine, measure)
        self.weights = np.full(int(measure.is_size), measure.weight)
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
        count = 2 * self.nodes(self.machine.design).values.shape[1] if self.measure.is_size else 0
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
        if self.measure.is_size:
            return np.concatenate([[0.0], values, -values])
        return self.measure.weight * values

    def slopes(self, x: Array) -> Array:
        """Return their gradients (1 + r, p) at a design x (p,)."""
        slopes = self.nodes(x).slopes[0]
        if self.measure.is_size:
            return np.vstack([np.zeros(len(x)), slopes, -slopes])
        return self.measure.weight * slopes

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (1 + r,)."""
        if self.measure.is_size:
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
