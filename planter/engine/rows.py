"""Cycles of many machines of one build: values in rows, a machine in each lane, loops closed by all lanes together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.loops import TURN
from planter.engine.machine import LEAST_PIVOT, Machine
from planter.engine.response import INPUTS, Response
from planter.kernels import Array, Kernel
from planter.numerics.arrays import Flags

MEMORY = 1 << 22
"""Numbers that the samples of a block may take."""
MOST_LANES, LEAST_LANES = 2048, 64
VECTOR = 8
"""Lanes that a processor takes at once, at most."""
COMPARED = 24
"""Samples at which a cycle is compared with the next one."""
SHARE, FLOOR = 1e-7, 1e-12
"""A quantity repeats if it changes by less than this share of the largest value in its unit, or this much in SI."""


@dataclass(frozen=True)
class Block:
    """Quantities of machines in lanes: samples (m, n, lanes) in SI, and which quantities (m, lanes) repeat."""

    samples: Array
    repeats: Flags


class Rows:
    """Quantities by name over rows of values d (r, v) in SI, at `samples` angles of a turn.

    Lanes do not influence each other: a row has the same digits whatever stands beside it.
    """

    def __init__(
        self, machine: Machine, names: Sequence[str], samples: int | None = None, compared: bool = True
    ) -> None:
        """`compared` says whether each cycle is compared with the next, without which nothing counts as repeating."""
        self.machine, self.compared = machine, compared
        units = {machine.find_quantity(name).unit for name in names} if compared else set()
        guards = [q.name for q in machine.quantities if q.role in ("pivot", "states")]
        near = [q.name for q in machine.results if q.unit in units and q.total == machine.find_quantity(names[0]).total]
        self.names = tuple(machine.find_quantity(name).name for name in names)
        self._all = tuple(dict.fromkeys([*self.names, *guards, *near]))
        self.response = Response(machine, self._all)
        count = machine.samples if samples is None else samples
        self.angles = TURN * np.arange(count) / count

    def compile(self) -> None:
        """Compile what `evaluate` calls."""
        for kernel in (self._values, self._hoist):
            kernel.compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def evaluate(self, d: Array, reduce: Callable[[Block], Array], threads: int = 1) -> Array:
        """Return what `reduce` makes of blocks, (outputs, lanes) each, as (r, outputs); NaN in rows without a cycle."""
        self.compile()
        size = int(np.clip(MEMORY // (len(self._all) * len(self.angles)), LEAST_LANES, MOST_LANES))
        parts = [d[start : start + size] for start in range(0, len(d), size)]

        def run(part: Array) -> Array:
            block, failed = self.block(part)
            result = reduce(block)
            result[:, failed] = np.nan
            return result[:, : len(part)].T

        if threads == 1:
            return np.vstack([run(part) for part in parts])
        with ThreadPoolExecutor(threads) as pool:
            return np.vstack(list(pool.map(run, parts)))

    def block(self, d: Array) -> tuple[Block, Flags]:
        """Return the samples of machines with values d (lanes, v), and which of them have no cycle.

        The last machine is repeated up to full vectors of lanes, so that sums have the same order in every block.
        """
        padded = np.ascontiguousarray(np.vstack([d, np.repeat(d[-1:], -len(d) % VECTOR, axis=0)]).T, dtype=float)
        hoisted, finite = self._hoist.masked(d=padded)
        h = np.where(finite, hoisted["h"], 0.0)
        alive, samples, later = self._follow(padded, h)
        alive &= finite & np.isfinite(samples).all(axis=(0, 1))
        for row, name in enumerate(self._all):
            role = self.machine.find_quantity(name).role
            if role in ("pivot", "states"):
                least = samples[row].min(axis=0)
                alive &= least >= LEAST_PIVOT if role == "pivot" else least != 0
        repeats = self._repeats(samples, later)
        chosen = len(self.names)
        return Block(samples[:chosen], repeats[:chosen]), ~alive

    def _follow(self, d: Array, h: Array) -> tuple[Flags, Array, Array | None]:
        """Return which lanes have a cycle, the samples (m, n, lanes), and those a turn later of the compared ones."""
        lanes, offsets = d.shape[1], self.response.offsets
        samples = np.empty((len(self._all), len(self.angles), lanes))
        loops = self.machine.loops
        walk = loops.walk(d, np.append(self.angles, TURN)) if loops else None
        places = iter(walk) if walk is not None else None
        chosen = self._chosen
        kept: list[Array] = []
        for index, angle in enumerate(self.angles):
            q = np.empty((0, lanes)) if places is None else next(places)
            for side, offset in enumerate(offsets):
                rows = self._rows_at(angle + offset, d, h, q)
                if side == 0:
                    samples[:, index] = rows
                else:
                    samples[self._shared, index] += rows[self._shared]
            if walk is not None and index in chosen:
                kept.append(q.copy())
        alive = np.ones(lanes, dtype=bool)
        gained = np.zeros((0, lanes))
        if walk is not None and places is not None:
            next(places)
            gained, alive = walk.gains()
        if not self.compared:
            return alive, samples, None
        later = np.empty((len(self._all), len(chosen), lanes))
        for place, index in enumerate(chosen):
            q = kept[place] + gained if kept else np.empty((0, lanes))
            parts = [self._rows_at(self.angles[index] + offset + TURN, d, h, q) for offset in offsets]
            later[:, place] = np.where(np.array(self.response.shared)[:, None], sum(parts), parts[0])
        return alive, samples, later

    def _rows_at(self, angle: float, d: Array, h: Array, q: Array) -> Array:
        lanes = d.shape[1]
        inputs = {"phi": np.full((1, lanes), angle), "d": d, "h": h, "q": q}
        return self._values.masked(**inputs)[0]["rows"]

    def _repeats(self, samples: Array, later: Array | None) -> Flags:
        """Return which quantities (m, lanes) are a turn later what they were; angles may gain whole turns."""
        if later is None:
            return np.zeros((samples.shape[0], samples.shape[2]), dtype=bool)
        units = [self.machine.find_quantity(name).unit for name in self._all]
        sizes = np.abs(samples).max(axis=1)
        repeats = np.empty(sizes.shape, dtype=bool)
        for row, unit in enumerate(units):
            change = later[row] - samples[row][self._chosen]
            size = np.array(1.0)
            if unit == "rad":
                change -= TURN * np.round(change / TURN)
            else:
                size = sizes[[i for i, other in enumerate(units) if other == unit]].max(axis=0)
            repeats[row] = np.abs(change).max(axis=0) <= np.maximum(SHARE * size, FLOOR)
        return repeats

    @cached_property
    def _chosen(self) -> list[int]:
        count = min(COMPARED, len(self.angles))
        return [int(index) for index in np.unique(np.linspace(0, len(self.angles) - 1, count).astype(int))]

    @property
    def _shared(self) -> list[int]:
        return [row for row, shared in enumerate(self.response.shared) if shared]

    @cached_property
    def _values(self) -> Kernel:
        return Kernel(self.response.values_function, lanes=list(INPUTS))

    @cached_property
    def _hoist(self) -> Kernel:
        prologue = self.machine.prologue
        symbol: Any = ca.SX if prologue.is_a("SXFunction") else ca.MX
        d = symbol.sym("d", len(self.machine.values))
        return Kernel(ca.Function("hoist", [d], [ca.densify(prologue(d))], ["d"], ["h"]), lanes=["d"])
