"""Measures at single angles of a cycle: a fixed one, or an extremum of a quantity.

The angle a(x) of an extremum moves with the design. With G(phi, x) = 0 there, the derivative of the
quantity, implicit differentiation gives a' = -G_x / G_phi, and a'' = -H / G_phi, where H is the
second derivative of G along (a', 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Measure
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


class NodeMeasure:
    """A quantity at a fixed angle of the cycle, or where another is greatest or least, as part of
    an objective: its value, or its size as the largest of two rows, the value and its opposite.

    Values are in the unit of the quantity's key.
    """

    windows, kinks = False, None

    def __init__(self, machine: Machine, measure: Measure) -> None:
        self.machine, self.measure = machine, measure
        self.response = open_response(machine, [measure.name])
        self._factor = self.response.quantities[0].factor
        self._anchor = None
        if measure.where is not None:
            name = measure.where.name
            self._anchor = MachineResponse(machine, [name], rates=[name])
        self.weights = np.full(int(measure.size), measure.weight)
        self.groups: Integers = np.zeros(2 * len(self.weights), dtype=np.int64)
        self.bounds = np.empty((2, 0))
        self._state = LastCallCache(lambda x: _NodeState(self, x))

    def restart(self) -> None:
        """Forget all designs so far, of the extremum too."""
        self.response.restart()
        if self._anchor is not None:
            self._anchor.restart()
        self._state = LastCallCache(lambda x: _NodeState(self, x))

    def value(self, x: Array) -> float:
        """Return the quantity at a design x (p,).

        Raises ComputationError where loops do not close, and for an extremum at a corner.
        """
        return self._state(x).value

    @cached_property
    def units(self) -> Array:
        """The size (g,) of the rows at the machine's own design."""
        return np.full(len(self.weights), abs(self.value(self.machine.design)) or 1.0)

    def find_angle(self, point: DesignPoint) -> Array:
        """Return the angle (1,) [rad] at a design."""
        machine, where, anchor = self.machine, self.measure.where, self._anchor
        if where is None or anchor is None:
            assert self.measure.angle is not None
            if machine.motion is not None:
                return np.array([machine.turn * self.measure.angle / machine.motion.span])
            return np.radians([self.measure.angle % 360])
        grid = machine.list_angles(max(machine.samples, SCANNED))
        values = anchor.values(point, grid)[0]
        index = extrema.index_first_extremum(grid, values, where.sign)
        bracket = grid[index] + np.array([-grid[1], grid[1]])
        ends = anchor.values(point, bracket)[1]

        def rate(phi: Array) -> tuple[Array, Array]:
            rates, slopes = anchor.slopes(point, phi)
            return rates[1], slopes[1, :, 0]

        is_corner = ends[0] * ends[1] > 0
        if not is_corner:
            angle = roots.find_bracketed_roots(rate, bracket[:1], bracket[1:], (ends[:1], ends[1:]))
            is_corner = abs(float(rate(angle)[0][0])) > CORNER * np.abs(ends).max()
        if is_corner:
            degrees = np.degrees(grid[index])
            raise ComputationError(f"{machine.name}: {where} at a corner, near {degrees:.6g} deg")
        return angle

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
        value = self.value(x)
        if self.measure.size:
            return np.array([0.0, value, -value])
        return np.array([self.measure.weight * value])

    def slopes(self, x: Array) -> Array:
        """Return their gradients (1 + r, p) at a design x (p,)."""
        slope = self._state(x).slope
        if self.measure.size:
            return np.vstack([np.zeros(len(x)), slope, -slope])
        return self.measure.weight * slope[None]

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (1 + r,)."""
        is_size = self.measure.size
        weight = weights[1] - weights[2] if is_size else weights[0] * self.measure.weight
        return np.asarray(weight * self._state(x).hessian)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        values, slopes = self.values(x), self.slopes(x)
        return Conditions(values[1:], self.groups, slopes[1:], slopes[0], np.empty((0, len(x))))

    def columns(self, x: Array) -> Array:
        """Return the gradient (1, p) at a design in shares of the bounds, by its largest part."""
        slope = self._state(x).slope
        widths = self.machine.upper - self.machine.lower
        return np.asarray(slope[None] / (np.abs(slope).max() or 1.0) * widths)


class _NodeState:
    """Value, gradient (p,) and Hessian (p, p) of a quantity at the node of a design x (p,)."""

    def __init__(self, measure: NodeMeasure, x: Array) -> None:
        self._response, self._anchor = measure.response, measure._anchor
        self._factor, self._point = measure._factor, measure.response.at(x)
        self._angle = measure.find_angle(self._point)
        self._rise, self._motion = 1.0, np.zeros((1, len(x)))
        if self._anchor is not None:
            self._rise, *rest = self._anchor.slopes(self._point, self._angle)[1][1, 0]
            self._motion = -np.array([rest]) / self._rise
        values, slopes = self._response.slopes(self._point, self._angle)
        self.value = float(values[0, 0]) / self._factor
        self._slope_in_angle = slopes[0, 0, 0] / self._factor
        self.slope = slopes[0, 0, 1:] / self._factor + self._slope_in_angle * self._motion[0]

    @cached_property
    def hessian(self) -> Array:
        at, weight = (self._point, self._angle), np.array([[1 / self._factor]])
        if self._anchor is None:
            return self._response.curvature(*at, weight)[1:, 1:]
        pull = np.array([[0.0], [-self._slope_in_angle / self._rise]])
        bent = self._response.curvature_along(*at, weight, self._motion)
        return bent + self._anchor.curvature_along(*at, pull, self._motion)
