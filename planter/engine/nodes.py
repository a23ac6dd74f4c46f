"""Measures at single angles of a cycle, or times of a motion: fixed ones, or those that follow from
the design (`planter.engine.places`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Measure
from planter.engine.places import open_place
from planter.engine.response import open_response
from planter.engine.solvers.objective import (
    BreakpointHold,
    Conditions,
    ObjectiveSummary,
    find_tops,
)
from planter.kernels import Array, Integers
from planter.numerics.arrays import LastCallCache


class NodeMeasure:
    """A quantity at a single angle of the cycle, or time of the motion, as part of an objective: its
    value, or its size as the largest of two rows, the value and its opposite.

    Values are in the unit of the quantity's key.
    """

    windows, kinks = False, None

    def __init__(self, machine: Machine, measure: Measure) -> None:
        self.machine, self.measure = machine, measure
        self.response = open_response(machine, [measure.name])
        self._factor = self.response.quantities[0].factor
        self.places = open_place(machine, measure)
        self.weights = np.full(int(measure.size), measure.weight)
        self.groups: Integers = np.zeros(2 * len(self.weights), dtype=np.int64)
        self.bounds = np.empty((2, 0))
        self._state = LastCallCache(lambda x: _NodeState(self, x))

    def restart(self) -> None:
        """Forget all designs so far, of the place too."""
        self.response.restart()
        self.places.restart()
        self._state = LastCallCache(lambda x: _NodeState(self, x))

    def value(self, x: Array) -> float:
        """Return the quantity at a design x (p,).

        Raises ComputationError where loops do not close, and where the place has no derivative.
        """
        return self._state(x).value

    @cached_property
    def units(self) -> Array:
        """The size (g,) of the rows at the machine's own design."""
        return np.full(len(self.weights), abs(self.value(self.machine.design)) or 1.0)

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
        self._response, self._factor = measure.response, measure._factor
        self._point = measure.response.at(x)
        self._place = measure.places.find(self._point)
        self._rise, self._motion = 1.0, np.zeros((1, len(x)))
        if self._place.response is not None:
            self._rise, slope = self._place.differentiate(self._point)
            self._motion = -slope[None] / self._rise
        values, slopes = self._response.slopes(self._point, self._place.angle)
        self.value = float(values[0, 0]) / self._factor
        self._slope_in_angle = slopes[0, 0, 0] / self._factor
        self.slope = slopes[0, 0, 1:] / self._factor + self._slope_in_angle * self._motion[0]

    @cached_property
    def hessian(self) -> Array:
        """The second derivatives."""
        at, weight = (self._point, self._place.angle), np.array([[1 / self._factor]])
        if self._place.response is None:
            return self._response.curvature(*at, weight)[1:, 1:]
        pull = -self._slope_in_angle / self._rise
        bent = self._response.curvature_along(*at, weight, self._motion)
        return bent + self._place.curvature(self._point, pull, self._motion)
