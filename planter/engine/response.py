"""Quantities of a machine along its angle, with exact derivatives in the angle and the design, for
every machine.

Derivatives cross the prologue's cut as inputs: along the design h moves by its tangent `dh`, so
that no lane is differentiated by the coefficients of a series. Coordinates of loops are inputs; the
lane carries their derivatives itself, by Newton steps in its graph.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.engine.loops import KinematicLoops, LoopCoordinates
from planter.engine.machine import LEAST_PIVOT, Machine, Quantity
from planter.errors import ComputationError, NotFiniteError
from planter.kernels import Array, Flags, Integers, Kernel
from planter.numerics.piecewise import ONE_SIDED_OFFSET
from planter.progress import name_step

INPUTS = ("phi", "d", "h", "q")
VALUES = "rows"
"""Name of the output that is no derivative."""
SCANNED = 360
"""Samples of a cycle among which angles are looked for, at least."""
DIFFERENTIATING = "differentiating the quantities of a cycle"


@dataclass(frozen=True)
class DesignPoint:
    """A design: all values d (v,), what it hoists h (k,), and the entries of the tangent of h in
    the design.
    """

    d: Array
    h: Array
    dh: Array


class MachineResponse:
    """Quantities by name (m,), all if none are named, at angles phi (n,) [rad] over designs x (p,),
    in SI units.

    After them stand the derivatives in phi of the quantities that `rates` names, then,
    `with_events`, the functions whose zeros are the machine's breakpoints, then `more`
    quantities, by their graphs in the machine's symbols.
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
            self.quantities += tuple(
                Quantity(f"event {i}", "1", "switching", "") for i in range(events.numel())
            )
            self.shared += (False,) * events.numel()
        if rates:
            quantities, rated = self._graph[: len(chosen)], self._graph[len(chosen) :]
            self._graph = ca.densify(ca.vertcat(quantities, ca.jacobian(rated, machine.symbols[0])))
        if more:
            self._graph = ca.densify(ca.vertcat(self._graph, *(graph for _, graph in more)))
            self.quantities += tuple(quantity for quantity, _ in more)
            self.shared += (False,) * len(more)
        self.offsets = machine.offsets if any(self.shared) else (0.0,)
        self.settles = False
        self.restart()

    def restart(self) -> None:
        """Forget where loops were closed before, near which they are closed else: what follows has
        the same digits.
        """
        self._places: tuple[Array, Array, Array] | None = None
        self._course: LoopCoordinates | None = None

    @property
    def _loops(self) -> KinematicLoops:
        assert self.machine.loops is not None
        return self.machine.loops

    def at(self, x: Array) -> DesignPoint:
        """Return the point of a design x (p,)."""
        return self.at_data(self.machine.build_data(x))

    def at_data(self, d: Array) -> DesignPoint:
        """Return the point of values d (v,)."""
        prologue = self.prologue_kernel(d=d)
        return DesignPoint(
            np.asarray(d, dtype=float), prologue["h"][:, 0], prologue["dh"][self._entries]
        )

    def values(self, point: DesignPoint, phi: Array) -> Array:
        """Return the quantities (m, n).

        Raises ComputationError where loops do not close or one is not finite.
        """
        return self._fold(self._evaluate(self.values_kernel, point, phi)["rows"])

    def slopes(self, point: DesignPoint, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the quantities (m, n) and their Jacobian (m, n, 1 + p) in (phi, x).

        Loose ones are NaN where something is not finite, as at the zero of a root.
        """
        result = self._evaluate(self.slopes_kernel, point, phi, is_loose, dh=point.dh)
        size, lanes = 1 + len(self.machine.moved), result["slopes"].shape[1]
        slopes = result["slopes"].reshape(len(self.quantities), size, lanes)
        return self._fold(result["rows"]), self._fold(slopes).transpose(0, 2, 1)

    def derivatives(
        self, point: DesignPoint, phi: Array, is_loose: bool = False
    ) -> tuple[Array, Array]:
        """Return the quantities and their derivatives in phi, (m, n) each, loose as above."""
        result = self._evaluate(self.derivatives_kernel, point, phi, is_loose)
        return self._fold(result["rows"]), self._fold(result["first"])

    def rates(self, point: DesignPoint, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the first two derivatives of the quantities in phi, (m, n) each, loose as
        above.
        """
        result = self._evaluate(self.rates_kernel, point, phi, is_loose)
        return self._fold(result["first"]), self._fold(result["second"])

    def curvature(self, point: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the sum over quantities and angles of weights (m, n) times Hessians in (phi, x),
        (1 + p, 1 + p).
        """
        try:
            result = self._evaluate(
                self.hessian_kernel, point, phi, dh=point.dh, weights=self._spread(weights)
            )
        except ComputationError:  # a sum does not show which angle has no derivative
            return np.asarray(self.curvatures(point, phi, weights).sum(axis=0))
        hessian: Array = self._unpack(result["packed"])[0]
        hessian[1:, 1:] += self._bend_prologue(point, result["along"][:, 0])
        return hessian

    def curvatures(self, point: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the sum over quantities of weights (m, n) times Hessians in (phi, x), (n, 1 + p, 1
        + p).
        """
        lanes = self._evaluate(
            self.hessians_kernel, point, phi, dh=point.dh, weights=self._spread(weights)
        )
        hessians = self._unpack(self._add_sides(lanes["packed"]))
        for hessian, h_slopes in zip(hessians, self._add_sides(lanes["along"]).T, strict=True):
            hessian[1:, 1:] += self._bend_prologue(point, h_slopes)
        return hessians

    def curvature_along(
        self, point: DesignPoint, phi: Array, weights: Array, angle_slopes: Array
    ) -> Array:
        """Return that sum in the design alone, (p, p), of angles with slopes (n, p), but not for
        their bending.
        """
        lanes = self._evaluate(
            self.hessians_kernel, point, phi, dh=point.dh, weights=self._spread(weights)
        )
        hessians = self._unpack(self._add_sides(lanes["packed"]))
        total = hessians[:, 1:, 1:].sum(axis=0) + self._bend_prologue(
            point, lanes["along"].sum(axis=1)
        )
        return add_moving_angles(total, hessians, angle_slopes)

    def _spread(self, weights: Array) -> Array:
        """Return weights (m, n) of angles as those of lanes; what is not shared has its first side
        alone.
        """
        spread = np.tile(weights, len(self.offsets))
        spread[~np.array(self.shared, dtype=bool), weights.shape[1] :] = 0.0
        return spread

    def _unpack(self, packed: Array) -> Array:
        """Return Hessians (n, 1 + p, 1 + p) of packed columns (k, n)."""
        size = 1 + len(self.machine.moved)
        rows, columns = np.tril_indices(size)
        hessians = np.zeros((packed.shape[1], size, size))
        hessians[:, rows, columns] = hessians[:, columns, rows] = packed.T
        return hessians

    def _bend_prologue(self, point: DesignPoint, h_slopes: Array) -> Array:
        """Return what the prologue's own Hessian adds in x, (p, p), for slopes (k,) in h."""
        return self.prologue_hessian_kernel(d=point.d, weights=h_slopes)["hessian"]

    def check(self, values: Array, phi: Array) -> None:
        """Raise ComputationError where forces (m, n) of all quantities are not determined, or
        friction holds fast.
        """
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
        """Return the coordinates of loops (c, n), near those that were found last, else by a walk
        along the turn.
        """
        if self.machine.loops is None:
            return np.empty((0, len(phi)))
        if self._places is not None and np.array_equal(self._places[0], phi):
            _, last, places = self._places
            if self._loops.are_same(last, d):
                return places
            q = self.machine.loops.find_near(phi, np.repeat(d[:, None], len(phi), axis=1), places)
            if q is not None:
                self._places = phi, d.copy(), q
                return q
        self._places = phi, d.copy(), self._follow(d).evaluate(phi)
        return self._places[2]

    def _follow(self, d: Array) -> LoopCoordinates:
        """Return the coordinates over a turn, near those of the design before if they lead
        there.
        """
        course = self._course
        if course is None or not self._loops.are_same(course.d, d):
            course = None if course is None else course.move_to(d)
            self._course = course or self._loops.course(self.machine.name, d)
        assert self._course is not None
        return self._course

    def list_pieces(self, point: DesignPoint, first: float, last: float) -> list[Array]:
        """Return angles (n,) [rad] from the first to the last one, in pieces on which quantities are
        smooth but for a machine's breakpoints: samples by which a value is looked for.
        """
        return [np.linspace(first, last, 1 + max(self.machine.samples, SCANNED))]

    def list_passages(self, point: DesignPoint) -> list[tuple[str, float]]:
        """Return the names and angles [rad] of the events of a free motion, which has its own."""
        return []

    def compile(self) -> None:
        """Compile the values and their slopes."""
        for kernel in (self.prologue_kernel, self.values_kernel, self.slopes_kernel):
            kernel.compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def _evaluate(
        self, kernel: Kernel, point: DesignPoint, phi: Array, is_loose: bool = False, **more: Array
    ) -> dict[str, Array]:
        lanes = np.add.outer(self.offsets, np.asarray(phi, dtype=float)).ravel()
        inputs = {"phi": lanes, "d": point.d, "h": point.h}
        if self.machine.loops is not None:
            inputs["q"] = self.coordinates(point.d, lanes)
        if is_loose:
            return kernel.masked(**inputs, **more)[0]
        try:
            return kernel(**inputs, **more)
        except NotFiniteError as error:
            outputs, finite = kernel.masked(**inputs, **more)
            sides = self._take_sides(kernel, inputs, more, outputs, finite)
            if sides is not None:
                return sides
            settled = self._settle(outputs) if self.settles else None
            if settled is not None:
                return settled
            raise ComputationError(
                f"{self.machine.name}: {self._locate(error, kernel, lanes)}"
            ) from None

    def _take_sides(
        self,
        kernel: Kernel,
        inputs: Mapping[str, Array],
        more: Mapping[str, Array],
        outputs: Mapping[str, Array],
        finite: Flags,
    ) -> dict[str, Array] | None:
        """Return outputs whose derivatives are those of one side of an angle that has none, None if
        no side has.

        A norm that vanishes at an angle has such derivatives, 0/0 in its graph; each side has its
        own.
        """
        if kernel.work.summed or not np.isfinite(outputs.get(VALUES, 0.0)).all():
            return None
        shifted = {
            **inputs,
            "phi": np.where(finite, inputs["phi"], inputs["phi"] + ONE_SIDED_OFFSET),
        }
        if self.machine.loops is not None:
            shifted["q"] = self._follow(inputs["d"]).evaluate(shifted["phi"])
        sides, has_sides = kernel.masked(**shifted, **more)
        if not has_sides.all():
            return None
        return {
            name: rows if name == VALUES else np.where(finite, rows, sides[name])
            for name, rows in outputs.items()
        }

    def _locate(self, error: NotFiniteError, kernel: Kernel, lanes: Array) -> str:
        """Return which quantity, or which one's derivative, is not finite at which angle."""
        angle = f"is not finite at {np.degrees(lanes[error.lane]):.6g} deg"
        rows, remainder = divmod(kernel.function.size1_out(error.output), len(self.quantities))
        if remainder or "weights" in kernel.names:
            return f"a derivative {angle}"
        quantity = self.quantities[error.row // rows]
        name = f"{quantity.name} ({quantity.meaning})"
        return f"{name} {angle}" if error.output == VALUES else f"the derivative of {name} {angle}"

    @staticmethod
    def _settle(outputs: dict[str, Array]) -> dict[str, Array] | None:
        """Return outputs with derivatives that are 0/0 set to 0, None if more is not finite.

        Such are those of a root of a part that is 0: the part is level there, and so is its root.
        """
        settled = {
            name: rows if name == "rows" else np.where(np.isnan(rows), 0.0, rows)
            for name, rows in outputs.items()
        }
        return settled if all(np.isfinite(rows).all() for rows in settled.values()) else None

    def _fold(self, rows: Array) -> Array:
        """Return rows (m, ..., sides n) of lanes as those of angles: shares added up, others of the
        first side.
        """
        if len(self.offsets) == 1:
            return rows
        if all(self.shared):
            return self._add_sides(rows)
        shared = np.array(self.shared).reshape(-1, *[1] * (rows.ndim - 1))
        return np.where(
            shared, self._add_sides(rows), rows[..., : rows.shape[-1] // len(self.offsets)]
        )

    def _add_sides(self, lanes: Array) -> Array:
        """Return rows (..., sides n) of lanes added up over the sides, (..., n)."""
        sides = len(self.offsets)
        total: Array = lanes.reshape(*lanes.shape[:-1], sides, lanes.shape[-1] // sides).sum(
            axis=-2
        )
        return total

    # --- the functions behind it
    # ---------------------------------------------------------------------

    @cached_property
    def tangent(self) -> ca.Function:
        """(d) -> h, dh: the prologue and its sparse Jacobian in the moved values."""
        machine = self.machine
        if machine.tangent is not None:
            return machine.tangent(machine.moved)
        d = machine.create_symbol("d", len(machine.values))
        h = machine.prologue(d)
        return ca.Function(
            "tangent", [d], [h, ca.jacobian(h, d)[:, list(machine.moved)]], ["d"], ["h", "dh"]
        )

    @cached_property
    def _pattern(self) -> ca.Sparsity:
        return self.tangent.sparsity_out(1)

    @cached_property
    def _entries(self) -> tuple[Integers, Integers]:
        """Rows and columns of the tangent's entries."""
        rows, columns = np.array(self._pattern.get_triplet(), dtype=np.int64)
        return rows, columns

    @cached_property
    def _dh(self) -> ca.SX:
        return ca.SX.sym("dh", self._pattern.nnz())

    @cached_property
    def hoisting_kernel(self) -> Kernel:
        """(d) -> h: the prologue alone."""
        return Kernel(self.machine.prologue)

    @cached_property
    def prologue_kernel(self) -> Kernel:
        return Kernel(self.tangent)

    @cached_property
    @name_step(DIFFERENTIATING)
    def prologue_hessian_kernel(self) -> Kernel:
        machine = self.machine
        sizes = {
            "d": len(machine.values),
            "x": len(machine.moved),
            "weights": machine.prologue.numel_out(0),
        }
        d, x, weights = (machine.create_symbol(name, size) for name, size in sizes.items())
        moved = type(d)(d)
        for place, index in enumerate(machine.moved):
            moved[index] = x[place]
        hessian, _ = ca.hessian(ca.dot(weights, machine.prologue(moved)), x)
        inner = ca.Function("bent", [x, d, weights], [ca.densify(hessian)])
        hessian = inner(d[list(machine.moved)], d, weights)
        return Kernel(
            ca.Function("prologue_bent", [d, weights], [hessian], ["d", "weights"], ["hessian"])
        )

    @cached_property
    def values_function(self) -> ca.Function:
        """(phi, d, h, q) -> rows (m,)."""
        return ca.Function(
            "rows", list(self.machine.symbols), ca.cse([self._graph]), list(INPUTS), ["rows"]
        )

    @cached_property
    @name_step(DIFFERENTIATING)
    def slopes_function(self) -> ca.Function:
        """(phi, d, h, q, dh) -> rows (m,) and their Jacobian in (phi, x), (m (1 + p),), quantity by
        quantity.
        """
        phi, d, h, q = self.machine.symbols
        jacobian = ca.jacobian(self._graph, ca.vertcat(phi, d, h))
        size = 1 + d.numel()
        design = jacobian[:, [1 + i for i in self.machine.moved]] + jacobian[:, size:] @ ca.SX(
            self._pattern, self._dh
        )
        slopes = ca.densify(ca.vec(ca.horzcat(jacobian[:, 0], design).T))
        outputs = ca.cse([self._graph, slopes])
        return ca.Function(
            "slopes", [phi, d, h, q, self._dh], outputs, [*INPUTS, "dh"], ["rows", "slopes"]
        )

    def _build(
        self, function: ca.Function, lanes: Sequence[str] = (), summed: bool = False
    ) -> Kernel:
        """Return a kernel whose lanes are the angles; without q if there are no loops."""
        lanes = ["phi", "q", *lanes]
        if self.machine.loops is None:
            inputs, names = function.sx_in(), function.name_in()
            lanes.remove("q")
            outputs, place = function.call(inputs), names.index("q")
            del inputs[place], names[place]
            function = ca.Function(function.name(), inputs, outputs, names, function.name_out())
        return Kernel(function, lanes, summed)

    @cached_property
    def values_kernel(self) -> Kernel:
        return self._build(self.values_function)

    @cached_property
    def slopes_kernel(self) -> Kernel:
        return self._build(self.slopes_function)

    @cached_property
    @name_step(DIFFERENTIATING)
    def derivatives_kernel(self) -> Kernel:
        phi, *rest = self.machine.symbols
        outputs = [self._graph, _differentiate(self._graph, phi)]
        function = ca.Function(
            "derivatives", [phi, *rest], outputs, list(INPUTS), ["rows", "first"]
        )
        return self._build(function)

    @cached_property
    @name_step(DIFFERENTIATING)
    def rates_kernel(self) -> Kernel:
        phi, *rest = self.machine.symbols
        first = _differentiate(self._graph, phi)
        outputs = ca.cse([first, _differentiate(first, phi)])
        function = ca.Function("rates", [phi, *rest], outputs, list(INPUTS), ["first", "second"])
        return self._build(function)

    @cached_property
    @name_step(DIFFERENTIATING)
    def hessian_kernel(self) -> Kernel:
        """(phi, d, h, q, dh, weights) -> what `hessians_kernel` has, added up over the lanes."""
        return self._build(self._build_hessian("bending"), ["weights"], summed=True)

    @cached_property
    @name_step(DIFFERENTIATING)
    def hessians_kernel(self) -> Kernel:
        """(phi, d, h, q, dh, weights) -> weighted Hessian in (phi, x), h along its tangent, and
        slope in h.

        The Hessian is packed: the rows of its lower triangle, one after another.
        """
        return self._build(self._build_hessian("bendings"), ["weights"])

    def _build_hessian(self, name: str) -> ca.Function:
        phi, d, h, q = self.machine.symbols
        step = ca.SX.sym("step", len(self.machine.moved))
        weights = ca.SX.sym("weights", self._graph.numel())
        moved = ca.SX(d)
        for place, index in enumerate(self.machine.moved):
            moved[index] = d[index] + step[place]
        total = ca.dot(weights, self._graph)
        bent = ca.substitute(
            [total],
            [ca.vertcat(d, h)],
            [ca.vertcat(moved, h + ca.SX(self._pattern, self._dh) @ step)],
        )
        hessian, _ = ca.hessian(bent[0], ca.vertcat(phi, step))
        packed = ca.vertcat(*(hessian[i, j] for i in range(hessian.size1()) for j in range(i + 1)))
        packed = ca.substitute(ca.densify(packed), step, ca.SX.zeros(step.numel()))
        outputs = ca.cse([packed, ca.densify(ca.gradient(total, h))])
        names = [*INPUTS, "dh", "weights"]
        return ca.Function(
            name, [phi, d, h, q, self._dh, weights], outputs, names, ["packed", "along"]
        )


def add_moving_angles(total: Array, hessians: Array, angle_slopes: Array) -> Array:
    """Return a sum of Hessians in the design (p, p) with what angles of slopes (n, p) add, from
    Hessians (n, 1 + p, 1 + p) in angle and design.
    """
    mixed = hessians[:, 1:, 0].T @ angle_slopes
    bent: Array = total + mixed + mixed.T + angle_slopes.T @ (hessians[:, 0, :1] * angle_slopes)
    return bent


def open_response(
    machine: Machine,
    names: Sequence[str] | None = None,
    with_events: bool = False,
    more: Sequence[tuple[Quantity, ca.SX]] = (),
) -> MachineResponse:
    """Return the response of a machine, driven or free, as `MachineResponse`."""
    build = MachineResponse if machine.motion is None else machine.motion.respond
    response: MachineResponse = build(machine, names, with_events=with_events, more=more)
    return response


def _differentiate(rows: ca.SX, angle: ca.SX) -> ca.SX:
    """Return the derivative of rows (m, 1) in an angle; of one row in reverse mode, which takes
    fewer operations.
    """
    return ca.densify(ca.gradient(rows, angle) if rows.numel() == 1 else ca.jacobian(rows, angle))
