"""Quantities of a machine along its angle, with exact derivatives in the angle and the design, for every machine.

Derivatives cross the prologue's cut as inputs: along the design h moves by its tangent `dh`, so that no lane is
differentiated by the coefficients of a series. Coordinates of loops are inputs as they were found; the lane carries
their derivatives itself, by Newton steps in its graph.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.loops import Course, Loops
from planter.engine.machine import LEAST_PIVOT, Machine, Quantity
from planter.errors import ComputationError, NotFiniteError
from planter.kernels import Array, Kernel

INPUTS = ("phi", "d", "h", "q")


@dataclass(frozen=True)
class DesignPoint:
    """A design: all values d (v,), what it hoists h (k,), and the entries of the tangent of h in the design."""

    d: Array
    h: Array
    dh: Array


class Response:
    """Quantities by name (m,), all if none are named, at angles phi (n,) [rad] over designs x (p,), in SI units.

    After them stand the derivatives in phi of the quantities that `rates` names, then, `with_events`, the functions
    whose zeros are the machine's switching points, then `more` quantities, by their graphs in the machine's symbols.
    """

    def __init__(
        self,
        machine: Machine,
        names: Sequence[str] | None = None,
        rates: Sequence[str] = (),
        with_events: bool = False,
        more: Sequence[tuple[Quantity, ca.SX]] = (),
    ) -> None:
        chosen = [quantity.name for quantity in machine.quantities] if names is None else names
        self.machine = machine
        self.quantities = tuple(machine.find_quantity(name) for name in (*chosen, *rates))
        self._graph, self.shared = machine.rows([quantity.name for quantity in self.quantities])
        if with_events and machine.events is not None:
            events = machine.events(*machine.symbols)
            self._graph = ca.densify(ca.vertcat(self._graph, events))
            self.quantities += tuple(Quantity(f"event {i}", "1", "switching", "") for i in range(events.numel()))
            self.shared += (False,) * events.numel()
        if rates:
            quantities, rated = self._graph[: len(chosen)], self._graph[len(chosen) :]
            self._graph = ca.densify(ca.vertcat(quantities, ca.jacobian(rated, machine.symbols[0])))
        if more:
            self._graph = ca.densify(ca.vertcat(self._graph, *(graph for _, graph in more)))
            self.quantities += tuple(quantity for quantity, _ in more)
            self.shared += (False,) * len(more)
        self.offsets = machine.offsets if any(self.shared) else (0.0,)
        self._places: tuple[Array, Array] | None = None
        self._course: Course | None = None

    @property
    def _loops(self) -> Loops:
        assert self.machine.loops is not None
        return self.machine.loops

    def at(self, x: Array) -> DesignPoint:
        """Return the point of a design x (p,)."""
        return self.at_data(self.machine.data_at(x))

    def at_data(self, d: Array) -> DesignPoint:
        """Return the point of values d (v,)."""
        prologue = self._prologue(d=d)
        rows, columns = self._pattern.get_triplet()
        return DesignPoint(np.asarray(d, dtype=float), prologue["h"][:, 0], prologue["dh"][rows, columns])

    def values(self, point: DesignPoint, phi: Array) -> Array:
        """Return the quantities (m, n). Raises ComputationError where loops do not close or one is not finite."""
        return self._fold(self._evaluate(self._values, point, phi)["rows"], len(phi))

    def slopes(self, point: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return the quantities (m, n) and their Jacobian (m, n, 1 + p) in (phi, x)."""
        result = self._evaluate(self._slopes, point, phi, dh=point.dh)
        size = 1 + len(self.machine.moved)
        slopes = result["slopes"].reshape(len(self.quantities), size, -1)
        folded = np.stack([self._fold(slopes[:, j], len(phi)) for j in range(size)], axis=2)
        return self._fold(result["rows"], len(phi)), folded

    def derivatives(self, point: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return the quantities and their derivatives in phi, (m, n) each."""
        result = self._evaluate(self._derivatives, point, phi)
        return self._fold(result["rows"], len(phi)), self._fold(result["first"], len(phi))

    def rates(self, point: DesignPoint, phi: Array) -> tuple[Array, Array, Array]:
        """Return the quantities and their first two derivatives in phi, (m, n) each."""
        result = self._evaluate(self._rates, point, phi)
        value, first, second = (self._fold(result[name], len(phi)) for name in ("rows", "first", "second"))
        return value, first, second

    def curvature(self, point: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the sum over quantities and angles of weights (m, n) times Hessians in (phi, x), (1 + p, 1 + p)."""
        lanes, hoisted = self._bend(point, phi, weights)
        hessian: Array = lanes.sum(axis=2)
        hessian[1:, 1:] += hoisted
        return hessian

    def curvature_along(self, point: DesignPoint, phi: Array, weights: Array, angle_slopes: Array) -> Array:
        """Return that sum in the design alone, (p, p), of angles with slopes (n, p), but not for their bending."""
        lanes, hoisted = self._bend(point, phi, weights)
        moving = np.tile(angle_slopes, (len(self.offsets), 1))
        mixed = lanes[1:, 0] @ moving
        return lanes[1:, 1:].sum(axis=2) + hoisted + mixed + mixed.T + moving.T @ (lanes[0, 0][:, None] * moving)

    def _bend(self, point: DesignPoint, phi: Array, weights: Array) -> tuple[Array, Array]:
        """Return weighted Hessians in (phi, x), (1 + p, 1 + p, lanes), and what the prologue's own adds in x."""
        size = 1 + len(self.machine.moved)
        tiled = np.tile(weights, len(self.offsets))
        tiled[~np.array(self.shared), len(phi) :] = 0.0
        result = self._evaluate(self._bent, point, phi, dh=point.dh, weights=tiled)
        along = result["along"].sum(axis=1)
        return result["hessian"].reshape(size, size, -1), self._prologue_bent(d=point.d, weights=along)["hessian"]

    def check(self, values: Array, phi: Array) -> None:
        """Raise ComputationError where forces (m, n) of all quantities are not determined, or friction holds fast."""
        for quantity, row in zip(self.quantities, values, strict=True):
            worst = int(np.argmin(row))
            angle = np.degrees(phi[worst])
            if quantity.role == "states" and not row.all():
                reason = f"friction holds it fast at {angle:.6g} deg; less of it moves"
            elif quantity.role == "pivot" and row[worst] < LEAST_PIVOT:
                reason = f"{quantity.meaning}: {row[worst]:.1e} at {angle:.6g} deg"
            else:
                continue
            raise ComputationError(f"{self.machine.name}: {reason}")

    def coordinates(self, d: Array, phi: Array) -> Array:
        """Return the coordinates of loops (c, n), near those that were found last, else by a walk along the turn."""
        if self.machine.loops is None:
            return np.empty((0, len(phi)))
        if self._places is not None and np.array_equal(self._places[0], phi):
            q = self.machine.loops.near(phi, np.repeat(d[:, None], len(phi), axis=1), self._places[1])
            if q is not None:
                self._places = phi, q
                return q
        self._places = phi, self._follow(d).at(phi)
        return self._places[1]

    def _follow(self, d: Array) -> Course:
        """Return the coordinates over a turn, near those of the design before if they lead there."""
        course = self._course
        if course is None or not np.array_equal(course.d, d):
            course = None if course is None else course.moved_to(d)
            self._course = course or Course(self._loops, self.machine.name, d)
        assert self._course is not None
        return self._course

    def compile(self) -> None:
        """Compile what a search calls again and again."""
        for kernel in (self._prologue, self._values, self._slopes):
            kernel.compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def _evaluate(self, kernel: Kernel, point: DesignPoint, phi: Array, **more: Array) -> dict[str, Array]:
        lanes = np.add.outer(self.offsets, np.asarray(phi, dtype=float)).ravel()
        inputs = {"phi": lanes, "d": point.d, "h": point.h, "q": self.coordinates(point.d, lanes)}
        inputs = {name: inputs[name] for name in INPUTS if name in kernel.names}
        try:
            return kernel(**inputs, **more)
        except NotFiniteError as error:
            quantity = self.quantities[error.row % len(self.quantities)]
            angle = np.degrees(lanes[error.lane])
            text = f"{quantity.name} ({quantity.meaning}) is not finite at {angle:.6g} deg"
            raise ComputationError(f"{self.machine.name}: {text}") from None

    def _fold(self, rows: Array, count: int) -> Array:
        """Return rows (m, offsets n) of lanes as rows (m, n): shares added up, others those of the first side."""
        sides = rows.reshape(len(rows), len(self.offsets), count)
        return np.where(np.array(self.shared)[:, None], sides.sum(axis=1), sides[:, 0])

    # --- the functions behind it ---------------------------------------------------------------------

    @cached_property
    def tangent(self) -> ca.Function:
        """(d) -> h, dh: the prologue and its sparse Jacobian in the moved values."""
        machine = self.machine
        if machine.tangent is not None:
            return machine.tangent(machine.moved)
        symbol: Any = ca.SX if machine.prologue.is_a("SXFunction") else ca.MX
        d = symbol.sym("d", len(machine.values))
        h = machine.prologue(d)
        return ca.Function("tangent", [d], [h, ca.jacobian(h, d)[:, list(machine.moved)]], ["d"], ["h", "dh"])

    @cached_property
    def _pattern(self) -> ca.Sparsity:
        return self.tangent.sparsity_out(1)

    @cached_property
    def _dh(self) -> ca.SX:
        return ca.SX.sym("dh", self._pattern.nnz())

    @cached_property
    def _prologue(self) -> Kernel:
        return Kernel(self.tangent)

    @cached_property
    def _prologue_bent(self) -> Kernel:
        machine = self.machine
        symbol: Any = ca.SX if machine.prologue.is_a("SXFunction") else ca.MX
        d, x = symbol.sym("d", len(machine.values)), symbol.sym("x", len(machine.moved))
        weights = symbol.sym("weights", machine.prologue.numel_out(0))
        moved = symbol(d)
        for place, index in enumerate(machine.moved):
            moved[index] = x[place]
        hessian, _ = ca.hessian(ca.dot(weights, machine.prologue(moved)), x)
        inner = ca.Function("bent", [x, d, weights], [ca.densify(hessian)])
        own = inner(d[list(machine.moved)], d, weights)
        return Kernel(ca.Function("prologue_bent", [d, weights], [own], ["d", "weights"], ["hessian"]))

    @cached_property
    def values_function(self) -> ca.Function:
        """(phi, d, h, q) -> rows (m,)."""
        return ca.Function("rows", list(self.machine.symbols), ca.cse([self._graph]), list(INPUTS), ["rows"])

    @cached_property
    def slopes_function(self) -> ca.Function:
        """(phi, d, h, q, dh) -> rows (m,) and their Jacobian in (phi, x), (m (1 + p),), quantity by quantity."""
        phi, d, h, q = self.machine.symbols
        along = ca.jacobian(self._graph, ca.vertcat(phi, d, h))
        size = 1 + d.numel()
        design = along[:, [1 + i for i in self.machine.moved]] + along[:, size:] @ ca.SX(self._pattern, self._dh)
        slopes = ca.densify(ca.vec(ca.horzcat(along[:, 0], design).T))
        outputs = ca.cse([self._graph, slopes])
        return ca.Function("slopes", [phi, d, h, q, self._dh], outputs, [*INPUTS, "dh"], ["rows", "slopes"])

    @cached_property
    def _values(self) -> Kernel:
        return Kernel(self.values_function, lanes=["phi", "q"])

    @cached_property
    def _slopes(self) -> Kernel:
        return Kernel(self.slopes_function, lanes=["phi", "q"])

    @cached_property
    def _derivatives(self) -> Kernel:
        phi, *rest = self.machine.symbols
        outputs = [self._graph, ca.densify(ca.jacobian(self._graph, phi))]
        function = ca.Function("derivatives", [phi, *rest], outputs, list(INPUTS), ["rows", "first"])
        return Kernel(function, lanes=["phi", "q"])

    @cached_property
    def _rates(self) -> Kernel:
        phi, *rest = self.machine.symbols
        first = ca.jacobian(self._graph, phi)
        outputs = ca.cse([ca.densify(row) for row in (self._graph, first, ca.jacobian(first, phi))])
        function = ca.Function("rates", [phi, *rest], outputs, list(INPUTS), ["rows", "first", "second"])
        return Kernel(function, lanes=["phi", "q"])

    @cached_property
    def _bent(self) -> Kernel:
        """(phi, d, h, q, dh, weights) -> Hessian in (phi, x) with h along its tangent, and the slope in h."""
        phi, d, h, q = self.machine.symbols
        step = ca.SX.sym("step", len(self.machine.moved))
        weights = ca.SX.sym("weights", self._graph.numel())
        moved = ca.SX(d)
        for place, index in enumerate(self.machine.moved):
            moved[index] = d[index] + step[place]
        total = ca.dot(weights, self._graph)
        bent = ca.substitute(
            [total], [ca.vertcat(d, h)], [ca.vertcat(moved, h + ca.SX(self._pattern, self._dh) @ step)]
        )
        hessian, _ = ca.hessian(bent[0], ca.vertcat(phi, step))
        none = ca.SX.zeros(step.numel())
        hessian = ca.substitute(ca.densify(ca.vec(hessian)), step, none)
        outputs = ca.cse([hessian, ca.densify(ca.gradient(total, h))])
        names = [*INPUTS, "dh", "weights"]
        function = ca.Function("bending", [phi, d, h, q, self._dh, weights], outputs, names, ["hessian", "along"])
        return Kernel(function, lanes=["phi", "q", "weights"])
