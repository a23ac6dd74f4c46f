"""The order of elimination: what can be solved alone is, pivots hold their columns, zeros stay
zeros.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

from derive.chain import solve_linear_set
from derive.elimination import find_closure, match_rows, order_elimination
from derive.model import LinearSolve
from derive.quantity import Quantity

Pattern = NDArray[np.bool_]


def list_rows(pattern: Pattern) -> list[set[int]]:
    return [set(np.flatnonzero(row).tolist()) for row in pattern]


def count_entries(pattern: Pattern) -> int:
    """Entries of the factors for any choice of the pivots' rows, eliminated from the first column
    to the last.
    """
    filled = pattern.copy()
    for k in range(len(filled)):
        candidates = [k, *(k + 1 + np.flatnonzero(filled[k + 1 :, k]))]
        filled[candidates, k:] = filled[candidates, k:].any(axis=0)
    return int(filled.sum())


def draw_pattern(blocks: list[int], seed: int) -> tuple[Pattern, Pattern]:
    """A block triangular pattern, and the same one in no order."""
    rng = np.random.default_rng(seed)
    size = sum(blocks)
    pattern = np.zeros((size, size), dtype=bool)
    first = 0
    for width in blocks:
        last = first + width
        pattern[first:last, first:last] = True
        pattern[first:last, :first] = rng.random((width, first)) < 0.3
        first = last
    return pattern, pattern[rng.permutation(size)][:, rng.permutation(size)]


@pytest.mark.parametrize("seed", range(4))
def test_blocks_are_found_in_any_order(seed: int) -> None:
    blocks = [2, 1, 3, 1, 2, 4]
    _, shuffled = draw_pattern(blocks, seed)
    rows, columns = order_elimination(list_rows(shuffled))
    ordered = shuffled[rows][:, columns]
    ends = np.cumsum([0, *(len(b) for b in _list_blocks(shuffled))])
    below = [
        (i, j)
        for i, j in zip(*np.nonzero(ordered), strict=True)
        if np.searchsorted(ends, i, side="right") > np.searchsorted(ends, j, side="right")
    ]
    assert sorted(rows) == sorted(columns) == list(range(sum(blocks)))
    assert not below
    assert sorted(np.diff(ends)) == sorted(blocks)
    assert np.diagonal(ordered).all(), "each row takes part where its column is eliminated"


def _list_blocks(pattern: Pattern) -> list[frozenset[int]]:
    """Sets of unknowns that need each other, those that need most first, by powers of the
    incidence.
    """
    pairs = match_rows(list_rows(pattern), range(len(pattern)))
    needs = pattern[[pairs[column] for column in range(len(pattern))]]
    reached = np.linalg.matrix_power(needs.astype(float), len(pattern)) > 0
    sets = {
        frozenset(np.flatnonzero(row & reached[:, j]).tolist()): int(row.sum())
        for j, row in enumerate(reached)
    }
    return sorted(sets, key=lambda block: -sets[block])


@pytest.mark.parametrize("size", [6, 20])
def test_arrow_is_eliminated_from_behind(size: int) -> None:
    """A matrix whose first row and column are full fills in completely from the first column on."""
    arrow = np.eye(size, dtype=bool)
    arrow[0, :] = arrow[:, 0] = True
    rows, columns = order_elimination(list_rows(arrow))
    assert count_entries(arrow) == size * size, "a tampered case: the given order"
    assert count_entries(arrow[rows][:, columns]) < 0.75 * size * size


def test_singular_pattern_keeps_its_order() -> None:
    assert order_elimination([{0, 1}, {0, 1}, {0}]) == ([0, 1, 2], [0, 1, 2])


def test_closure_lacks_what_has_no_equation() -> None:
    assert find_closure("a", {"a": ["b"], "b": ["a"]}) == {"a", "b"}
    assert find_closure("a", {"a": ["b"]}) is None


def test_reordered_set_has_the_same_solution() -> None:
    """Against SymPy's own elimination; the pivot keeps the name of the first unknown."""
    unknowns = [Quantity(f"u{k}", "N", "unknown", "own") for k in range(6)]
    rng = np.random.default_rng(5)
    _, pattern = draw_pattern([2, 1, 3], 5)
    matrix = sp.Matrix(6, 6, lambda i, j: int(rng.integers(1, 9)) * int(pattern[i, j]))
    right = sp.Matrix([int(value) for value in rng.integers(1, 9, 6)])
    residuals = list(matrix * sp.Matrix(unknowns) - right)
    (step,) = solve_linear_set(residuals, unknowns, "own")
    assert isinstance(step, LinearSolve)
    assert step.pivot.name == "pivot_u0"
    solution = dict(
        zip(step.symbols, sp.Matrix(step.matrix).LUsolve(sp.Matrix(step.right)), strict=True)
    )
    assert [solution[unknown] for unknown in unknowns] == list(matrix.LUsolve(right))
