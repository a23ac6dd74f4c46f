"""Linear systems of graphs, solved at every place: sparse elimination whose pivots are chosen where
it runs.

The blocks that can be solved alone, as single closed loops can, are solved one after the other
(Dulmage and Mendelsohn, Canadian Journal of Mathematics 10, 1958). In a block the order of the
columns is fixed, by the least fill-in for any choice of rows (George and Ng, SIAM Journal on
Scientific and Statistical Computing 8, 1987); the row with the largest entry of a column is brought
up by selection, since a row that is a good pivot at one angle is none at another.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

Row = dict[int, ca.SX]
DEPTH = 1_000_000
"""Nested operations to which entries across the diagonal are compared."""


@dataclass(frozen=True)
class Elimination:
    """A solved system of n equations: `solution` (n, m), `senses` (b,) and `pivot` (1,), graphs of
    the matrix.

    `senses` has the sign of the determinant of each block that is solved alone, up to a fixed
    factor of 1 or -1. `pivot` is the least pivot over the largest entry of its column: zero where
    the matrix is singular, as it is at dead points. The solution is not finite there.
    """

    solution: ca.SX
    senses: ca.SX
    pivot: ca.SX


def solve_system(matrix: ca.SX, right: ca.SX) -> Elimination:
    """Return the solution x of ``matrix x = right`` for a square matrix (n, n) and right-hand sides
    (n, m).
    """
    matrix = ca.sparsify(matrix)
    if ca.sprank(matrix) < matrix.size2():  # whatever its entries are
        return Elimination(ca.SX(ca.DM.nan(right.shape)), ca.SX(0), ca.SX(0))
    _, row_order, column_order, row_bounds, column_bounds, *_ = matrix.sparsity().btf()
    largest = [ca.norm_inf(ca.densify(matrix[:, j])) for j in range(matrix.size2())]
    sizes = [size + (size == 0) for size in largest]  # of a column of zeros the share is 0, not 0/0
    solution = ca.SX(right.size1(), right.size2())
    senses, pivot = [], ca.SX(1)
    bounds = zip(
        row_bounds[:-1], row_bounds[1:], column_bounds[:-1], column_bounds[1:], strict=True
    )
    for (
        first,
        last,
        left,
        end,
    ) in bounds:  # CasADi's form is lower triangular: the first block needs no other
        rows, columns = row_order[first:last], column_order[left:end]
        remainder = right[rows, :] - matrix[rows, :] @ solution
        block = _Block(matrix[rows, columns], remainder)
        solution[columns, :] = block.solve()
        senses.append(block.sense)
        for column, entry in zip(columns, block.pivots, strict=True):
            pivot = ca.fmin(pivot, ca.fabs(entry) / sizes[column])
    return Elimination(ca.densify(solution), ca.vertcat(*senses), pivot)


class InertiaFactor:
    """An inertia (k, k), factored once for many right-hand sides: by L D L^T, which needs no pivots,
    if it is symmetric.

    The inertia of a mechanism is positive definite; actions that depend on accelerations may make
    it unsymmetric. `pivot` (1,) is the least pivot over the largest, zero where it is singular.
    """

    def __init__(self, inertia: ca.SX) -> None:
        self._inertia = ca.sparsify(inertia)
        self.pivot, self._factors = ca.SX(1), None
        if not inertia.size2():
            return
        if ca.sprank(self._inertia) == inertia.size2() and self._is_symmetric():
            self._factors = ca.ldl(self._inertia)
            diagonal = ca.densify(self._factors[0])
            self.pivot = ca.mmin(diagonal) / ca.mmax(ca.fabs(diagonal))
        else:
            self.pivot = solve_system(self._inertia, ca.SX(inertia.size1(), 1)).pivot

    def _is_symmetric(self) -> bool:
        return bool(ca.is_equal(self._inertia, self._inertia.T, DEPTH))

    def solve(self, right: ca.SX) -> ca.SX:
        """Return x (k, m) of ``inertia x = right``."""
        if self._factors is None:
            return solve_system(self._inertia, right).solution
        return ca.densify(ca.ldl_solve(ca.densify(right), *self._factors))


class ConstrainedFactor:
    """Inertia (k, k) and slopes (c, k) of constraints that do not follow from each other, factored
    once for many right-hand sides.

    `pivot` (1,) is the least pivot of the constraints over the largest: 1 without constraints, zero
    where they depend on each other. A `weight` adds it times slopes^T slopes to an inertia that does
    not resist what constraints forbid, as of quaternions; what it adds the right-hand side takes
    away again.
    """

    def __init__(self, inertia: ca.SX, slopes: ca.SX, weight: float = 0.0) -> None:
        self._slopes, self._weight = slopes, weight
        added = weight * (slopes.T @ slopes) if weight else 0
        self._mass = InertiaFactor(inertia + added)
        self._carried = self._mass.solve(slopes.T) if slopes.size1() else slopes.T
        self._coupling = InertiaFactor(slopes @ self._carried)
        self.pivot = self._coupling.pivot

    def solve(self, push: ca.SX, bend: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return x (k, m), y (c, m) of ``inertia x - slopes^T y = push`` and ``slopes x = bend``."""
        if not self._slopes.size1():
            return self._mass.solve(push), bend
        added = self._weight * (self._slopes.T @ bend) if self._weight else 0
        free = self._mass.solve(push + added)
        multipliers = self._coupling.solve(bend - self._slopes @ free)
        return free + self._carried @ multipliers, multipliers


