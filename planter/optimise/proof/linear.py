"""Simultaneous linear equations of jets, or of balls, in every lane: preconditioned, then eliminated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.optimise.proof.balls import Ball, Unbounded
from planter.optimise.proof.jets import CENTRE, Jet, Space


def eliminate(matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Any]:
    """Return the solution (k,) of simultaneous equations of jets, or of balls, by elimination without pivoting."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    size = len(rows)
    for k in range(size):
        for i in range(k + 1, size):
            share = rows[i][k] / rows[k][k]
            rows[i] = [*rows[i][: k + 1], *(rows[i][j] - share * rows[k][j] for j in range(k + 1, size + 1))]
    solution: list[Any] = []
    for k in reversed(range(size)):
        value = rows[k][size]
        for place, known in enumerate(solution):
            value = value - rows[k][size - 1 - place] * known
        solution.append(value / rows[k][k])
    return solution[::-1]


def solve(space: Space, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Any]:
    """Return the solution (k,) of simultaneous equations of jets and numbers over a box.

    Equations are multiplied by the inverse of the matrix's midpoints at the centre of the box: about the identity is
    left, which needs no pivoting. Raises Unbounded where the matrix may be singular.
    """
    jets = [[space.lift(entry) for entry in (*row, value)] for row, value in zip(matrix, right, strict=True)]
    lanes = max(jet.lanes for row in jets for jet in row)
    scale = find_preconditioner([[jet.value.mid[CENTRE] for jet in row[:-1]] for row in jets], lanes)
    if scale is not None:
        jets = [
            [_sum(_scaled(jet, scale[:, i, j]) for j, jet in enumerate(column)) for column in zip(*jets, strict=True)]
            for i in range(len(jets))
        ]
    return eliminate([row[:-1] for row in jets], [row[-1] for row in jets])


def find_preconditioner(midpoints: Sequence[Sequence[Array]], lanes: int) -> Array | None:
    """Return inverses (lanes, k, k) of matrices (k, k) of arrays, or None for a single unknown."""
    if len(midpoints) == 1:
        return None
    matrix = np.array([[np.broadcast_to(entry, lanes) for entry in row] for row in midpoints]).transpose(2, 0, 1)
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        raise Unbounded("a matrix is singular") from None
    if not np.isfinite(inverse).all():
        raise Unbounded("a matrix is singular")
    return inverse


def scale_rows(scale: Array | None, rows: Sequence[Sequence[Ball]]) -> list[list[Ball]]:
    """Return rows (k, m) of balls, multiplied from the left by matrices (lanes, k, k)."""
    if scale is None:
        return [list(row) for row in rows]
    size = len(rows)
    return [
        [_sum(Ball.exact(scale[:, i, j]) * rows[j][m] for j in range(size)) for m in range(len(rows[0]))]
        for i in range(size)
    ]


def _scaled(jet: Jet, factors: Array) -> Jet:
    return jet * jet.space.constant(Ball.exact(factors))


def _sum(terms: Any) -> Any:
    first, *others = terms
    for term in others:
        first = first + term
    return first
