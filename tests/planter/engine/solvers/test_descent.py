"""Local minima from one start: known optima, ties, kinks, odd N, both objectives, exact bounds."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog, minimize_scalar

from planter.engine.solvers.local_search import search_locally
from planter.engine.solvers.objective import find_tops
from planter.engine.solvers.sampled_cycle import sample_angles
from tests.planter.engine.solvers import toys
from tests.support.sampled import sampled


@pytest.mark.parametrize("sampling", [360, "refined"])
@pytest.mark.parametrize("start", [0.0, 0.3, 1.0])
def test_third_harmonic_injection(sampling, start):
    """Least range of cos phi + x cos 3 phi: sqrt 3 at x = -1/6, several peaks tied."""
    problem = toys.over_turn(toys.third_harmonic(), toys.RANGE, sampling)
    optimum = search_locally(problem, np.array([start]))
    assert toys.find_range(optimum.evaluation.summary) == pytest.approx(np.sqrt(3), abs=1e-8)
    if sampling == "refined":
        assert problem.design(optimum.u) == pytest.approx([-1 / 6], abs=1e-5)
    assert optimum.stationary


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("samples", [40, 41])
def test_a_linear_force_agrees_with_linear_programming(seed, samples):
    toy, constant, slopes = toys.linear(seed)
    problem = toys.over_turn(toy, toys.RANGE, samples)
    optimum = search_locally(problem, problem.start)
    basis = toys.waves(sample_angles(samples, toy.period))
    rows, level = basis @ slopes, basis @ constant
    ones = np.ones((samples, 1))
    matrix = np.vstack([np.hstack([rows, -ones, 0 * ones]), np.hstack([-rows, 0 * ones, ones])])
    oracle = linprog(
        [0, 0, 0, 1, -1],
        matrix,
        np.append(-level, level),
        bounds=[(-1, 1)] * 3 + [(None, None)] * 2,
    )
    assert toys.find_range(optimum.evaluation.summary) == pytest.approx(oracle.fun, abs=1e-7)
    assert optimum.stationary


def test_refined_ties_are_sharper_than_samples():
    """True extremes tie at the optimum of a linear force: as many as hold a vertex of three
    parameters.
    """
    toy, _, _ = toys.linear(1)
    problem = toys.over_turn(toy, toys.RANGE, "refined")
    optimum = search_locally(problem, problem.start)
    assert optimum.stationary
    conditions = problem.conditions(optimum.u)
    tops = find_tops(conditions.rows, conditions.groups, 2)
    assert (conditions.rows > tops[conditions.groups] - 1e-6).sum() > 2
    fine = toys.over_turn(toy, toys.RANGE, 2000)
    assert fine.evaluate(optimum.u).objective == pytest.approx(
        optimum.evaluation.objective, abs=1e-4
    )
    assert search_locally(fine, optimum.u).evaluation.objective <= optimum.evaluation.objective


@pytest.mark.parametrize(
    ("kind", "sampling", "weights"),
    sampled(
        [("paper", 12, (0.0, 1.0)), ("newton", 13, (0.3, 1.0)), ("paper", "refined", (0.3, 1.0))],
        product(["paper", "newton"], [12, 13, "refined"], [(0.0, 1.0), (0.3, 1.0)]),
    ),
)
def test_a_corner_agrees_with_a_search_of_the_line(kind, sampling, weights):
    """One parameter, kinks in x wherever the corner passes a sample: a fine scan finds nothing
    better.
    """
    problem = toys.over_turn(toys.corner(), toys.Weights(*weights, kind), sampling)
    scan = min((problem.evaluate(np.array([u])).objective, u) for u in np.linspace(0, 1, 201))
    minimum = minimize_scalar(
        lambda u: problem.evaluate(np.array([u])).objective,
        bounds=(max(scan[1] - 0.005, 0), min(scan[1] + 0.005, 1)),
        method="bounded",
        options={"xatol": 1e-12},
    )
    optima = [search_locally(problem, np.array([start])) for start in (0.05, 0.35, 0.65, 0.95)]
    best = min(optima, key=lambda m: m.evaluation.objective)
    assert best.evaluation.objective <= min(minimum.fun, scan[0]) + 1e-9
    assert best.stationary


def test_optimum_on_a_kink_is_located():
    problem = toys.over_turn(toys.corner(), toys.VARIANCE, 12)
    optimum = search_locally(problem, problem.start)
    assert optimum.stationary
    gaps = np.abs(problem.objective.parts[0].angles[:, None] - problem.design(optimum.u))
    assert gaps.min() < 1e-8


@pytest.mark.parametrize(
    ("sampling", "side"),
    [(16, 21), (17, 41), ("refined", 15), pytest.param("refined", 41, marks=pytest.mark.long)],
)
def test_two_parameter_corner_equals_plane_search(sampling, side):
    """The corner's place depends on both, not linearly; many kinks, peaks that tie: no point of a
    grid is better.
    """
    problem = toys.over_turn(toys.bent(), toys.PAPER, sampling)
    starts = [np.array([a, b]) for a in (0.2, 0.8) for b in (0.2, 0.8)]
    optima = [search_locally(problem, start) for start in starts]
    assert all(minimum.stationary for minimum in optima)
    line = np.linspace(0, 1, side)
    scan = min(problem.evaluate(np.array([a, b])).objective for a in line for b in line)
    assert min(minimum.objective for minimum in optima) <= scan


@pytest.mark.parametrize(
    ("sampling", "kind", "model"),
    sampled(
        [(361, "paper", "exact"), (90, "newton", "printed"), ("refined", "newton", "exact")],
        product([361, 90, "refined"], ["paper", "newton"], ["exact", "printed"]),
    ),
)
def test_machine_is_optimised_within_bounds(sampling, kind, model):
    problem = toys.problem(sampling, toys.Weights(0.6, 0.4, kind), model)
    optimum = search_locally(problem, problem.start)
    assert optimum.stationary
    assert optimum.evaluation.objective < problem.reference.objective
    x, response = problem.design(optimum.u), problem.objective.parts[0].response
    assert ((response.lower <= x) & (x <= response.upper)).all()
    is_at_bound = (optimum.u == 0) | (optimum.u == 1)
    assert is_at_bound.sum() >= 4
    assert np.isin(x[is_at_bound], np.concatenate([response.lower, response.upper])).all()


def test_a_refined_optimum_does_not_depend_on_a_grid():
    problem = toys.problem("refined")
    optimum = search_locally(problem, problem.start)
    fine = toys.problem(20000)
    assert fine.evaluate(optimum.u).objective == pytest.approx(
        optimum.evaluation.objective, rel=1e-6
    )
    for j in problem.free:
        neighbour = optimum.u.copy()
        neighbour[j] += 1e-3 if optimum.u[j] == 0 else -1e-3
        assert fine.evaluate(neighbour).objective > fine.evaluate(optimum.u).objective