class _Block:
    """A block that cannot be divided; `pivots` has that of each column, `sense` the sign of their
    product.
    """

    def __init__(self, matrix: ca.SX, right: ca.SX) -> None:
        count = matrix.size1()
        self._rows = [_read_row(matrix, i) for i in range(count)]
        self._right = [right[i, :] for i in range(count)]
        self._active = set(range(count))
        self.pivots = [ca.SX(0)] * count
        self.sense = ca.SX(1)

    def solve(self) -> ca.SX:
        """Return the unknowns (n, m)."""
        columns, order = set(range(len(self._rows))), []
        while columns:
            column = min(columns, key=lambda j: (self._count_fill(j), j))
            columns.remove(column)
            order.append((column, self._eliminate(column)))
        unknowns = [ca.SX(0)] * len(order)
        for column, row in reversed(order):
            remainder = self._right[row]
            for j, entry in self._rows[row].items():
                if j != column:
                    remainder = remainder - entry * unknowns[j]
            unknowns[column] = remainder / self.pivots[column]
        return ca.vertcat(*unknowns)

    def _find_candidates(self, column: int) -> list[int]:
        return [i for i in sorted(self._active) if column in self._rows[i]]

    def _count_fill(self, column: int) -> int:
        """Return the most products that elimination of a column takes, whichever of its rows is the
        pivot.
        """
        candidates = self._find_candidates(column)
        width = len(set().union(*(self._rows[i].keys() for i in candidates)))
        return (len(candidates) - 1) * width

    def _eliminate(self, column: int) -> int:
        """Eliminate a column from all active rows but one, and return that one."""
        pivot, *other_rows = self._find_candidates(column)
        self._active.remove(pivot)
        for other in other_rows:
            self._exchange(pivot, other, column)
        self.pivots[column] = self._rows[pivot][column]
        self.sense = self.sense * ca.sign(self.pivots[column])
        for other in other_rows:
            share = self._rows[other].pop(column) / self.pivots[column]
            for j, entry in self._rows[pivot].items():
                if j != column:
                    self._rows[other][j] = self._rows[other].get(j, ca.SX(0)) - share * entry
            self._right[other] = self._right[other] - share * self._right[pivot]
        return pivot

    def _exchange(self, pivot: int, other: int, column: int) -> None:
        """Exchange two rows where the entry of the other one in a column is larger."""
        above, below = self._rows[pivot], self._rows[other]
        is_larger = ca.fabs(below[column]) > ca.fabs(above[column])
        self.sense = ca.if_else(is_larger, -self.sense, self.sense)
        for j in sorted(above.keys() | below.keys()):
            upper, lower = above.get(j, ca.SX(0)), below.get(j, ca.SX(0))
            above[j], below[j] = (
                ca.if_else(is_larger, lower, upper),
                ca.if_else(is_larger, upper, lower),
            )
        upper, lower = self._right[pivot], self._right[other]
        self._right[pivot] = ca.if_else(is_larger, lower, upper)
        self._right[other] = ca.if_else(is_larger, upper, lower)


def _read_row(matrix: ca.SX, row: int) -> Row:
    pattern = matrix.sparsity()
    return {j: matrix[row, j] for j in range(matrix.size2()) if pattern.has_nz(row, j)}
