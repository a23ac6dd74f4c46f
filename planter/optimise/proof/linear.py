"""Simultaneous linear equations of balls, or of jets, in every lane."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from planter.optimise.proof.balls import Ball, Unbounded, products
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space, join_parts, packing

ROUNDS = 2
"""So often solutions over a box are formed, each time from those before, which their derivatives have narrowed."""


class BallSolver:
    """Solves simultaneous equations whose matrix (k, k) is one of balls (lanes,), about the identity.

    Raises Unbounded where the matrix may be singular.
    """

    def __init__(self, matrix: Sequence[Sequence[Ball]]) -> None:
        size, lanes = len(matrix), max(ball.mid.shape[-1] for row in matrix for ball in row)
        unit = [[Ball.exact(np.full(lanes, float(i == j))) for j in range(size)] for i in range(size)]
        self._inverse = _eliminate(matrix, unit)

    def solve(self, right: Sequence[Ball]) -> list[Ball]:
        """Return the unknowns (k,) for right sides (k,) of balls (..., lanes)."""
        return [row[0] for row in multiply(self._inverse, [[ball] for ball in right])]


def invert_centre(matrix: Sequence[Sequence[Jet]]) -> list[list[Jet]]:
    """Return the inverse (k, k) of a matrix's midpoints at the centre of the box. NaN in lanes where there is none.

    Raises Unbounded where that is so in every lane.
    """
    lanes = max(jet.lanes for row in matrix for jet in row)
    midpoints = np.array([[np.broadcast_to(jet.value.mid[CENTRE], lanes) for jet in row] for row in matrix])
    matrices = midpoints.transpose(2, 0, 1)
    with np.errstate(all="ignore"):
        is_regular = np.isfinite(matrices).all(axis=(1, 2)) & (np.linalg.det(matrices) != 0)
    if not is_regular.any():
        raise Unbounded("a matrix is singular")
    inverse = np.full(matrices.shape, np.nan)
    inverse[is_regular] = np.linalg.inv(matrices[is_regular])
    inverse = inverse.transpose(1, 2, 0)
    return [[matrix[0][0].space.constant(Ball.exact(entry)) for entry in row] for row in inverse]


def multiply(one: Sequence[Sequence[Any]], two: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Return the product (k, m) of two matrices of jets, or of balls."""
    return [[_sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*two, strict=True)] for row in one]


def solve(space: Space, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Jet]:
    """Return the solution y (k,) of simultaneous equations A y = b of jets and numbers over a box.

    Its derivatives solve A y' = b' - A' y and A y'' = b'' - A'' y - 2 A' y'. Raises Unbounded where the matrix may be
    singular.
    """
    jets = [[space.lift(entry) for entry in (*row, value)] for row, value in zip(matrix, right, strict=True)]
    felt = tuple(sorted({k for row in jets for jet in row for k in jet.felt}))
    jets = [[jet.over(felt) for jet in row] for row in jets]
    jets = multiply(invert_centre([row[:-1] for row in jets]), jets)
    rows, sides = [row[:-1] for row in jets], [row[-1] for row in jets]
    parts = (CENTRE, ANYWHERE)
    solvers = [BallSolver([[jet.value[part] for jet in row] for row in rows]) for part in parts]
    values = [solvers[part].solve([jet.value[part] for jet in sides]) for part in parts]
    low, high = packing(len(felt))
    solution: list[Jet] = []
    for _ in range(ROUNDS):
        slopes = [
            solvers[part].solve([
                side.gradient[part] - _sum(a.gradient[part] * y for a, y in zip(row, values[part], strict=True))
                for row, side in zip(rows, sides, strict=True)
            ])
            for part in parts
        ]  # fmt: skip
        y, slope = values[ANYWHERE], slopes[ANYWHERE]
        bends = solvers[ANYWHERE].solve([
            side.hessian - _sum(
                products((a.hessian, y[j]), (a.gradient[ANYWHERE][low], slope[j][high]),
                         (a.gradient[ANYWHERE][high], slope[j][low]))
                for j, a in enumerate(row)
            )
            for row, side in zip(rows, sides, strict=True)
        ])  # fmt: skip
        solution = [
            Jet(space, felt, join_parts(*value), join_parts(*slope), bend).cut()
            for value, slope, bend in zip(zip(*values, strict=True), zip(*slopes, strict=True), bends, strict=True)
        ]
        if not felt:
            break
        values = [[jet.value[part] for jet in solution] for part in parts]
    return solution


def _eliminate(matrix: Sequence[Sequence[Ball]], right: Sequence[Sequence[Ball]]) -> list[list[Ball]]:
    """Return the solutions (k, m) of equations with right sides (k, m), by elimination without pivoting."""
    size = len(matrix)
    rows = [[*row, *sides] for row, sides in zip(matrix, right, strict=True)]
    for k in range(size):
        for i in range(k + 1, size):
            share = rows[i][k] / rows[k][k]
            rows[i] = [
                *rows[i][: k + 1],
                *(a - share * b for a, b in zip(rows[i][k + 1 :], rows[k][k + 1 :], strict=True)),
            ]
    solution: list[list[Ball]] = []
    for k in reversed(range(size)):
        values = rows[k][size:]
        for place, known in enumerate(solution):
            values = [value - rows[k][size - 1 - place] * y for value, y in zip(values, known, strict=True)]
        solution.append([value / rows[k][k] for value in values])
    return solution[::-1]


def _sum(terms: Any) -> Any:
    return reduce(add, terms)
