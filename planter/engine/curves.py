"""Curves of a machine over its angle for sums of measures: quantities, events, and the parts that
conditions leave.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Self

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.measures import MeasureCondition
from planter.engine.response import DesignPoint, MachineResponse, open_response
from planter.engine.solvers.response import BreakpointEvent
from planter.kernels import Array

CLOSED = 1e-6
"""Share of its range by which a quantity may differ after a turn: loops are closed to less."""


class QuantityCurves:
    """Quantities F(phi, x), (m,), of a machine, in SI, with its events as breakpoints: an
    `optimise.response.CycleResponse`.

    After them stand the powers `worked`, divided by the speed: their integral over the angle is a
    work. The order of a breakpoint is that of the machine's forces: a quantity may be smoother there.
    Where a condition begins or ceases to hold is a breakpoint, too, and so is a zero of `squares`.
    """

    def __init__(
        self,
        machine: Machine,
        names: Sequence[str],
        conditions: Sequence[MeasureCondition] = (),
        worked: Sequence[str] = (),
        squares: Sequence[tuple[Quantity, ca.SX]] = (),
    ) -> None:
        """Raises InputError if the machine has no quantity of one of the names."""
        self.machine, self.conditions = machine, tuple(conditions)
        rates = [_build_rate(machine, name) for name in worked]
        self.curves = open_response(machine, names, more=rates)
        self.curves.settles = True
        self.response, self.quantities = self.curves, self.curves.quantities
        self.names, self.lower, self.upper = machine.design_names, machine.lower, machine.upper
        self._levels = [_build_levels(machine, condition) for condition in self.conditions]
        self._squares = tuple(squares)
        zeros = [BreakpointEvent(f"zero of {quantity.name}", 1, None) for quantity, _ in squares]
        ends = [level.name for levels in self._levels for level, _ in levels]
        levels = [BreakpointEvent(name, 0, None) for name in ends]
        self.events = (*_list_events(machine), *zeros, *levels)

    @property
    def design(self) -> Array:
        """The machine's own design (p,)."""
        return self.machine.design

    @property
    def count(self) -> int:
        """Number m of curves."""
        return len(self.quantities)

    @property
    def turn(self) -> float:
        """The angle of a cycle of the machine [rad]."""
        return self.machine.turn

    @property
    def period(self) -> float:
        """The angle after which the curves repeat [rad]: a side's after a turn."""
        total = all(quantity.total for quantity in self.quantities) and not self.conditions
        return self.machine.period if total else self.machine.turn

    @property
    def shifts(self) -> tuple[float, ...]:
        """Angles [rad] by which the breakpoints of each side come before those of the first."""
        return self.machine.offsets if self.period == self.machine.turn else (0.0,)

    @cached_property
    def is_closed(self) -> bool:
        """Whether all curves and their slopes are at the end of a turn what they are at its
        beginning.
        """
        if self.machine.motion is not None:
            return False
        angles, at = (
            np.linspace(0.0, self.machine.turn, 1 + self.machine.samples),
            self.prologue(self.design),
        )
        (values, _), rates = (
            self.curves.derivatives(at, angles, is_loose=True),
            self.curves.rates(at, angles, is_loose=True),
        )
        gaps = [np.abs(part[:, -1] - part[:, 0]) for part in (values, *rates)]
        sizes = [np.ptp(values, axis=1), *(np.nanmax(np.abs(part), axis=1) for part in rates)]
        return all(
            bool((gap <= CLOSED * size).all()) for gap, size in zip(gaps, sizes, strict=True)
        )

    @property
    def offsets(self) -> tuple[float, ...]:
        """Angles [rad] of the lanes that add up to the curves."""
        return self.response.offsets

    def with_machine(self, machine: Machine) -> Self:
        """Return the curves of a machine that differs from this one's in numbers alone: all
        functions are shared.
        """
        curves = copy.copy(self)
        curves.machine, curves.lower, curves.upper = machine, machine.lower, machine.upper
        return curves

    def prologue(self, x: Array) -> DesignPoint:
        """Return the point of a design x (p,), for all angles."""
        return self.response.at_data(self.machine.build_data(x))

    def restart(self) -> None:
        """Forget all designs so far: what follows does not depend on them, to the last digit."""
        self.response.restart()
        self.event_functions.restart()

    @cached_property
    def event_functions(self) -> MachineResponse:
        """Functions of the angle whose zeros, or whole multiples of a period, are the events."""
        levels = [*self._squares, *(level for levels in self._levels for level in levels)]
        return open_response(self.machine, (), with_events=True, more=levels)

    def misses(self, at: DesignPoint, phi: Array) -> Array:
        """Return by how much each condition is missed at angles in SI, (c, n), not positive where
        it holds.
        """
        if not self.conditions:
            return np.empty((0, len(phi)))
        rows = self.event_functions.values(at, phi)[-sum(map(len, self._levels)) :]
        misses, first = [], 0
        for condition, levels in zip(self.conditions, self._levels, strict=True):
            beyond, *below = rows[first : first + len(levels)]
            misses.append(condition.sign * (np.maximum(beyond, -below[0]) if below else beyond))
            first += len(levels)
        return np.array(misses)


def _list_events(machine: Machine) -> list[BreakpointEvent]:
    """Return the events of a machine; those of which nothing is known may let forces jump."""
    if machine.events is None:
        return []
    kinds: Sequence[Mapping[str, Any]] = machine.event_kinds or [
        {"name": f"event {i + 1}"} for i in range(machine.events.numel_out(0))
    ]
    return [
        BreakpointEvent(str(kind["name"]), int(kind.get("order", 0)), kind.get("period"))
        for kind in kinds
    ]


def _build_rate(machine: Machine, name: str) -> tuple[Quantity, ca.SX]:
    """Return a power as the rate of a work over the angle [J/rad], with its graph."""
    quantity = machine.find_quantity(name)
    graph = machine.graph(quantity.name) / ca.fabs(machine.symbols[1][machine.speed])
    return Quantity(quantity.name, "J", quantity.meaning, quantity.key), graph


def _build_levels(machine: Machine, condition: MeasureCondition) -> list[tuple[Quantity, ca.SX]]:
    """Return functions of the angle in SI that vanish where a condition begins or ceases to hold,
    with their graphs.
    """
    quantity = machine.find_quantity(condition.name)
    graph, level = machine.graph(quantity.name), condition.number * quantity.factor
    signs = (1, -1) if condition.absolute else (1,)
    return [
        (Quantity(str(condition), quantity.unit, "condition", quantity.key), graph - sign * level)
        for sign in signs
    ]
