"""Cycles of many machines of one build: values in rows; loops are closed by all of them together, a
machine a lane.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.loops import TURN, VECTOR
from planter.engine.machine import LEAST_PIVOT, Machine
from planter.engine.response import INPUTS, MachineResponse
from planter.kernels import Array, Flags, Integers, Kernel
from planter.kernels.kernel import StackedKernel
from planter.numerics.piecewise import ONE_SIDED_OFFSET

MEMORY = 1 << 22
"""Numbers that the coordinates of a walk, or the samples of a block, may take."""
MOST_WALKING, LEAST_WALKING = 1024, 64
"""Machines that walk along their loops together."""
MOST_ROWS = 64
"""Machines of a block."""
COMPARED = 24
"""Samples at which a cycle is compared with the next one."""
SHARE, FLOOR = 1e-7, 1e-12
"""A quantity repeats if it changes by less than this share of the largest value in its unit, or
this much in SI.

The largest is that of all results, at the samples that are compared.
"""


@dataclass(frozen=True)
class SampleBlock:
    """Quantities of some machines: samples (m, n, rows) in SI, and which quantities (m, rows)
    repeat.

    The samples are those of a turn, or of a period, of which there are whole ones in a turn. `rows`
    (rows,) are the machines' rows; those that `failed` (rows,) have no cycle. `data` (v, rows) are
    their values, `hoisted` (k, rows) what no angle changes, `places` (rows, c, steps) the
    coordinates of their loops.
    """

    samples: Array
    repeats: Flags
    rows: Integers
    failed: Flags
    data: Array
    hoisted: Array
    places: Array


@dataclass(frozen=True)
class ClosedRows:
    """Machines with values d (r, v): coordinates of their loops (c, steps, lanes), and what they
    gain in a turn.

    `alive` (r,) are the machines whose loops close everywhere; further lanes fill up a vector.
    """

    d: Array
    places: Array
    gained: Array
    alive: Flags

    @cached_property
    def data(self) -> Array:
        """Values in lanes (v, lanes)."""
        return fill_lanes(self.d)


class MachineRows:
    """Quantities by name over rows of values d (r, v) in SI, at `samples` angles of a turn.

    Rows do not influence each other: the digits of one do not depend on the others. Of equal sides
    one is evaluated, at all angles `steps` where one of them stands.
    """

    def __init__(
        self,
        machine: Machine,
        names: Sequence[str],
        samples: int | None = None,
        compared: bool = True,
    ) -> None:
        """`compared` says whether each cycle is compared with the next, without which nothing
        counts as repeating.

        Machines with equal sides repeat: their totals have a period.
        """
        self.machine = machine
        self.quantities = tuple(machine.find_quantity(name) for name in names)
        self.names = tuple(quantity.name for quantity in self.quantities)
        self._graph, self.shared = machine.rows(self.names)
        self.sides = len(machine.offsets) if any(self.shared) else 1
        self._compared, self._repeating = compared, compared and len(machine.offsets) > 1
        self.guards = machine.guards
        self._slopes: dict[int, StackedKernel] = {}
        self._is_compiled = False
        count = machine.samples if samples is None else samples
        self.angles = machine.list_angles(count)
        self.stride = 1 if count % self.sides == 0 else self.sides
        self.steps = machine.list_angles(count * self.stride)

    @property
    def is_periodic(self) -> bool:
        """Whether samples are those of a period, not of a turn: all quantities are totals of equal
        sides.
        """
        return self.sides > 1 and all(self.shared) and self.stride == 1

    def compile(self) -> None:
        """Compile what `evaluate` calls."""
        if self._is_compiled:
            return
        self._is_compiled = True
        self.values.compile()
        self.hoist.compile()
        if self._compared and not self._repeating:
            self._compare[0].compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def compile_slopes(self, count: int) -> None:
        """Compile what `gradients` calls for the first `count` quantities."""
        self.find_slopes(count).compile()
        if self.tangents.way == "casadi-vm":
            self.tangents.compile()

    def evaluate(
        self, d: Array, reduce: Callable[[SampleBlock], Array], threads: int = 1, slopes: int = 0
    ) -> Array:
        """Return what `reduce` makes of blocks, (outputs, rows) each, as (r, outputs); NaN in rows
        without a cycle.

        It takes `slopes` numbers for each sample.
        """
        self.compile()

        def run(part: Array) -> Array:
            with np.errstate(all="ignore"):  # of rows that failed
                blocks = self.blocks(part, slopes)
                results = [
                    (block.rows, np.where(block.failed, np.nan, reduce(block)).T)
                    for block in blocks
                ]
            values = np.full((len(part), results[0][1].shape[1]), np.nan)
            for rows, reduced in results:
                values[rows] = reduced
            return values

        return self.split(d, run, threads)

    def split(self, d: Array, run: Callable[[Array], Array], threads: int) -> Array:
        """Return what a function makes of parts of rows d (r, v), one below the other.

        The parts do not depend on the threads, since the last digit of a row may depend on its
        neighbours.
        """
        coordinates = self.machine.loops.size if self.machine.loops else 1
        size = int(np.clip(MEMORY // (coordinates * len(self.steps)), LEAST_WALKING, MOST_WALKING))
        parts = [d[start : start + size] for start in range(0, len(d), size)]
        if threads == 1:
            return np.vstack([run(part) for part in parts])
        with ThreadPoolExecutor(threads) as pool:
            return np.vstack(list(pool.map(run, parts)))

    def close(self, d: Array) -> ClosedRows:
        """Return machines with values d (r, v) with their loops closed at all steps."""
        if self.machine.loops is None:
            places, gained = np.empty((0, len(self.steps), len(d))), np.empty((0, len(d)))
            return ClosedRows(d, places, gained, np.ones(len(d), dtype=bool))
        walk = self.machine.loops.walk(fill_lanes(d), np.append(self.steps, self.machine.turn))
        gained, alive = walk.gains()
        return ClosedRows(d, walk.places[:, :-1], gained, alive[: len(d)])

    def blocks(self, d: Array, slopes: int = 0) -> Iterator[SampleBlock]:
        """Yield the samples of machines with values d (r, v): those whose loops close, but one at
        least.

        Blocks are so small that there is memory for `slopes` of each sample.
        """
        closed = self.close(d)
        data, places, gained, alive = closed.data, closed.places, closed.gained, closed.alive
        rows = np.flatnonzero(alive) if alive.any() else np.arange(1)
        hoisted, finite = self.hoist.masked(d=data)
        size = int(
            np.clip(MEMORY // (len(self.names) * len(self.steps) * (1 + slopes)), 1, MOST_ROWS)
        )
        for start in range(0, len(rows), size):
            part = rows[start : start + size]
            yield self._block(
                part,
                data[:, part],
                np.where(finite[part], hoisted["h"][:, part], 0.0),
                np.ascontiguousarray(places[:, :, part].transpose(2, 0, 1)),
                gained[:, part],
                alive[part] & finite[part],
            )

    def _block(
        self, rows: Integers, d: Array, h: Array, places: Array, gained: Array, finite: Flags
    ) -> SampleBlock:
        """Return the samples of rows; those that are not finite have failed before."""
        values = self.values(phi=self.steps[None], d=d.T, h=h.T, q=places)["rows"]
        samples, guards = self._fold(values[:, : len(self.names)]), values[:, len(self.names) :]
        finite = (
            finite & np.isfinite(samples).all(axis=(0, 1)) & np.isfinite(guards).all(axis=(1, 2))
        )
        for row, guard in zip(guards.transpose(1, 0, 2), self.guards, strict=True):
            finite &= (row >= LEAST_PIVOT if guard.role == "pivot" else row != 0).all(axis=1)
        return SampleBlock(
            samples,
            self._repeats(d, h, places[:, :, self._chosen], gained),
            rows,
            ~finite,
            d,
            h,
            places,
        )

    def _fold(self, values: Array) -> Array:
        """Return values (rows, m, steps) as samples (m, n, rows): shares of all sides added up.

        If they are periodic, samples are those of one period.
        """
        if self.sides > 1:
            sides = values.reshape(*values.shape[:2], self.sides, -1)
            if self.is_periodic:
                values = sides.sum(axis=2)
            else:
                shared = np.array(self.shared)
                sides[:, shared] = sides[:, shared].sum(axis=2, keepdims=True)
        return values[:, :, :: self.stride].transpose(1, 2, 0)

    def gradients(self, block: SampleBlock, places: Sequence[int], weights: Array) -> Array:
        """Return sums over all angles of weights (k, n, rows) times slopes in the moved values, (k,
        p, rows) in SI.

        The k-th sum is of the quantity at the k-th of `places` in `names`.
        """
        count, p = max(places) + 1, len(self.machine.moved)
        tangents, _ = self.tangents.masked(d=block.data)
        inputs = {
            "d": block.data.T,
            "h": block.hoisted.T,
            "q": block.places,
            "dh": tangents["dh"].T,
        }
        kernel = self.find_slopes(count)
        slopes = kernel(phi=self.steps[None], **inputs)["slopes"]
        singular = np.asarray(~np.isfinite(slopes).all(axis=1))
        # A norm that vanishes has the slopes of a side; the lane closes loops there by its own steps.
        if singular.any():
            shifted = self.steps + ONE_SIDED_OFFSET * singular.any(axis=0)
            slopes = np.where(
                singular[:, None], kernel(phi=shifted[None], **inputs)["slopes"], slopes
            )
        slopes = slopes.reshape(len(block.rows), count, p, len(self.steps))
        return np.asarray(
            np.einsum("rkpn,rkn->kpr", slopes[:, list(places)], self._spread(weights, places))
        )

    def _spread(self, weights: Array, places: Sequence[int]) -> Array:
        """Return weights (k, n, rows) of samples as those (rows, k, steps) of a side."""
        if self.is_periodic:
            return np.tile(weights.transpose(2, 0, 1), self.sides)
        spread = np.zeros((weights.shape[2], len(weights), len(self.steps)))
        spread[:, :, :: self.stride] = weights.transpose(2, 0, 1)
        if self.sides > 1:
            sides = spread.reshape(*spread.shape[:2], self.sides, -1)
            shared = np.array(self.shared)[list(places)]
            sides[:, shared] = sides[:, shared].sum(axis=2, keepdims=True)
        return spread

    def find_repeats(self, closed: ClosedRows, rows: Integers) -> Flags:
        """Return which quantities (m, rows) of some machines are a turn later what they were."""
        if self._repeating or not self._compared:
            return np.full((len(self.names), len(rows)), self._repeating)
        self.hoist.compile()
        self._compare[0].compile()
        hoisted, _ = self.hoist.masked(d=closed.data)
        places = closed.places[:, self._chosen]
        flags = np.empty((len(self.names), len(rows)), dtype=bool)
        for start in range(0, len(rows), MOST_ROWS):
            part = rows[start : start + MOST_ROWS]
            flags[:, start : start + MOST_ROWS] = self._repeats(
                closed.data[:, part],
                hoisted["h"][:, part],
                places[:, :, part].transpose(2, 0, 1),
                closed.gained[:, part],
            )
        return flags

    def _repeats(self, d: Array, h: Array, places: Array, gained: Array) -> Flags:
        """Return which quantities (m, rows) are a turn later what they were; angles may gain whole
        turns.

        Coordinates `places` (rows, c, k) of loops are those at the samples that are compared.
        """
        count = d.shape[1]
        if self._repeating or not self._compared:
            return np.full((len(self.names), count), self._repeating)
        chosen = self._chosen
        compare, same_unit = self._compare
        now, later = (
            compare(phi=(self.steps[chosen] + turn)[None], d=d.T, h=h.T, q=q)["rows"]
            for turn, q in (
                (0.0, places),
                (self.machine.turn, places + gained.T[:, :, None]),
            )
        )
        change = (later - now)[:, : len(self.names)]
        angular = np.array([quantity.unit == "rad" for quantity in self.quantities])[:, None]
        changes = np.abs(change - np.where(angular, TURN * np.round(change / TURN), 0.0)).max(
            axis=2
        )
        largest = np.abs(now).max(axis=2)
        sizes = [
            np.ones(count) if unit is None else largest[:, unit].max(axis=1) for unit in same_unit
        ]
        return np.asarray(np.maximum(SHARE * np.array(sizes), FLOOR) >= changes.T)

    @cached_property
    def _chosen(self) -> list[int]:
        count = min(COMPARED, len(self.steps))
        return [
            int(index)
            for index in np.unique(np.linspace(0, len(self.steps) - 1, count).astype(int))
        ]

    @cached_property
    def graph(self) -> ca.SX:
        """The graphs of the quantities, then of the guards."""
        guards, _ = self.machine.rows([quantity.name for quantity in self.guards])
        return ca.densify(ca.vertcat(self._graph, guards))

    @cached_property
    def values(self) -> StackedKernel:
        """(phi, d, h, q) -> quantities of a side, then guards."""
        return self._stack("sampled", self.graph)

    @cached_property
    def _compare(self) -> tuple[StackedKernel, list[list[int] | None]]:
        """(phi, d, h, q) -> quantities, then all results; and which of these have the unit of each
        quantity.
        """
        results, _ = self.machine.rows([quantity.name for quantity in self.machine.results])
        first = len(self.names)
        same_unit = [
            None
            if quantity.unit == "rad"
            else [
                first + i
                for i, other in enumerate(self.machine.results)
                if other.unit == quantity.unit
            ]
            for quantity in self.quantities
        ]
        return self._stack("compared", ca.vertcat(self._graph, results)), same_unit

    def _stack(self, name: str, rows: ca.SX) -> StackedKernel:
        function = ca.Function(
            name, list(self.machine.symbols), ca.cse([ca.densify(rows)]), list(INPUTS), ["rows"]
        )
        return StackedKernel(function, ["phi", "q"], ["d", "h", "q"])

    def find_slopes(self, count: int) -> StackedKernel:
        """Return (phi, d, h, q, dh) -> what `values` has, and the slopes of its first `count` rows.

        Those are the slopes in the moved values, quantity by quantity; dh are the entries of the
        tangent of h.
        """
        if count not in self._slopes:
            _, d, h, _ = self.machine.symbols
            pattern = self._tangent.sparsity_out(1)
            dh = ca.SX.sym("dh", pattern.nnz())
            jacobian = ca.jacobian(self._graph[:count], ca.vertcat(d, h))
            slopes = jacobian[:, list(self.machine.moved)] + jacobian[:, d.numel() :] @ ca.SX(
                pattern, dh
            )
            outputs = ca.cse([self.graph, ca.densify(ca.vec(slopes.T))])
            names, results = [*INPUTS, "dh"], ["rows", "slopes"]
            function = ca.Function("sloped", [*self.machine.symbols, dh], outputs, names, results)
            self._slopes[count] = StackedKernel(function, ["phi", "q"], ["d", "h", "q", "dh"])
        return self._slopes[count]

    @cached_property
    def _tangent(self) -> ca.Function:
        return MachineResponse(self.machine, self.names).tangent

    @cached_property
    def tangents(self) -> Kernel:
        """(d) -> h and the entries of its tangent in the moved values."""
        symbol: Any = ca.SX if self._tangent.is_a("SXFunction") else ca.MX
        d = symbol.sym("d", len(self.machine.values))
        h, dh = self._tangent(d)
        outputs = [ca.densify(h), ca.vec(dh.nz[:])]  # of a single hoisted value, nz[:] is a row
        return Kernel(ca.Function("tangents", [d], outputs, ["d"], ["h", "dh"]), lanes=["d"])

    @cached_property
    def hoist(self) -> Kernel:
        """(d) -> h, what no angle changes."""
        d = self.machine.create_symbol("d", len(self.machine.values))
        return Kernel(
            ca.Function("hoist", [d], [ca.densify(self.machine.prologue(d))], ["d"], ["h"]),
            lanes=["d"],
        )


def fill_lanes(d: Array) -> Array:
    """Return rows d (r, v) as lanes (v, lanes): full vectors, the last row repeated, so that digits
    are the same.
    """
    lanes = np.minimum(np.arange(len(d) + -len(d) % VECTOR), len(d) - 1)
    return np.ascontiguousarray(np.asarray(d, dtype=float)[lanes].T)
