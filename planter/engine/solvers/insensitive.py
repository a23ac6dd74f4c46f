"""Directions of a design to which curves are insensitive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from planter.kernels import Array, Flags

RANK_TOLERANCE = 1e-10
"""Singular values below this share of the largest count as zero."""
WEIGHT_TOLERANCE = 1e-6
"""Smaller weights are omitted from a named direction."""


@dataclass(frozen=True)
class InsensitiveDirections:
    """Numerical rank of the Jacobian of a curve, and its null space.

    `effective_parameters` is the rank; `directions` spans the null space, each {name: weight} in
    parts of the box width with the largest weight 1; `zero` (p,) marks parameters that have no
    effect alone; `space` (k, p) spans the null space by orthonormal directions in shares of the
    box.
    """

    effective_parameters: int
    directions: list[dict[str, float]]
    zero: Flags
    space: Array

    @property
    def named(self) -> list[list[dict[str, float]]]:
        """The directions as lists of {name: weight}."""
        return [
            [{name: weight} for name, weight in direction.items()] for direction in self.directions
        ]


def find_insensitive(
    names: tuple[str, ...], columns: Array, rows: Array | None = None
) -> InsensitiveDirections:
    """Return rank and null space of scaled slopes (n, p) of curves in the named parameters.

    If equations with scaled gradients `rows` (k, p) constrain the parameters, the null space is
    restricted to them.
    """
    _, values, right = np.linalg.svd(columns, full_matrices=len(columns) < len(names))
    limit = RANK_TOLERANCE * values[0]
    rank = int((values > limit).sum())
    space = right[rank:]
    zero: Flags = np.linalg.norm(columns, axis=0) <= limit
    if rows is not None:
        rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        space = space.T @ scipy.linalg.null_space(rows @ space.T, RANK_TOLERANCE)
        space, zero = space.T, zero & (np.abs(rows).max(axis=0) <= RANK_TOLERANCE)
    return InsensitiveDirections(rank, _name_directions(names, space, zero), zero, space)


def _name_directions(names: tuple[str, ...], space: Array, zero: Flags) -> list[dict[str, float]]:
    """Return a sparse basis of the null space: single parameters first, then reduced
    combinations.
    """
    single: list[dict[str, float]] = [{names[j]: 1.0} for j in np.flatnonzero(zero)]
    mixed = _reduce_echelon(np.where(zero, 0.0, space), len(space) - len(single))
    return single + [
        {names[j]: float(row[j]) for j in np.flatnonzero(np.abs(row) > WEIGHT_TOLERANCE)}
        for row in mixed
    ]


def _reduce_echelon(space: Array, count: int) -> list[Array]:
    """Return the first `count` rows of the echelon form with complete pivoting, scaled to a largest
    weight of 1.
    """
    rows = space.copy()
    for i in range(count):
        pivot, column = (
            int(k) for k in np.unravel_index(np.abs(rows[i:]).argmax(), rows[i:].shape)
        )
        rows[[i, i + pivot]] = rows[[i + pivot, i]]
        rows[i] /= rows[i, column]
        is_other_row = np.arange(len(rows)) != i
        rows[is_other_row] -= np.outer(rows[is_other_row, column], rows[i])
    return [row / row[np.abs(row).argmax()] for row in rows[:count]]
