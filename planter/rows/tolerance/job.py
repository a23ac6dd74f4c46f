"""Cycles of machines at points within their tolerances: distributions, random points, points of
Sobol' indices.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from math import erfc, exp, pi, sqrt
from typing import Any, Literal

import numpy as np
import scipy

from planter.kernels import Array
from planter.rows.sweeps.adapter import SweepAdapter
from planter.rows.sweeps.plan import SobolSequence, UnitCubePoints, draw_random

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

    @property
    def ends(self) -> tuple[float, float]:
        """Both ends."""
        return self.low, self.high

    def from_unit(self, shares: Array) -> Array:
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


class ToleranceJob:
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
        ends = {name: spread.ends for name, spread in distributions.items()}
        adapter: SweepAdapter = import_module(module).ADAPTER
        self.subject = adapter.subject(machine, choices, ends, outputs)
        kinds: dict[str, Callable[..., UnitCubePoints]] = {
            "rows": draw_points,
            "base": Saltelli,
            "machines": HalvedTolerances,
        }
        (kind,) = kinds.keys() & drawn.keys()
        self.points = kinds[kind](tuple(distributions.values()), **drawn)
        self.rows, self.width = self.points.rows, len(outputs)

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the outputs at the points from `start` to `stop`, (stop - start, width)."""
        return self.subject.evaluated(self.points.block(start, stop), threads)


def draw_points(spreads: Sequence[Spread], rows: int, seed: int) -> UnitCubePoints:
    """Return random points of the distributions of the inputs."""
    return UnitCubePoints(spreads, rows, draw_random(len(spreads), seed))


class StackedPoints(UnitCubePoints):
    """Matrices of `base` points each, one below another, from one Sobol' sequence of `size`
    numbers a point.
    """

    axes: Sequence[Spread]

    def __init__(
        self, spreads: Sequence[Spread], base: int, matrices: int, size: int, seed: int
    ) -> None:
        super().__init__(spreads, base * matrices, SobolSequence(size, seed))
        self.base = base

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n)."""
        parts, row = [], start
        while row < stop:
            matrix, first = divmod(row, self.base)
            last = min(first + stop - row, self.base)
            parts.append(self.mix(matrix, self.cube(first, last)))
            row += last - first
        return np.vstack(parts)

    def mix(self, matrix: int, cube: Array) -> Array:
        """Return the rows (m, n) of a matrix from those of the sequence (m, size)."""
        raise NotImplementedError


class Saltelli(StackedPoints):
    """Points for Sobol' indices (Saltelli et al. 2010): A, B, and for each column, A with that
    column of B.

    A and B are the halves of one Sobol' sequence, of `base` points, a power of 2.
    """

    def __init__(self, spreads: Sequence[Spread], base: int, seed: int) -> None:
        super().__init__(spreads, base, len(spreads) + 2, 2 * len(spreads), seed)

    def mix(self, matrix: int, cube: Array) -> Array:
        """Return rows of A, of B, or of a mixed matrix."""
        size = len(self.axes)
        points = cube[:, size:] if matrix == 1 else cube[:, :size].copy()
        if matrix > 1:
            points[:, matrix - 2] = cube[:, size + matrix - 2]
        return self.scale(points)


class HalvedTolerances(StackedPoints):
    """Points of the same machines with each tolerance halved in turn: X, then for each column X
    with half deviations.

    X are the points of one Sobol' sequence, `machines` of them, so that their outputs differ by the
    tolerance alone.
    """

    def __init__(self, spreads: Sequence[Spread], machines: int, seed: int) -> None:
        super().__init__(spreads, machines, len(spreads) + 1, len(spreads), seed)

    def mix(self, matrix: int, cube: Array) -> Array:
        """Return rows of X, with one column halved behind the first matrix."""
        points = self.scale(cube)
        if matrix:
            column = points[:, matrix - 1]
            points[:, matrix - 1] += (self.axes[matrix - 1].centre - column) / 2
        return points
