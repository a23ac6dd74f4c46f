"""The points of a sweep, chunk by chunk: any chunk is drawn alone, by the seed of the plan and its own number."""

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
    """`rows` points."""

    rows: int

    def block(self, start: int, stop: int) -> Array:
        """Points from `start`, the first of a chunk, to `stop`, a column for each input."""


class Grid:
    """Every value of each axis with every one of the others; the last axis changes fastest."""

    def __init__(self, axes: Sequence[Axis]) -> None:
        self.axes = axes
        self.shape = tuple(axis.count for axis in axes)
        self.rows = math.prod(self.shape)

    def block(self, start: int, stop: int) -> Array:
        places = np.unravel_index(np.arange(start, stop), self.shape)
        return np.column_stack([axis.on_grid(at) for axis, at in zip(self.axes, places, strict=True)])


class Shares:
    """Points of the unit cube as shares of the axes."""

    def __init__(self, axes: Sequence[Axis], rows: int, seed: int) -> None:
        self.axes, self.rows, self.seed = axes, rows, seed

    def block(self, start: int, stop: int) -> Array:
        cube = self.cube(start, stop)
        return np.column_stack([axis.at(shares) for axis, shares in zip(self.axes, cube.T, strict=True)])

    def cube(self, start: int, stop: int) -> Array:
        raise NotImplementedError


class Sobol(Shares):
    """Sobol' points, scrambled by the seed: one sequence through all chunks."""

    def __init__(self, axes: Sequence[Axis], rows: int, seed: int) -> None:
        super().__init__(axes, rows, seed)
        self._sequence = SobolSequence(len(axes), seed)

    def cube(self, start: int, stop: int) -> Array:
        return self._sequence(start, stop)


class Latin(Shares):
    """Latin hypercubes, one a chunk: of so many rows in each of so many slices of every axis one."""

    def cube(self, start: int, stop: int) -> Array:
        found: Array = qmc.LatinHypercube(len(self.axes), rng=generator(self.seed, start)).random(stop - start)
        return found


SCHEMES = {"sobol": Sobol, "latin": Latin}


class SobolSequence:
    """A scrambled Sobol' sequence in [0, 1), entered anywhere; going on is faster than going back."""

    def __init__(self, size: int, seed: int) -> None:
        self.size, self.seed = size, seed
        self._begin()

    def _begin(self) -> None:
        self._engine = qmc.Sobol(self.size, rng=np.random.default_rng(self.seed))

    def __call__(self, start: int, stop: int) -> Array:
        """Its points from `start` to `stop`, (n, size)."""
        if start < self._engine.num_generated:
            self._begin()
        if start > self._engine.num_generated:
            self._engine.fast_forward(start - self._engine.num_generated)
        with warnings.catch_warnings():  # of numbers that are no power of 2
            warnings.simplefilter("ignore", UserWarning)
            found: Array = self._engine.random(stop - start)
        return found


def generator(seed: int, start: int) -> np.random.Generator:
    """Random numbers of the chunk that begins at a row."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(start // CHUNK,)))
