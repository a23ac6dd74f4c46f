"""Cycles of many machines of one build: values in rows; loops are closed by all of them together, a machine a lane."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.lanes import VECTOR
from planter.engine.loops import TURN
from planter.engine.machine import LEAST_PIVOT, Machine
from planter.engine.response import INPUTS, Response
from planter.kernels import Array, Kernel
from planter.kernels.stacked import Stacked
from planter.numerics.arrays import Flags, Integers

MEMORY = 1 << 22
"""Numbers that the coordinates of a walk, or the samples of a block, may take."""
MOST_WALKING, LEAST_WALKING = 2048, 64
"""Machines that walk along their loops together."""
MOST_ROWS = 64
"""Machines of a block."""
COMPARED = 24
"""Samples at which a cycle is compared with the next one."""
SHARE, FLOOR = 1e-7, 1e-12
"""A quantity repeats if it changes by less than this share of the largest value in its unit, or this much in SI.

The largest is that of all results, at the samples that are compared.
"""


@dataclass(frozen=True)
class Block:
    """Quantities of some machines: samples (m, n, rows) in SI, and which quantities (m, rows) repeat.

    The samples are those of a turn, or of a period, of which there are whole ones in a turn.
    `rows` (rows,) are the machines' rows; those that `failed` (rows,) have no cycle. `data` (v, rows) are their values,
    `hoisted` (k, rows) what no angle changes, `places` (rows, c, steps) the coordinates of their loops.
    """

    samples: Array
    repeats: Flags
    rows: Integers
    failed: Flags
    data: Array
    hoisted: Array
    places: Array


class Rows:
    """Quantities by name over rows of values d (r, v) in SI, at `samples` angles of a turn.

    Rows do not influence each other: one has the same digits whatever stands beside it. Of equal sides one is
    evaluated, at all angles `steps` where one of them stands.
    """

    def __init__(
        self, machine: Machine, names: Sequence[str], samples: int | None = None, compared: bool = True
    ) -> None:
        """`compared` says whether each cycle is compared with the next, without which nothing counts as repeating.

        Machines with equal sides repeat: their totals have a period.
        """
        self.machine = machine
        self.quantities = tuple(machine.find_quantity(name) for name in names)
        self.names = tuple(quantity.name for quantity in self.quantities)
        self._graph, self._shared = machine.rows(self.names)
        self._sides = len(machine.offsets) if any(self._shared) else 1
        self._compared, self._repeating = compared, compared and len(machine.offsets) > 1
        self._guards = [quantity for quantity in machine.quantities if quantity.role in ("pivot", "states")]
        self._sums: dict[tuple[int, ...], tuple[Stacked, ca.Sparsity]] = {}
        self._is_compiled = False
        count = machine.samples if samples is None else samples
        self.angles = machine.turn * np.arange(count) / count
        self._stride = 1 if count % self._sides == 0 else self._sides
        self.steps = machine.turn * np.arange(count * self._stride) / (count * self._stride)

    @property
    def is_periodic(self) -> bool:
        """Whether samples are those of a period, not of a turn: all quantities are totals of equal sides."""
        return self._sides > 1 and all(self._shared) and self._stride == 1

    def compile(self) -> None:
        """Compile what `evaluate` calls."""
        if self._is_compiled:
            return
        self._is_compiled = True
        self._values.compile()
        self._hoist.compile()
        if self._compared and not self._repeating:
            self._compare[0].compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def compile_slopes(self, places: Sequence[int]) -> None:
        """Compile what `gradients` calls."""
        self._sum_slopes(tuple(places))[0].compile()
        if self._tangents.way == "casadi-vm":
            self._tangents.compile()

    def evaluate(self, d: Array, reduce: Callable[[Block], Array], threads: int = 1) -> Array:
        """Return what `reduce` makes of blocks, (outputs, rows) each, as (r, outputs); NaN in rows without a cycle."""
        self.compile()
        coordinates = self.machine.loops.size if self.machine.loops else 1
        size = int(np.clip(MEMORY // (coordinates * len(self.steps)), LEAST_WALKING, MOST_WALKING))
        parts = [d[start : start + size] for start in range(0, len(d), size)]

        def run(part: Array) -> Array:
            with np.errstate(all="ignore"):  # of rows that failed
                results = [(block.rows, np.where(block.failed, np.nan, reduce(block)).T) for block in self.blocks(part)]
            values = np.full((len(part), results[0][1].shape[1]), np.nan)
            for rows, reduced in results:
                values[rows] = reduced
            return values

        if threads == 1:
            return np.vstack([run(part) for part in parts])
        with ThreadPoolExecutor(threads) as pool:
            return np.vstack(list(pool.map(run, parts)))

    def blocks(self, d: Array) -> Iterator[Block]:
        """Yield the samples of machines with values d (r, v); none of those whose loops do not close, but one at least.

        Lanes of a walk are full vectors, the last machine repeated, so that all of them have the same digits.
        """
        lanes = np.minimum(np.arange(len(d) + -len(d) % VECTOR), len(d) - 1)
        data = np.ascontiguousarray(np.asarray(d, dtype=float)[lanes].T)
        rows, gained = np.arange(len(d)), np.empty((0, len(d)))
        places, alive = np.empty((0, len(self.steps), len(d))), np.ones(len(d), dtype=bool)
        if self.machine.loops:
            walk = self.machine.loops.walk(data, np.append(self.steps, self.machine.turn))
            places, (gained, closed) = walk.places[:, :-1], walk.gains()
            alive = closed[: len(d)]
            rows = np.flatnonzero(alive) if alive.any() else rows[:1]
        hoisted, finite = self._hoist.masked(d=data)
        size = int(np.clip(MEMORY // (len(self.names) * len(self.steps)), 1, MOST_ROWS))
        for start in range(0, len(rows), size):
            part = rows[start : start + size]
            yield self._block(
                part, data[:, part], np.where(finite[part], hoisted["h"][:, part], 0.0),
                np.ascontiguousarray(places[:, :, part].transpose(2, 0, 1)), gained[:, part], alive[part] & finite[part]
            )  # fmt: skip

    def _block(self, rows: Integers, d: Array, h: Array, places: Array, gained: Array, finite: Flags) -> Block:
        """Return the samples of rows; those that are not finite have failed before."""
        values = self._values(phi=self.steps[None], d=d.T, h=h.T, q=places)["rows"]
        samples, guards = self._fold(values[:, : len(self.names)]), values[:, len(self.names) :]
        finite = finite & np.isfinite(samples).all(axis=(0, 1)) & np.isfinite(guards).all(axis=(1, 2))
        for row, guard in zip(guards.transpose(1, 0, 2), self._guards, strict=True):
            finite &= (row >= LEAST_PIVOT if guard.role == "pivot" else row != 0).all(axis=1)
        return Block(samples, self._repeats(d, h, places, gained), rows, ~finite, d, h, places)

    def _fold(self, values: Array) -> Array:
        """Return values (rows, m, steps) as samples (m, n, rows): shares of all sides added up.

        If they are periodic, samples are those of one period.
        """
        if self._sides > 1:
            sides = values.reshape(*values.shape[:2], self._sides, -1)
            if self.is_periodic:
                values = sides.sum(axis=2)
            else:
                shared = np.array(self._shared)
                sides[:, shared] = sides[:, shared].sum(axis=2, keepdims=True)
        return values[:, :, :: self._stride].transpose(1, 2, 0)

    def gradients(self, block: Block, places: Sequence[int], weights: Array) -> Array:
        """Return sums over all angles of weights (k, n, rows) times slopes in the moved values, (k, p, rows) in SI.

        The k-th sum is of the quantity at the k-th of `places` in `names`.
        """
        machine, count = self.machine, block.data.shape[1]
        function, pattern = self._sum_slopes(tuple(places))
        sums = function(
            phi=self.steps[None], d=block.data.T, h=block.hoisted.T, q=block.places,
            weights=self._spread(weights, places),
        )["sums"]  # fmt: skip
        size, p = len(places), len(machine.moved)
        slopes = np.zeros((size, p + machine.prologue.numel_out(0), count))
        slopes[pattern.get_triplet()] = sums.T
        tangents, _ = self._tangents.masked(d=block.data)
        dh = tangents["dh"].reshape(p, -1, count)
        return np.asarray(slopes[:, :p] + np.einsum("khl,phl->kpl", slopes[:, p:], dh))

    def _spread(self, weights: Array, places: Sequence[int]) -> Array:
        """Return weights (k, n, rows) of samples as those (rows, k, steps) of a side."""
        if self.is_periodic:
            return np.tile(weights.transpose(2, 0, 1), self._sides)
        spread = np.zeros((weights.shape[2], len(weights), len(self.steps)))
        spread[:, :, :: self._stride] = weights.transpose(2, 0, 1)
        if self._sides > 1:
            sides = spread.reshape(*spread.shape[:2], self._sides, -1)
            shared = np.array(self._shared)[list(places)]
            sides[:, shared] = sides[:, shared].sum(axis=2, keepdims=True)
        return spread

    def _repeats(self, d: Array, h: Array, places: Array, gained: Array) -> Flags:
        """Return which quantities (m, rows) are a turn later what they were; angles may gain whole turns."""
        count = d.shape[1]
        if self._repeating or not self._compared:
            return np.full((len(self.names), count), self._repeating)
        chosen = self._chosen
        compare, near = self._compare
        now, later = (
            compare(phi=(self.steps[chosen] + turn)[None], d=d.T, h=h.T, q=q)["rows"]
            for turn, q in (
                (0.0, places[:, :, chosen]),
                (self.machine.turn, places[:, :, chosen] + gained.T[:, :, None]),
            )
        )
        change = (later - now)[:, : len(self.names)]
        angular = np.array([quantity.unit == "rad" for quantity in self.quantities])[:, None]
        changes = np.abs(change - np.where(angular, TURN * np.round(change / TURN), 0.0)).max(axis=2)
        largest = np.abs(now).max(axis=2)
        sizes = [np.ones(count) if unit is None else largest[:, unit].max(axis=1) for unit in near]
        return np.asarray(np.maximum(SHARE * np.array(sizes), FLOOR) >= changes.T)

    @cached_property
    def _chosen(self) -> list[int]:
        count = min(COMPARED, len(self.steps))
        return [int(index) for index in np.unique(np.linspace(0, len(self.steps) - 1, count).astype(int))]

    @cached_property
    def _values(self) -> Stacked:
        """(phi, d, h, q) -> quantities of a side, then guards."""
        guards, _ = self.machine.rows([quantity.name for quantity in self._guards])
        return self._stack("sampled", ca.vertcat(self._graph, guards))

    @cached_property
    def _compare(self) -> tuple[Stacked, list[list[int] | None]]:
        """(phi, d, h, q) -> quantities, then all results; and which of these have the unit of each quantity."""
        results, _ = self.machine.rows([quantity.name for quantity in self.machine.results])
        first = len(self.names)
        near = [
            None if quantity.unit == "rad" else
            [first + i for i, other in enumerate(self.machine.results) if other.unit == quantity.unit]
            for quantity in self.quantities
        ]  # fmt: skip
        return self._stack("compared", ca.vertcat(self._graph, results)), near

    def _stack(self, name: str, rows: ca.SX) -> Stacked:
        function = ca.Function(name, list(self.machine.symbols), ca.cse([ca.densify(rows)]), list(INPUTS), ["rows"])
        return Stacked(function, ["phi", "q"], ["d", "h", "q"])

    def _sum_slopes(self, places: tuple[int, ...]) -> tuple[Stacked, ca.Sparsity]:
        """Return (phi, d, h, q, weights) -> sums of weights times slopes, and where in (k, p + h) these are."""
        if places not in self._sums:
            machine = self.machine
            _, d, h, _ = machine.symbols
            along = ca.jacobian(self._graph[list(places)], ca.vertcat(d, h))
            size = d.numel()
            along = along[:, [*machine.moved, *range(size, size + h.numel())]]
            pattern = along.sparsity()
            weights = ca.SX.sym("weights", len(places))
            products = (along.nz[place] * weights[row] for place, row in enumerate(pattern.row()))
            function = ca.Function(
                "slopes_sum", [*machine.symbols, weights], ca.cse([ca.densify(ca.vertcat(*products))]),
                [*INPUTS, "weights"], ["sums"],
            )  # fmt: skip
            stacked = Stacked(function, ["phi", "q", "weights"], ["d", "h", "q", "weights"], True, True)
            self._sums[places] = stacked, pattern
        return self._sums[places]

    @cached_property
    def _tangents(self) -> Kernel:
        """(d) -> the tangent of h in the moved values, column by column."""
        tangent = Response(self.machine, self.names).tangent
        symbol: Any = ca.SX if tangent.is_a("SXFunction") else ca.MX
        d = symbol.sym("d", len(self.machine.values))
        dh = ca.densify(ca.vec(tangent(d)[1]))
        return Kernel(ca.Function("tangents", [d], [dh], ["d"], ["dh"]), lanes=["d"])

    @cached_property
    def _hoist(self) -> Kernel:
        prologue = self.machine.prologue
        symbol: Any = ca.SX if prologue.is_a("SXFunction") else ca.MX
        d = symbol.sym("d", len(self.machine.values))
        return Kernel(ca.Function("hoist", [d], [ca.densify(prologue(d))], ["d"], ["h"]), lanes=["d"])
