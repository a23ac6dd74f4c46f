"""Points of a sweep in chunks, each of which depends only on the seed of the plan and on its number."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from scipy.stats import qmc

from planter.kernels import Array
from planter.sweeps.axes import Axis
from planter.sweeps.job import CHUNK


class Points(Protocol):
    """A number of `rows` points."""

    rows: int

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start`, the first of a chunk, to `stop`: (stop - start, n) for n inputs."""


class Grid:
    """All combinations of the values of all axes; the last axis changes fastest."""

    def __init__(self, axes: Sequence[Axis]) -> None:
        self.axes = axes
        self.shape = tuple(axis.count for axis in axes)
        self.rows = math.prod(self.shape)

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n)."""
        indices = np.unravel_index(np.arange(start, stop), self.shape)
        return np.column_stack([axis.on_grid(index) for axis, index in zip(self.axes, indices, strict=True)])


class UnitCubePoints:
    """Points of the unit cube, scaled to the axes."""

    def __init__(self, axes: Sequence[Axis], rows: int, seed: int) -> None:
        self.axes, self.rows, self.seed = axes, rows, seed

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n)."""
        cube = self.cube(start, stop)
        return np.column_stack([axis.from_unit(shares) for axis, shares in zip(self.axes, cube.T, strict=True)])

    def cube(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop` in [0, 1), (stop - start, n)."""
        raise NotImplementedError


class Sobol(UnitCubePoints):
    """Points of one scrambled Sobol' sequence through all chunks."""

    def __init__(self, axes: Sequence[Axis], rows: int, seed: int) -> None:
        super().__init__(axes, rows, seed)
        self._sequence = SobolSequence(len(axes), seed)

    def cube(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop` of the sequence, (stop - start, n)."""
        return self._sequence(start, stop)


class Latin(UnitCubePoints):
    """A Latin hypercube for each chunk: m rows, one in each of m slices of every axis."""

    def cube(self, start: int, stop: int) -> Array:
        """Return the hypercube of the chunk from `start` to `stop`, (stop - start, n)."""
        rng = chunk_generator(self.seed, start)
        cube: Array = qmc.LatinHypercube(len(self.axes), rng=rng).random(stop - start)
        return cube


SCHEMES = {"sobol": Sobol, "latin": Latin}


class SobolSequence:
    """A scrambled Sobol' sequence in [0, 1) with random access; forward is faster than backward."""

    def __init__(self, size: int, seed: int) -> None:
        self.size, self.seed = size, seed
        self._begin()

    def _begin(self) -> None:
        self._engine = qmc.Sobol(self.size, rng=np.random.default_rng(self.seed))

    def __call__(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, size)."""
        if start < self._engine.num_generated:
            self._begin()
        if start > self._engine.num_generated:
            self._engine.fast_forward(start - self._engine.num_generated)
        with warnings.catch_warnings():  # SciPy warns of counts that are not a power of 2
            warnings.simplefilter("ignore", UserWarning)
            points: Array = self._engine.random(stop - start)
        return points


def chunk_generator(seed: int, start: int) -> np.random.Generator:
    """Return the random generator of the chunk that begins at row `start`."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(start // CHUNK,)))
