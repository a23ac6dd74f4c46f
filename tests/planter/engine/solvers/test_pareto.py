"""Range against variance."""

import casadi as ca
import numpy as np
import pytest

from planter.engine.solvers import ipopt, pareto
from planter.engine.solvers.local_search import search_locally
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.toy import Toy


def trace(toy: Toy, sampling, points: int):
    """The front of a toy; the problem of the variance has the extremes with weight zero."""
    of_variance, of_range = (
        toys.over_turn(toy, weights, sampling) for weights in (toys.VARIANCE, toys.RANGE)
    )
    return pareto.trace_pareto_front(of_variance, of_range, points)


@pytest.fixture(scope="module")
def front():
    return trace(toys.linear(2)[0], 40, 7)


def test_the_front_falls_and_no_design_beats_it(front):
    ranges = [point.range for point in front]
    variances = [point.variance for point in front]
    assert len(front) >= 6
    assert ranges == sorted(ranges)
    assert variances == sorted(variances, reverse=True)
    problem = toys.over_turn(toys.linear(2)[0], toys.VARIANCE, 40)
    for u in np.random.default_rng(0).random((300, 3)):
        point = pareto.ParetoPoint.at(problem, u)
        assert not any(point.dominates(other) for other in front)


def test_weighted_sums_lie_on_or_above_it(front):
    """For a linear force the problem is convex, so that the front is too: an optimum of weights
    touches it.
    """
    problem = toys.over_turn(toys.linear(2)[0], toys.Weights(0.3, 1.0, "paper"), 40)
    optimum = search_locally(problem, problem.start)
    summary = optimum.evaluation.summary
    ranges, variances = zip(*((point.range, point.variance) for point in front), strict=True)
    on_front = np.interp(toys.find_range(summary), ranges, variances)
    assert summary.smooth == pytest.approx(on_front, rel=0.02)
    assert summary.smooth <= on_front * (1 + 1e-9)


def test_caps_without_an_optimum_are_left_out(monkeypatch):
    solve = ipopt.solve_program

    def stuck(programme, start, iterations):
        if isinstance(programme, pareto.CappedEpigraph) and programme.g_upper[-1] > stuck.limit:
            return solve(programme, start, 0)
        return solve(programme, start, iterations)

    points = trace(toys.linear(2)[0], 40, 4)
    toy = toys.over_turn(toys.linear(2)[0], toys.RANGE, 40)
    stuck.limit = points[1].range * 1.001 - toys.find_range(toy.reference.summary)
    monkeypatch.setattr(ipopt, "solve_program", stuck)
    assert len(trace(toys.linear(2)[0], 40, 4)) == 2 < len(points)


@pytest.mark.parametrize("sampling", [40, "refined"])
def test_design_best_in_both_is_the_front(sampling):
    """(2 + x) cos phi: range and variance are least at the same bound."""
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 1)
    toy = Toy(phi, x, (2 + x) * ca.cos(phi), lower=[-0.5], upper=[0.4])
    (only,) = trace(toy, sampling, 5)
    assert only.design == pytest.approx([-0.5], abs=1e-9)
    assert only.range == pytest.approx(3.0, rel=1e-9)
