"""Which parameters curves depend on at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.response import Response

THRESHOLD = 1e-10
"""Singular values below this share of the largest count as zero."""
NEGLIGIBLE = 1e-6
"""Weights below this are left out of a named direction."""


@dataclass(frozen=True)
class Insensitive:
    """Numerical rank of the curve's Jacobian, and its null space.

    `effective_parameters` is the rank; `directions` spans the null space, each {name: weight} in parts of the box
    width with the largest weight 1; `zero` (p,) marks parameters that have no effect alone; `space` (k, p) spans the
    null space by directions in shares of the box, at right angles to each other.
    """

    effective_parameters: int
    directions: list[dict[str, float]]
    zero: Flags
    space: Array

    @property
    def named(self) -> list[list[dict[str, float]]]:
        """The directions as lists of {name: weight}."""
        return [[{name: weight} for name, weight in direction.items()] for direction in self.directions]


def sensitivity(response: Response, x: Array, samples: int, held: Array | None = None) -> Insensitive:
    """Rank and null space of the Jacobian of a curve in the design parameters.

    The curve is taken at `samples` angles of a turn at design x (p,) [SI]; columns are multiplied by the box width;
    the threshold is 1e-10 of the largest singular value. Where equations with gradients `held` (k, p) hold the design,
    the null space is what they leave of it.
    """
    phi = 2 * np.pi * np.arange(samples) / samples
    slopes = response.slopes(response.prologue(x), np.mod(phi, response.period))[1]
    width = response.upper - response.lower
    return find_insensitive(response.names, slopes[:, 1:] * width, None if held is None else held * width)


def find_insensitive(names: tuple[str, ...], columns: Array, rows: Array | None = None) -> Insensitive:
    """Return the rank of scaled slopes (n, p) of curves in parameters, and their null space by the names of these.

    Where equations with scaled gradients `rows` (k, p) hold the parameters, the null space is what they leave of it.
    """
    _, values, right = np.linalg.svd(columns, full_matrices=len(columns) < len(names))
    limit = THRESHOLD * values[0]
    rank = int((values > limit).sum())
    space = right[rank:]
    zero: Flags = np.linalg.norm(columns, axis=0) <= limit
    if rows is not None:
        from scipy.linalg import null_space

        rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        space = space.T @ null_space(rows @ space.T, THRESHOLD)
        space, zero = space.T, zero & (np.abs(rows).max(axis=0) <= THRESHOLD)
    return Insensitive(rank, _directions(names, space, zero), zero, space)


def _directions(names: tuple[str, ...], space: Array, zero: Flags) -> list[dict[str, float]]:
    """A basis of the null space that is easy to read: single parameters first, then reduced combinations."""
    single: list[dict[str, float]] = [{names[j]: 1.0} for j in np.flatnonzero(zero)]
    mixed = _reduced(np.where(zero, 0.0, space), len(space) - len(single))
    return single + [{names[j]: float(row[j]) for j in np.flatnonzero(np.abs(row) > NEGLIGIBLE)} for row in mixed]


def _reduced(space: Array, count: int) -> list[Array]:
    """The first `count` rows of the echelon form with complete pivoting, each scaled to a largest weight of 1."""
    rows = space.copy()
    for i in range(count):
        pivot, column = (int(k) for k in np.unravel_index(np.abs(rows[i:]).argmax(), rows[i:].shape))
        rows[[i, i + pivot]] = rows[[i + pivot, i]]
        rows[i] /= rows[i, column]
        others = np.arange(len(rows)) != i
        rows[others] -= np.outer(rows[others, column], rows[i])
    return [row / row[np.abs(row).argmax()] for row in rows[:count]]
