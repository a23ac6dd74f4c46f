"""Cycles of machines at points within their tolerances: distributions, random points, points of
Sobol' indices.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from math import erfc, exp, pi, sqrt
from typing import Any, Literal

import numpy as np
import scipy

from planter.kernels import Array
from planter.sweeps.adapter import ResolvedMachine, SweepSubject
from planter.sweeps.job import Recipe
from planter.sweeps.plan import SobolSequence, chunk_generator

Kind = Literal["normal", "uniform", "triangular"]
ENDS = 3.0
"""Standard deviations at which a normal distribution is truncated."""
_TAIL = erfc(ENDS / sqrt(2)) / 2


@dataclass(frozen=True)
class Spread:
    """Symmetric distribution between `low` and `high` [display unit of the input]."""

    kind: Kind
    low: float
    high: float

    @property
    def centre(self) -> float:
        """Mean."""
        return (self.low + self.high) / 2

    @property
    def std(self) -> float:
        """Standard deviation.

        >>> round(Spread("uniform", 35, 45).std, 4), round(Spread("normal", -3, 3).std, 4)
        (2.8868, 0.9866)
        """
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return width / sqrt(12)
            case "triangular":
                return width / sqrt(24)
        lost = 2 * ENDS * exp(-(ENDS**2) / 2) / sqrt(2 * pi) / (1 - 2 * _TAIL)
        return width / (2 * ENDS) * sqrt(1 - lost)

    def quantiles(self, shares: Array) -> Array:
        """Return the quantiles (n,) at probabilities `shares` (n,) in [0, 1]."""
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return self.low + shares * width
            case "triangular":
                half = np.sqrt(np.minimum(shares, 1 - shares) / 2)
                return np.where(shares < 0.5, self.low + half * width, self.high - half * width)
        values: Array = self.centre + width / (2 * ENDS) * scipy.special.ndtri(
            _TAIL + shares * (1 - 2 * _TAIL)
        )
        return values


Spreads = Mapping[str, Spread]


def build_recipe(
    resolved: ResolvedMachine,
    choices: Mapping[str, str],
    spreads: Spreads,
    outputs: Sequence[str],
    **sampling: Any,
) -> Recipe:
    """Return the recipe of the rows; `sampling` is `rows` and `seed`, `base` and `seed` for
    indices, or `machines` and `seed` for halved tolerances.
    """
    return Recipe(
        f"{__name__}:{Turns.__name__}",
        {
            "module": resolved.module,
            "machine": resolved.adapter.frozen(resolved.machine),
            "choices": dict(choices),
            "spreads": {
                name: [spread.kind, spread.low, spread.high] for name, spread in spreads.items()
            },
            "outputs": list(outputs),
            "drawn": sampling,
            **resolved.hash_curves(outputs),
        },
    )


class Turns:
    """Job of the outputs of a machine at points within its tolerances."""

    def __init__(
        self,
        module: str,
        machine: Mapping[str, Any],
        choices: Mapping[str, str],
        spreads: Mapping[str, Any],
        outputs: Sequence[str],
        drawn: Mapping[str, int],
        curves: Mapping[str, str] | None = None,
    ) -> None:
        """Build the machine; `curves`, hashes of files that outputs need, distinguish jobs with
        other files.
        """
        distributions = {name: Spread(*entry) for name, entry in spreads.items()}
        ends = {name: (spread.low, spread.high) for name, spread in distributions.items()}
        self.subject: SweepSubject = import_module(module).ADAPTER.subject(
            machine, choices, ends, outputs
        )
        kind = (
            Saltelli
            if "base" in drawn
            else HalvedTolerances
            if "machines" in drawn
            else RandomPoints
        )
        self.points: RandomPoints | Saltelli | HalvedTolerances = kind(
            tuple(distributions.values()), **drawn
        )
        self.rows, self.width = self.points.rows, len(outputs)

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the outputs at the points from `start` to `stop`, (stop - start, width)."""
        return self.subject.evaluated(self.points.block(start, stop), threads)


class RandomPoints:
    """Random points of the distributions of the inputs; each chunk has a separate seed."""

    def __init__(self, spreads: Sequence[Spread], rows: int, seed: int) -> None:
        self.spreads, self.rows, self.seed = spreads, rows, seed

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start`, the first of a chunk, to `stop`: (stop - start, n) for n
        inputs.
        """
        return scale_points(
            self.spreads,
            chunk_generator(self.seed, start).random((stop - start, len(self.spreads))),
        )


class Saltelli:
    """Points for Sobol' indices (Saltelli et al. 2010): A, B, and for each column, A with that
    column of B.

    A and B are the halves of one Sobol' sequence, of `base` points, a power of 2.
    """

    def __init__(self, spreads: Sequence[Spread], base: int, seed: int) -> None:
        self.spreads, self.base = spreads, base
        self.rows = base * (len(spreads) + 2)
        self._sequence = SobolSequence(2 * len(spreads), seed)

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n), of A, then B, then the mixed
        matrices.
        """
        parts, row = [], start
        while row < stop:
            matrix, first = divmod(row, self.base)
            last = min(first + stop - row, self.base)
            parts.append(self._part(matrix, first, last))
            row += last - first
        return scale_points(self.spreads, np.vstack(parts))

    def _part(self, matrix: int, first: int, last: int) -> Array:
        size = len(self.spreads)
        cube = self._sequence(first, last)
        points = cube[:, size:] if matrix == 1 else cube[:, :size].copy()
        if matrix > 1:
            points[:, matrix - 2] = cube[:, size + matrix - 2]
        return points


class HalvedTolerances:
    """Points of the same machines with each tolerance halved in turn: X, then for each column X
    with half deviations.

    X are the points of one Sobol' sequence, `machines` of them, so that their outputs differ by the
    tolerance alone.
    """

    def __init__(self, spreads: Sequence[Spread], machines: int, seed: int) -> None:
        self.spreads, self.machines = spreads, machines
        self.rows = machines * (len(spreads) + 1)
        self._sequence = SobolSequence(len(spreads), seed)

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n), of X, then of each X with
        one column halved.
        """
        parts, row = [], start
        while row < stop:
            halved, first = divmod(row, self.machines)
            last = min(first + stop - row, self.machines)
            points = scale_points(self.spreads, self._sequence(first, last))
            if halved:
                points[:, halved - 1] += (
                    self.spreads[halved - 1].centre - points[:, halved - 1]
                ) / 2
            parts.append(points)
            row += last - first
        return np.vstack(parts)


def scale_points(spreads: Sequence[Spread], cube: Array) -> Array:
    """Return points (m, n) of the unit cube as values of the inputs."""
    return np.column_stack(
        [spread.quantiles(shares) for spread, shares in zip(spreads, cube.T, strict=True)]
    )
