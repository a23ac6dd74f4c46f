"""Linear systems of graphs against NumPy and closed forms: values, derivatives, senses, and what is
singular.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from planter.kernels.elimination import InertiaFactor, solve_system

Pattern = NDArray[np.bool_]
RANDOM = [(1, 1.0), (2, 1.0), (3, 1.0), (6, 1.0), (12, 0.3), (18, 0.2), (30, 0.08)]


def build_system(pattern: Pattern) -> tuple[ca.SX, ca.SX, ca.SX]:
    """A matrix of symbols where a pattern has entries, these symbols, and a right-hand side."""
    entries = ca.SX.sym("a", int(pattern.sum()))
    matrix = ca.SX(*pattern.shape)
    for k, (i, j) in enumerate(zip(*np.nonzero(pattern), strict=True)):
        matrix[int(i), int(j)] = entries[k]
    return matrix, entries, ca.SX.sym("b", len(pattern))


def draw_pattern(size: int, density: float, seed: int) -> Pattern:
    """A random pattern that has a matching, in no order."""
    rng = np.random.default_rng(seed)
    pattern: Pattern = (rng.random((size, size)) < density) | np.eye(size, dtype=bool)[
        rng.permutation(size)
    ]
    return pattern


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("size", "density"), RANDOM)
def test_solution_and_senses_agree_with_numpy(size: int, density: float, seed: int) -> None:
    pattern = draw_pattern(size, density, seed)
    matrix, entries, right = build_system(pattern)
    solved = solve_system(matrix, right)
    function = ca.Function("f", [entries, right], [solved.solution, solved.senses, solved.pivot])
    rng, signs = np.random.default_rng(seed), set()
    for _ in range(8):
        values, b = rng.normal(size=int(pattern.sum())), rng.normal(size=size)
        full = np.zeros((size, size))
        full[np.nonzero(pattern)] = values
        solution, senses, pivot = (np.asarray(part)[:, 0] for part in function(values, b))
        assert np.abs(full @ solution - b).max() <= 1e-12 * max(
            1.0, np.abs(full).max() * np.abs(solution).max()
        )
        assert 0 < pivot[0] <= 1
        signs.add(float(np.prod(senses) * np.sign(np.linalg.det(full))))
    assert len(signs) == 1, "the sign of the determinant, up to a fixed factor"


def test_rows_are_exchanged_where_the_diagonal_vanishes() -> None:
    matrix, entries, right = build_system(np.ones((2, 2), dtype=bool))
    solved = solve_system(matrix, right)
    function = ca.Function("f", [entries, right], [solved.solution, solved.pivot])
    for small in (0.0, 1e-17, -1e-9):
        solution, pivot = function([small, 1.0, 1.0, 1.0], [1.0, 2.0])
        exact = 1 / (1 - small)
        assert np.asarray(solution)[:, 0] == pytest.approx(
            [exact, (1 - 2 * small) * exact], rel=1e-15
        )
        assert float(pivot) > 0.5


def test_derivatives_are_those_of_the_inverse() -> None:
    """d(A^-1 b) = -A^-1 dA x + A^-1 db, and second derivatives along a line by the same law
    twice.
    """
    pattern = draw_pattern(9, 0.35, 4)
    matrix, entries, right = build_system(pattern)
    rng, count = np.random.default_rng(2), int(pattern.sum())
    start, change, b = rng.normal(size=count), rng.normal(size=count), rng.normal(size=9)
    s = ca.SX.sym("s")
    moved = ca.substitute(
        [matrix, right], [entries, right], [ca.DM(start) + s * ca.DM(change), ca.SX(ca.DM(b))]
    )
    solution = solve_system(*moved).solution
    first = ca.jacobian(solution, s)
    function = ca.Function("f", [s], [solution, first, ca.jacobian(first, s)])
    x, dx, ddx = (np.asarray(part)[:, 0] for part in function(0.0))
    full, slope = np.zeros((2, 9, 9))
    full[np.nonzero(pattern)], slope[np.nonzero(pattern)] = start, change
    expected = -np.linalg.solve(full, slope @ x)
    assert dx == pytest.approx(expected, rel=1e-10)
    assert ddx == pytest.approx(-2 * np.linalg.solve(full, slope @ expected), rel=1e-9)


def test_systems_that_can_be_solved_alone_are() -> None:
    """Five pairs, each of which needs the one before: a sense each, and operations that grow with
    their number.
    """
    pattern = np.kron(
        np.eye(5, dtype=bool) | np.eye(5, k=-1, dtype=bool), np.ones((2, 2), dtype=bool)
    )
    rng = np.random.default_rng(3)
    matrix, _, right = build_system(pattern[rng.permutation(10)][:, rng.permutation(10)])
    solved = solve_system(matrix, right)
    assert solved.senses.numel() == 5
    alone = solve_system(*build_system(np.ones((2, 2), dtype=bool))[::2])
    assert _count(solved.solution) < 8 * _count(alone.solution)
    dense = solve_system(*build_system(np.ones((10, 10), dtype=bool))[::2])
    assert _count(dense.solution) > 3 * _count(solved.solution), (
        "a tampered case: nothing can be solved alone"
    )


def _count(graph: ca.SX) -> int:
    symbols = ca.symvar(graph)
    return int(ca.Function("f", symbols, [graph]).n_instructions())


@pytest.mark.parametrize("size", [1, 2, 5])
def test_singular_matrix_has_pivot_zero(size: int) -> None:
    matrix, entries, right = build_system(np.ones((size, size), dtype=bool))
    function = ca.Function("f", [entries, right], [solve_system(matrix, right).pivot])
    ones = np.ones(size * size)
    assert float(function(ones * (size > 1), np.ones(size))) == 0
    assert float(function(np.eye(size).ravel(), np.ones(size))) == 1


def test_pattern_without_matching_has_pivot_zero() -> None:
    matrix, _, right = build_system(np.array([[1, 1, 0], [1, 1, 0], [1, 1, 0]], dtype=bool))
    solved = solve_system(matrix, right)
    assert float(ca.DM(solved.pivot)) == 0
    assert not np.isfinite(np.asarray(ca.DM(solved.solution))).any()


@pytest.mark.parametrize("is_symmetric", [True, False])
def test_inertia_of_two_branches(is_symmetric: bool) -> None:
    """Two chains on one body: entries between the chains stay zero; an unsymmetric inertia is
    solved too.
    """
    pattern = np.eye(7, dtype=bool)
    pattern[0, :] = pattern[:, 0] = True
    pattern[1:4, 1:4] = pattern[4:, 4:] = True
    rng = np.random.default_rng(7)
    root = np.where(pattern, rng.normal(size=(7, 7)), 0)
    full = np.where(pattern, root + root.T, 0) + 12 * np.eye(7)
    matrix, entries, right = build_system(pattern)
    if is_symmetric:
        for i, j in zip(*np.nonzero(np.triu(pattern)), strict=True):
            matrix[int(j), int(i)] = matrix[int(i), int(j)]
    else:
        full[np.nonzero(pattern)] += 0.3 * rng.normal(size=int(pattern.sum()))
    solution = InertiaFactor(matrix).solve(right)
    function = ca.Function("f", [entries, right], [solution])
    b = rng.normal(size=7)
    assert np.asarray(function(full[np.nonzero(pattern)], b))[:, 0] == pytest.approx(
        np.linalg.solve(full, b), rel=1e-12
    )
    if is_symmetric:
        dense, _, forces = build_system(np.ones((7, 7), dtype=bool))
        mirrored = ca.triu2symm(ca.triu(dense))
        assert _count(solution) < 0.7 * _count(InertiaFactor(mirrored).solve(forces))
