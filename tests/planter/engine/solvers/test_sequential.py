"""Sequential quadratic programmes: steps, optima beside linear programming, and what they must not
trust.
"""

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import linprog

from planter.engine.solvers import certificate, sqp
from planter.engine.solvers.constraints import NamedConstraint
from planter.engine.solvers.expressions import SymbolicConstraints
from planter.engine.solvers.sampled_cycle import sample_angles
from tests.planter.engine.solvers import toys

SAMPLES = 40


def limited(toy, row, limit):
    """Constraints with row . x <= most."""
    x = ca.SX.sym("x", len(row))
    bounds = np.full(1, -np.inf), np.array([limit])
    return SymbolicConstraints(
        x,
        ca.dot(ca.DM(row), x),
        bounds,
        [NamedConstraint("limit", ("max",))],
        np.zeros(1, dtype=np.int64),
    )


@pytest.mark.parametrize("seed", range(6))
def test_quadratic_programme_satisfies_conditions(seed):
    """Stationarity, signs and complementarity, with a Hessian that leaves two variables to the
    rows.
    """
    rng = np.random.default_rng(seed)
    n, m = 8, 30
    root = rng.normal(size=(n, n - 2))
    hessian, gradient, rows, limits = (
        root @ root.T,
        rng.normal(size=n),
        rng.normal(size=(m, n)),
        rng.random(m),
    )
    low, high = np.full(n, -2.0), np.full(n, 2.0)
    step = sqp.solve_quadratic_program(hessian, gradient, rows, limits, (low, high))
    slope = hessian @ step.z + gradient + rows.T @ step.rows + step.bounds
    assert np.abs(slope).max() < 1e-6
    assert (rows @ step.z - limits).max() < 1e-8
    assert step.rows.min() > -1e-8
    assert np.abs(step.rows * (rows @ step.z - limits)).max() < 1e-6


def test_a_quadratic_programme_without_a_point_has_no_minimum():
    identity = np.ones((1, 1))
    rows, limits = np.vstack([identity, -identity]), np.array([-1.0, -1.0])
    assert (
        sqp.solve_quadratic_program(
            identity, np.zeros(1), rows, limits, (np.full(1, -9.0), np.full(1, 9.0))
        )
        is None
    )


@pytest.mark.parametrize("seed", range(5))
def test_convexified_model_has_same_constrained_steps(seed):
    rng = np.random.default_rng(seed)
    hessian, normals = rng.normal(size=(6, 6)), rng.normal(size=(3, 6))
    hessian = hessian + hessian.T
    free = np.linalg.svd(normals)[2][3:].T
    hessian += free @ (3 * np.eye(3) - free.T @ hessian @ free) @ free.T
    model = sqp._convexify(hessian, normals)
    assert np.linalg.eigvalsh(model).min() > 0
    assert free.T @ model @ free == pytest.approx(free.T @ hessian @ free, abs=1e-9)
    fixed = np.linalg.lstsq(normals, rng.normal(size=3), rcond=None)[0]
    assert free.T @ model @ fixed == pytest.approx(free.T @ hessian @ fixed, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("share", [0.2, 0.7])
def test_constrained_linear_force_equals_linear_programme(seed, share):
    toy, constant, slopes = toys.linear(seed)
    free = toys.over_turn(toy, toys.RANGE, SAMPLES)
    best = free.design(sqp.minimise_by_sqp(free, free.start).u)
    row = np.array([1.0, -2.0, 0.5])
    limit = float(row @ best - share)
    problem = toys.over_turn(toy, toys.RANGE, SAMPLES, limited(toy, row, limit))
    optimum = sqp.minimise_by_sqp(problem, np.array([0.9, 0.1, 0.6]))
    basis = toys.waves(sample_angles(SAMPLES, toy.period))
    rows, level, ones = basis @ slopes, basis @ constant, np.ones((SAMPLES, 1))
    matrix = np.vstack(
        [np.hstack([rows, -ones, 0 * ones]), np.hstack([-rows, 0 * ones, ones]), [[*row, 0, 0]]]
    )
    limits = np.concatenate([-level, level, [limit]])
    oracle = linprog([0, 0, 0, 1, -1], matrix, limits, bounds=[(-1, 1)] * 3 + [(None, None)] * 2)
    assert toys.find_range(problem.evaluate(optimum.u).summary) == pytest.approx(
        oracle.fun, abs=1e-8
    )
    assert certificate.kkt_residual(problem, optimum.u) < 1e-8
    neighbour = problem.box.inside(optimum.u + 1e-3)
    assert certificate.kkt_residual(problem, neighbour) > 1e-6


def test_low_penalty_is_raised_until_feasible(monkeypatch):
    monkeypatch.setattr(sqp, "PENALTY", 1e-6)
    toy, _, _ = toys.linear(2)
    free = toys.over_turn(toy, toys.RANGE, SAMPLES)
    row = np.array([1.0, -2.0, 0.5])
    limit = float(row @ free.design(sqp.minimise_by_sqp(free, free.start).u) - 0.5)
    problem = toys.over_turn(toy, toys.RANGE, SAMPLES, limited(toy, row, limit))
    optimum = sqp.minimise_by_sqp(problem, np.array([0.9, 0.1, 0.6]))
    assert problem.is_feasible(optimum.u)
    assert certificate.kkt_residual(problem, optimum.u) < 1e-8
    monkeypatch.setattr(sqp, "MAX_PENALTY", 1e-6)
    assert not problem.is_feasible(sqp.minimise_by_sqp(problem, np.array([0.9, 0.1, 0.6])).u)
