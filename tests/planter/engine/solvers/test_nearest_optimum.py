"""Of equal optima the one nearest to the start is told, wherever a search ended."""

import casadi as ca
import numpy as np
import pytest

from planter.engine.solvers import result
from planter.engine.solvers.constraints import NamedConstraint
from planter.engine.solvers.expressions import SymbolicConstraints
from planter.engine.solvers.local_search import search_locally
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.toy import Toy

STARTS = ([0.1, 0.2, 0.3], [0.9, 0.8, 0.1], [0.5, 0.1, 0.9], [0.2, 0.9, 0.6])


def scaled() -> Toy:
    """Least range at x0 / x1 = 1/6, whatever their size; x2 has no effect."""
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 3)
    return Toy(
        phi,
        x,
        ca.cos(phi) - x[0] / x[1] * ca.cos(3 * phi),
        lower=[0.1, 1.0, 0.0],
        upper=[0.5, 3.0, 1.0],
    )


def limited(limit: float) -> SymbolicConstraints:
    """x1 <= most."""
    x = ca.SX.sym("x", 3)
    bounds = np.full(1, -np.inf), np.array([limit])
    return SymbolicConstraints(
        x, x[1], bounds, [NamedConstraint("limit", ("max",))], np.zeros(1, dtype=np.int64)
    )


def nearest_on_the_ray(problem) -> np.ndarray:
    """By a scan of all the optima."""
    ray = np.array([[r / 6, r, problem.box.design[2]] for r in np.linspace(1.0, 3.0, 200_001)])
    shares = (ray - problem.box.lower) / problem.box.unit
    return shares[((shares - problem.start) ** 2).sum(axis=1).argmin()]


def test_distant_searches_report_the_same_design():
    problem = toys.over_turn(scaled(), toys.RANGE, "refined")
    ends = [search_locally(problem, np.array(start)).u for start in STARTS]
    assert max(np.abs(end - ends[0]).max() for end in ends) > 1e-2
    optima = [result.select_nearest_optimum(problem, end) for end in ends]
    for u in optima:
        assert u == pytest.approx(nearest_on_the_ray(problem), abs=1e-5)
        assert problem.evaluate(u).objective == pytest.approx(
            problem.evaluate(ends[0]).objective, abs=1e-9
        )


@pytest.mark.parametrize("limit", [2.5, 1.4])
def test_the_rule_keeps_constraints(limit):
    problem = toys.over_turn(scaled(), toys.RANGE, "refined", limited(limit))
    optima = [
        result.select_nearest_optimum(problem, search_locally(problem, np.array(start)).u)
        for start in STARTS
    ]
    assert all(problem.is_feasible(u) for u in optima)
    assert max(np.abs(u - optima[0]).max() for u in optima) < 1e-5


def test_sensitive_parameters_do_not_move():
    problem = toys.over_turn(toys.third_harmonic(), toys.RANGE, "refined")
    u = search_locally(problem, np.array([0.9])).u
    assert result.select_nearest_optimum(problem, u) == pytest.approx(u, abs=0)
