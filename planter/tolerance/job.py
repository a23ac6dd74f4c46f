"""Turns of machines as their tolerances make them, in rows: drawn at random, or for Sobol' indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.sweeps.job import Recipe
from planter.sweeps.points import SobolSequence, chunk_generator
from planter.sweeps.room import ResolvedMachine, Subject
from planter.tolerance.spread import Spread

Spreads = Mapping[str, Spread]


def recipe(
    held: ResolvedMachine, choices: Mapping[str, str], spreads: Spreads, outputs: Sequence[str], **drawn: Any
) -> Recipe:
    """How any process makes the rows: `drawn` says which, `rows` and `seed`, or `base` and `seed` for indices."""
    return Recipe(f"{__name__}:{Turns.__name__}", {
        "module": held.module, "machine": held.room.frozen(held.machine), "choices": dict(choices),
        "spreads": {name: [one.kind, one.low, one.high] for name, one in spreads.items()}, "outputs": list(outputs),
        "drawn": drawn, **held.hash_curves(outputs),
    })  # fmt: skip


class Turns:
    """Outputs of a machine at points that are drawn from its tolerances."""

    def __init__(
        self, module: str, machine: Mapping[str, Any], choices: Mapping[str, str], spreads: Mapping[str, Any],
        outputs: Sequence[str], drawn: Mapping[str, int], curves: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        """`curves` are hashes of files that outputs need, which tell this job from that with other files."""
        named = {name: Spread(*one) for name, one in spreads.items()}
        ends = {name: (one.low, one.high) for name, one in named.items()}
        self.subject: Subject = import_module(module).ROOM.subject(machine, choices, ends, outputs)
        self.points: Drawn | Saltelli = (Saltelli if "base" in drawn else Drawn)(tuple(named.values()), **drawn)
        self.rows, self.width = self.points.rows, len(outputs)

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Outputs at the points from `start` to `stop`."""
        return self.subject.evaluated(self.points.block(start, stop), threads)


class Drawn:
    """Points at random, each input by its own distribution; every chunk has a seed of its own."""

    def __init__(self, spreads: Sequence[Spread], rows: int, seed: int) -> None:
        self.spreads, self.rows, self.seed = spreads, rows, seed

    def block(self, start: int, stop: int) -> Array:
        """Points from `start`, the first of a chunk, to `stop`, a column for each input."""
        return spread_out(self.spreads, chunk_generator(self.seed, start).random((stop - start, len(self.spreads))))


class Saltelli:
    """Points for Sobol' indices (Saltelli et al. 2010): A, B, and A with one column of B after the other.

    A and B are the halves of one Sobol' sequence, of `base` points, a power of 2.
    """

    def __init__(self, spreads: Sequence[Spread], base: int, seed: int) -> None:
        self.spreads, self.base = spreads, base
        self.rows = base * (len(spreads) + 2)
        self._sequence = SobolSequence(2 * len(spreads), seed)

    def block(self, start: int, stop: int) -> Array:
        """Points from `start` to `stop`: all of A, then all of B, then each of the mixed ones."""
        parts, at = [], start
        while at < stop:
            matrix, first = divmod(at, self.base)
            last = min(first + stop - at, self.base)
            parts.append(self._part(matrix, first, last))
            at += last - first
        return spread_out(self.spreads, np.vstack(parts))

    def _part(self, matrix: int, first: int, last: int) -> Array:
        size = len(self.spreads)
        cube = self._sequence(first, last)
        found = cube[:, size:] if matrix == 1 else cube[:, :size].copy()
        if matrix > 1:
            found[:, matrix - 2] = cube[:, size + matrix - 2]
        return found


def spread_out(spreads: Sequence[Spread], cube: Array) -> Array:
    """Points (m, n) of the unit cube as values of the inputs."""
    return np.column_stack([one.at(shares) for one, shares in zip(spreads, cube.T, strict=True)])
