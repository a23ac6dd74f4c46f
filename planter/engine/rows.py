"""Cycles of many machines of one build: values in rows, a machine in each lane, loops closed by all lanes together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from planter.numerics.arrays import Flags, Integers

MEMORY = 1 << 22
"""Numbers that the samples of a block may take."""
MOST_LANES, LEAST_LANES = 2048, 64
SUMS = 8
"""Sums over the angles that are kept apart, so that as many angles can be taken at once."""
COMPARED = 24
"""Samples at which a cycle is compared with the next one."""
SHARE, FLOOR = 1e-7, 1e-12
"""A quantity repeats if it changes by less than this share of the largest value in its unit, or this much in SI."""


@dataclass(frozen=True)
class Block:
    """Quantities of machines in lanes: samples (m, n, lanes) in SI, and which quantities (m, lanes) repeat.

    `rows` (lanes,) are the machines' rows; the last of them may stand in several lanes. `places` (c, n, lanes) are the
    coordinates of their loops, `data` (v, lanes) their values, `hoisted` (k, lanes) what no angle changes.
    """

    samples: Array
    repeats: Flags
    rows: Integers
    data: Array
    hoisted: Array
    places: Array


class Rows:
    """Quantities by name over rows of values d (r, v) in SI, at `samples` angles of a turn.

    Lanes do not influence each other: a row has the same digits whatever stands beside it.
    """

    def __init__(
        self, machine: Machine, names: Sequence[str], samples: int | None = None, compared: bool = True
    ) -> None:
        """`compared` says whether each cycle is compared with the next, without which nothing counts as repeating."""
        self.machine, self.compared = machine, compared
        self.quantities = tuple(machine.find_quantity(name) for name in names)
        self.names = tuple(quantity.name for quantity in self.quantities)
        self._units = sorted({quantity.unit for quantity in self.quantities if quantity.unit != "rad"})
        self._guards = [quantity for quantity in machine.quantities if quantity.role in ("pivot", "states")]
        self._slope_kernels: dict[tuple[int, ...], tuple[Kernel, ca.Sparsity]] = {}
        count = machine.samples if samples is None else samples
        self.angles = machine.turn * np.arange(count) / count

    def compile(self) -> None:
        """Compile what `evaluate` calls."""
        for kernel in (self._values, self._hoist):
            kernel.compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def compile_slopes(self, places: Sequence[int]) -> None:
        """Compile what `gradients` calls."""
        for kernel in (self._slopes(tuple(places))[0], self._tangents):
            kernel.compile()

    def evaluate(self, d: Array, reduce: Callable[[Block], Array], threads: int = 1) -> Array:
        """Return what `reduce` makes of blocks, (outputs, lanes) each, as (r, outputs); NaN in rows without a cycle."""
        self.compile()
        coordinates = self.machine.loops.size if self.machine.loops else 0
        size = MEMORY // ((len(self.names) + coordinates) * len(self.angles))
        size = int(np.clip(size, LEAST_LANES, MOST_LANES))
        parts = [d[start : start + size] for start in range(0, len(d), size)]

        def run(part: Array) -> tuple[Array, Flags, Integers]:
            with np.errstate(all="ignore"):  # of lanes that failed
                block, failed = self.block(part)
                return reduce(block), failed, block.rows

        if threads == 1:
            results = [run(part) for part in parts]
        else:
            with ThreadPoolExecutor(threads) as pool:
                results = list(pool.map(run, parts))
        rows = []
        for reduced, failed, lanes in results:
            values = np.full((len(failed), len(reduced)), np.nan)
            values[lanes] = reduced.T
            values[failed] = np.nan
            rows.append(values)
        return np.vstack(rows)

    def block(self, d: Array) -> tuple[Block, Flags]:
        """Return the samples of machines with values d (r, v), and which of these (r,) have no cycle.

        A machine whose loops do not close is in no lane, unless there are no others. The last machine is repeated up to
        full vectors of lanes, so that sums have the same order in every block.
        """
        rows = _filled(np.arange(len(d)))
        data = np.ascontiguousarray(np.asarray(d, dtype=float)[rows].T)
        places, gained = np.empty((0, len(self.angles) + 1, len(rows))), np.empty((0, len(rows)))
        alive = np.ones(len(rows), dtype=bool)
        if self.machine.loops:
            walk = self.machine.loops.walk(data, np.append(self.angles, self.machine.turn))
            places, (gained, alive) = walk.places, walk.gains()
            if not alive.all():
                lanes = _filled(np.flatnonzero(alive) if alive.any() else np.zeros(1, dtype=np.int64))
                rows, data, gained = rows[lanes], np.ascontiguousarray(data[:, lanes]), gained[:, lanes]
                places, alive = places[:, :, lanes], alive[lanes]
        hoisted, finite = self._hoist.masked(d=data)
        h = np.where(finite, hoisted["h"], 0.0)
        samples, least, largest = self._follow(data, h, places)
        finite &= alive & np.isfinite(samples).all(axis=(0, 1)) & np.isfinite(least).all(axis=0)
        for row, guard in zip(least, self._guards, strict=True):
            finite &= row >= LEAST_PIVOT if guard.role == "pivot" else row != 0
        failed = np.ones(len(d), dtype=bool)
        failed[rows[finite]] = False
        repeats = self._repeats(data, h, places, gained, samples, largest)
        return Block(samples, repeats, rows, data, h, places[:, :-1]), failed

    def gradients(self, block: Block, places: Sequence[int], weights: Callable[[slice], Array]) -> Array:
        """Return sums over all angles of weights times slopes in the moved values, (k, p, lanes) in SI.

        The k-th sum is of the quantity at the k-th of `places` in `names`. `weights` gives those of a range of angles,
        (k, angles, lanes). Angles are added up in the same order whatever the number of lanes.
        """
        machine, lanes = self.machine, block.data.shape[1]
        kernel, pattern = self._slopes(tuple(places))
        sums = np.zeros((pattern.nnz(), SUMS, lanes))
        group = int(np.clip(MOST_LANES // max(lanes, 1), 1, SUMS))
        group = 1 << (group.bit_length() - 1)
        data, hoisted = np.tile(block.data, group), np.tile(block.hoisted, group)
        for start in range(0, len(self.angles), group):
            part = slice(start, min(start + group, len(self.angles)))
            width = (part.stop - start) * lanes
            slot = slice(start % SUMS, start % SUMS + part.stop - start)
            out, _ = kernel.masked(
                phi=np.repeat(self.angles[part], lanes)[None], d=data[:, :width], h=hoisted[:, :width],
                q=block.places[:, part].reshape(-1, width), weights=weights(part).reshape(len(places), width),
                sums=sums[:, slot].reshape(-1, width),
            )  # fmt: skip
            sums[:, slot] = out["total"].reshape(-1, slot.stop - slot.start, lanes)
        size, p = len(places), len(machine.moved)
        slopes = np.zeros((size, p + machine.prologue.numel_out(0), lanes))
        slopes[pattern.get_triplet()] = sums.sum(axis=1)
        tangents, _ = self._tangents.masked(d=block.data)
        dh = tangents["dh"].reshape(p, -1, lanes)
        return np.asarray(slopes[:, :p] + np.einsum("khl,phl->kpl", slopes[:, p:], dh))

    def _follow(self, d: Array, h: Array, places: Array) -> tuple[Array, Array, Array]:
        """Return samples (m, n, lanes), the least values of all guards, and the largest ones in each unit.

        A call takes as many angles as fill it with lanes.
        """
        lanes, count = d.shape[1], len(self.angles)
        group = int(np.clip(MOST_LANES // max(lanes, 1), 1, count))
        samples = np.empty((len(self.names), count, lanes))
        least, largest = (np.full((len(self._guards), group * lanes), np.inf),
                          np.zeros((len(self._units), group * lanes)))  # fmt: skip
        data, hoisted = np.tile(d, group), np.tile(h, group)
        for start in range(0, count, group):
            part = slice(start, min(start + group, count))
            width = (part.stop - start) * lanes
            out, _ = self._values.masked(
                phi=np.repeat(self.angles[part], lanes)[None], d=data[:, :width], h=hoisted[:, :width],
                q=places[:, part].reshape(-1, width), least=least[:, :width], largest=largest[:, :width],
            )  # fmt: skip
            samples[:, part] = out["rows"].reshape(-1, part.stop - start, lanes)
            least[:, :width], largest[:, :width] = out["lowest"], out["highest"]
        least, largest = (sizes.reshape(-1, group, lanes) for sizes in (least, largest))
        return samples, least.min(axis=1), largest.max(axis=1)

    def _repeats(self, d: Array, h: Array, places: Array, gained: Array, samples: Array, largest: Array) -> Flags:
        """Return which quantities (m, lanes) are a turn later what they were; angles may gain whole turns."""
        lanes = d.shape[1]
        if not self.compared:
            return np.zeros((len(self.names), lanes), dtype=bool)
        least, none = np.zeros((len(self._guards), lanes)), np.zeros((len(self._units), lanes))
        changes = np.zeros((len(self.names), lanes))
        angular = np.array([quantity.unit == "rad" for quantity in self.quantities])[:, None]
        for index in self._chosen:
            phi, q = np.full((1, lanes), self.angles[index] + self.machine.turn), places[:, index] + gained
            later = self._values.masked(phi=phi, d=d, h=h, q=q, least=least, largest=none)[0]["rows"]
            change = later - samples[:, index]
            changes = np.maximum(changes, np.abs(change - np.where(angular, TURN * np.round(change / TURN), 0.0)))
        sizes = np.ones_like(changes)
        for row, quantity in enumerate(self.quantities):
            if quantity.unit in self._units:
                sizes[row] = largest[self._units.index(quantity.unit)]
        return np.asarray(changes <= np.maximum(SHARE * sizes, FLOOR))

    @cached_property
    def _chosen(self) -> list[int]:
        count = min(COMPARED, len(self.angles))
        return [int(index) for index in np.unique(np.linspace(0, len(self.angles) - 1, count).astype(int))]

    @cached_property
    def _values(self) -> Kernel:
        """(phi, d, h, q, least, largest) -> quantities of all sides, the least guards and largest sizes until then."""
        machine = self.machine
        near = [q for q in machine.results if self.compared and q.unit in self._units]
        near = [q for q in near if q.total == self.quantities[0].total]
        names = [quantity.name for quantity in (*self.quantities, *self._guards, *near)]
        rows = _sum_sides(Response(machine, names))
        first, second = len(self.quantities), len(self.quantities) + len(self._guards)
        least, largest = ca.SX.sym("least", len(self._guards)), ca.SX.sym("largest", len(self._units))
        sizes = ca.SX(largest)
        for index, unit in enumerate(self._units):
            for place, quantity in enumerate(near):
                if quantity.unit == unit:
                    sizes[index] = ca.fmax(sizes[index], ca.fabs(rows[second + place]))
        guards = ca.reshape(rows[first:second], len(self._guards), 1)  # a slice of none lies down
        outputs = [rows[:first], ca.fmin(least, guards), sizes]
        function = ca.Function(
            "sampled", [*machine.symbols, least, largest], ca.cse([ca.densify(output) for output in outputs]),
            [*INPUTS, "least", "largest"], ["rows", "lowest", "highest"],
        )  # fmt: skip
        return Kernel(function, lanes=[*INPUTS, "least", "largest"])

    def _slopes(self, places: tuple[int, ...]) -> tuple[Kernel, ca.Sparsity]:
        """Return (phi, d, h, q, weights, sums) -> sums plus weights times slopes, and where in (k, p + h) these are."""
        if places not in self._slope_kernels:
            machine = self.machine
            _, d, h, _ = machine.symbols
            rows = _sum_sides(Response(machine, self.names))[list(places)]
            along = ca.jacobian(rows, ca.vertcat(d, h))
            size = d.numel()
            along = along[:, [*machine.moved, *range(size, size + h.numel())]]
            pattern = along.sparsity()
            weights, sums = ca.SX.sym("weights", len(places)), ca.SX.sym("sums", pattern.nnz())
            products = (along.nz[place] * weights[row] for place, row in enumerate(pattern.row()))
            total = sums + ca.vertcat(*products)
            function = ca.Function(
                "slopes_sum", [*machine.symbols, weights, sums], ca.cse([ca.densify(total)]),
                [*INPUTS, "weights", "sums"], ["total"],
            )  # fmt: skip
            self._slope_kernels[places] = Kernel(function, lanes=[*INPUTS, "weights", "sums"]), pattern
        return self._slope_kernels[places]

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


def _sum_sides(response: Response) -> ca.SX:
    """Return the graph of a response's quantities (m,), shares of the sides added up."""
    phi, d, h, q = response.machine.symbols
    sides = [response.values_function(phi + offset, d, h, q) for offset in response.offsets]
    rows = [
        ca.SX(sum(side[i] for side in sides)) if shared else sides[0][i] for i, shared in enumerate(response.shared)
    ]
    return ca.vertcat(*rows)


def _filled(lanes: Integers) -> Integers:
    """Return lanes, the last of them repeated up to full vectors."""
    return np.append(lanes, np.repeat(lanes[-1:], -len(lanes) % VECTOR))
