"""Constraints that cannot hold together: sets by hand, and minimality on random linear systems."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
import scipy

from planter.engine.solvers.conflict import Conflict, find_conflict
from planter.engine.solvers.constraints import DesignBox, NamedConstraint
from planter.engine.solvers.expressions import (
    SmoothObjective,
    SymbolicConstraints,
    SymbolicFunction,
)
from planter.engine.solvers.feasibility import (
    approach_limits,
    minimise_violation,
)
from planter.engine.solvers.problem import Problem
from planter.kernels import Array


def build_linear_problem(matrix: Array, lower: Array, widths: Array) -> Problem:
    """Least |x|^2 with matrix x >= lower, x in a box from 0 to its widths; steps are 1, 2, 3 ..."""
    count, size = matrix.shape
    x, steps = ca.SX.sym("x", size), np.arange(1.0, count + 1)
    kinds = [NamedConstraint(f"row {k}", step=float(step)) for k, step in enumerate(steps.tolist())]
    rows = ca.DM(matrix / steps[:, None]) @ x
    bounds = lower / steps, np.full(count, np.inf)
    names = tuple(f"x{k}" for k in range(size))
    box = DesignBox.shares(names, np.zeros(size), widths, widths / 2)
    objective = SmoothObjective(SymbolicFunction(x, ca.sumsqr(x)), size)
    constraints = SymbolicConstraints(x, rows, bounds, kinds, np.arange(count))
    return Problem(objective, box, constraints)


def explain(problem: Problem) -> Conflict | None:
    assert problem.constraints is not None
    minimum = minimise_violation(problem, problem.constraints, problem.start)
    return find_conflict(problem, problem.constraints, minimum.u)


def is_solvable(problem: Problem, kinds: list[int], bounds: list[tuple[int, str]]) -> bool:
    """Whether some rows and some bounds of a linear problem have a common point."""
    c = problem.constraints
    assert c is not None
    matrix, free = c.slopes(problem.box.design), [[None, None] for _ in problem.box.names]
    for index, side in bounds:
        ends = problem.box.lower if side == "lower" else problem.box.upper
        free[index][side == "upper"] = ends[index]
    solution = scipy.optimize.linprog(
        np.zeros(matrix.shape[1]), A_ub=-matrix[kinds], b_ub=-c.lower[kinds], bounds=free
    )
    return bool(solution.status == 0)


def test_a_sum_conflicts_with_upper_bounds() -> None:
    """x + y >= 5 in a box of widths 1 and 2 lacks 2; x >= 0.5 stands in nobody's way."""
    problem = build_linear_problem(
        np.array([[1.0, 1.0], [1.0, 0.0]]), np.array([5.0, 0.5]), np.array([1.0, 2.0])
    )
    conflict = explain(problem)
    assert conflict is not None
    assert conflict.kinds == (0,)
    assert conflict.bounds == ((0, "upper"), (1, "upper"))
    amounts = {(change.index, change.side): change.amount for change in conflict.relaxations}
    assert amounts == pytest.approx({(0, ""): 2.0, (0, "upper"): 2.0, (1, "upper"): 2.0})


def test_opposite_rows_conflict_without_bounds() -> None:
    """x - y >= 1 and y - x >= 2 miss 3 together, whatever the box; the third row is idle."""
    matrix = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    conflict = explain(build_linear_problem(matrix, np.array([1.0, 0.1, 2.0]), np.full(2, 50.0)))
    assert conflict is not None
    assert (conflict.kinds, conflict.bounds) == ((0, 2), ())
    assert [change.amount for change in conflict.relaxations] == pytest.approx([3.0, 3.0])


def test_feasible_constraints_have_no_conflict() -> None:
    matrix = np.array([[1.0, 1.0]])
    assert explain(build_linear_problem(matrix, np.array([2.9]), np.array([1.0, 2.0]))) is None


@pytest.mark.parametrize("seed", range(12))
def test_conflicts_of_random_systems_are_irreducible(seed: int) -> None:
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(6, 3))
    problem = build_linear_problem(matrix, random.uniform(0.5, 3.0, 6), random.uniform(0.5, 2, 3))
    conflict, everything = explain(problem), [(j, s) for j in range(3) for s in ("lower", "upper")]
    if is_solvable(problem, list(range(6)), everything):
        assert conflict is None
        return
    assert conflict is not None
    kinds, bounds = list(conflict.kinds), list(conflict.bounds)
    assert not is_solvable(problem, kinds, bounds)
    for index in kinds:
        assert is_solvable(problem, [k for k in kinds if k != index], bounds)
    for bound in bounds:
        assert is_solvable(problem, kinds, [each for each in bounds if each != bound])


def test_search_stops_at_the_first_feasible_point() -> None:
    problem = build_linear_problem(np.array([[1.0, 1.0]]), np.array([2.0]), np.array([1.0, 2.0]))
    assert problem.constraints is not None
    start = np.array([0.0, 0.1])
    end = approach_limits(problem, problem.constraints, start, stops=True)
    assert end.is_feasible
    assert problem.is_feasible(end.u)
    nearest = approach_limits(problem, problem.constraints, start)
    assert nearest.is_feasible
    assert np.abs(end.u - nearest.u).max() > 1e-6, "it does not go on to the nearest"


def test_closest_point_names_its_constraint() -> None:
    problem = build_linear_problem(
        np.array([[1.0, 1.0], [1.0, 0.0]]), np.array([5.0, 0.5]), np.array([1.0, 2.0])
    )
    explain(problem)
    assert problem.closest is not None
    assert problem.closest.constraint == "row 0"
    assert problem.closest.violation == pytest.approx(2.0, abs=1e-6)
