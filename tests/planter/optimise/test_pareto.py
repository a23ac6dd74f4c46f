"""Range against variance."""

import casadi as ca
import numpy as np
import pytest

from planter.optimise import ipopt, pareto
from planter.optimise.local_search import search_locally
from planter.optimise.range_variance import build_range_problem as over_turn
from planter.optimise.variance import Weights
from tests.planter.optimise import toys
from tests.planter.optimise.toy import Toy


@pytest.fixture(scope="module")
def front():
    return pareto.trace_pareto_front(toys.linear(2)[0], 40, points=7)


def test_the_front_falls_and_no_design_beats_it(front):
    ranges = [point.evaluation.look.range for point in front]
    variances = [point.evaluation.look.variance for point in front]
    assert len(front) >= 6
    assert ranges == sorted(ranges)
    assert variances == sorted(variances, reverse=True)
    turn = over_turn(toys.linear(2)[0], toys.RANGE, 40).objective.turn
    for x in np.random.default_rng(0).uniform(-1, 1, (300, 3)):
        look = turn.look(x)
        assert all(
            r < look.high - look.low or v < look.variance
            for r, v in zip(ranges, variances, strict=True)
        )


def test_weighted_sums_lie_on_or_above_it(front):
    """For a linear force the problem is convex, so that the front is too: an optimum of weights
    touches it.
    """
    ranges = [point.evaluation.look.range for point in front]
    variances = [point.evaluation.look.variance for point in front]
    problem = over_turn(toys.linear(2)[0], Weights(0.3, 1.0, "paper"), 40)
    evaluation = search_locally(problem, problem.start).evaluation
    on_front = np.interp(evaluation.look.range, ranges, variances)
    assert evaluation.look.variance == pytest.approx(on_front, rel=0.02)
    assert evaluation.look.variance <= on_front * (1 + 1e-9)


def test_points_are_evenly_spaced_in_range(front):
    steps = np.diff([point.evaluation.look.range for point in front])
    assert steps == pytest.approx(np.full(len(steps), steps.mean()), rel=1e-3)


def test_caps_without_an_optimum_are_left_out(monkeypatch):
    solve = ipopt.solve_program

    def stuck(programme, start, iterations, compiled=None, options=None):
        if isinstance(programme, pareto.CappedEpigraph) and programme.g_upper[-1] > stuck.limit:
            return solve(programme, start, 0)
        return solve(programme, start, iterations)

    points = pareto.trace_pareto_front(toys.linear(2)[0], 40, points=4)
    toy = over_turn(toys.linear(2)[0], toys.RANGE, 40)
    stuck.limit = points[1].evaluation.look.range * 1.001 - toy.reference.look.range
    monkeypatch.setattr(ipopt, "solve_program", stuck)
    assert len(pareto.trace_pareto_front(toys.linear(2)[0], 40, points=4)) == 2 < len(points)


@pytest.mark.parametrize("sampling", [40, "refined"])
def test_design_best_in_both_is_the_front(sampling):
    """(2 + x) cos phi: range and variance are least at the same bound."""
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 1)
    (only,) = pareto.trace_pareto_front(
        Toy(phi, x, (2 + x) * ca.cos(phi), lower=[-0.5], upper=[0.4]), sampling, points=5
    )
    assert only.design == pytest.approx([-0.5], abs=1e-9)
    assert only.evaluation.look.range == pytest.approx(3.0, rel=1e-9)
