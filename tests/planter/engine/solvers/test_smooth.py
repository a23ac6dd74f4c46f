"""A smooth objective under inequalities and an equation: the same search, the same certificate, no
rows to bound.
"""

from __future__ import annotations

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from planter.engine.solvers.certificate import (
    check_conditions,
    estimate_multipliers,
    find_active_bounds,
    find_active_constraints,
    kkt_residual,
)
from planter.engine.solvers.constraints import DesignBox, NamedConstraint
from planter.engine.solvers.epigraph import Epigraph
from planter.engine.solvers.expressions import (
    SmoothObjective,
    SymbolicConstraints,
    SymbolicFunction,
)
from planter.engine.solvers.feasibility import find_feasible_or_nearest, minimise_violation
from planter.engine.solvers.local_search import (
    STATIONARITY_TOLERANCE,
    sample_starts,
    search_from_points,
    search_from_starts,
    search_locally,
)
from planter.engine.solvers.problem import Problem
from planter.engine.solvers.result import certify_candidates
from planter.errors import ComputationError
from planter.kernels import Array

NAMES = ("a", "b", "c")
LOWER, UPPER = np.array([-4.0, -1.0, 0.5]), np.array([6.0, 3.0, 10.0])
KINDS = (
    NamedConstraint("sum", ("equal",), "m"),
    NamedConstraint("product", unit="m2", step=0.5),
    NamedConstraint("disc", ("max",)),
)
SHORT = SimpleNamespace(
    individuals=20,
    generations=5,
    bits_per_variable=12,
    selection_ratio=0.8,
    crossover_probability=0.7,
    mutation_probability=0.01,
    selection=None,
)
BEST = np.array([2.0, 1.0, 0.5])
"""By hand: a + b = 3 and a b >= 2 leave a in [1, 2]; the objective falls in a; the disc is not
met.
"""


def toy(plain: bool = False, limit: float = 2.0) -> Problem:
    """Least (a - 5)^2 + b^2 + c with a + b = 3, a b >= least, counted in halves, and a^2 + b^2 <=
    8.
    """
    x = ca.SX.sym("x", 3)
    f = (x[0] - 5) ** 2 + x[1] ** 2 + x[2]
    g = ca.vertcat(x[0] + x[1], x[0] * x[1] / 0.5, x[0] ** 2 + x[1] ** 2)
    bounds = np.array([3.0, limit / 0.5, -np.inf]), np.array([3.0, np.inf, 8.0])
    box = (DesignBox.plain if plain else DesignBox.shares)(
        NAMES, LOWER, UPPER, np.array([0.0, 0.0, 5.0])
    )
    return Problem(
        SmoothObjective(SymbolicFunction(x, f), 3),
        box,
        SymbolicConstraints(x, g, bounds, KINDS, np.arange(3)),
    )


@pytest.fixture(scope="module", params=[False, True], ids=["shares", "plain"])
def problem(request: pytest.FixtureRequest) -> Problem:
    return toy(request.param)


@pytest.fixture(scope="module")
def optimum(problem: Problem) -> np.ndarray:
    return search_locally(problem, problem.start).u


def test_every_start_ends_at_the_optimum_and_it_is_certified(problem: Problem) -> None:
    minima = list(search_from_starts(problem, 5, seed=3))
    assert all(minimum.settled and minimum.stationary for minimum in minima)
    for minimum in minima:
        assert problem.design(minimum.u) == pytest.approx(BEST, abs=1e-7)
    proof = certify_candidates(problem, minima[0].u, minima)
    assert proof.kkt_residual < STATIONARITY_TOLERANCE
    assert (proof.starts, proof.agreeing_starts) == (5, 5)
    assert proof.spread < 1e-7


def test_multipliers_are_those_by_hand(problem: Problem, optimum: np.ndarray) -> None:
    """At (2, 1): (-6, 2) + p (1, 1) - q (1, 2) = 0 gives q = 8, p = 14; c costs 1 at its lower
    bound.
    """
    m = estimate_multipliers(problem, optimum)
    multipliers = {
        constraint.name: constraint for constraint in find_active_constraints(problem, optimum, m)
    }
    assert set(multipliers) == {"sum", "product"}
    assert (multipliers["sum"].multiplier, multipliers["product"].multiplier) == pytest.approx(
        (14, 8), rel=1e-6
    )
    assert m.required[:2] == pytest.approx([14, -8 * 0.5], rel=1e-6)
    (bound,) = find_active_bounds(problem, m)
    assert (bound.name, bound.side) == ("c", "lower")
    assert bound.multiplier == pytest.approx(problem.box.unit[2], rel=1e-6)


def test_inequality_multiplier_has_a_sign(problem: Problem) -> None:
    """At the start of the product's valley its multiplier would have to be positive: the
    certificate gives it none.
    """
    x = np.array([1.0, 2.0, 0.5])
    u = (x - problem.box.origin) / problem.box.unit
    m = estimate_multipliers(problem, u)
    assert m.required[1] == pytest.approx(0.0, abs=1e-9)
    assert check_conditions(problem, u, m).stationarity > 1e-3


def test_programme_is_unbounded_with_exact_derivatives(problem: Problem) -> None:
    u = problem.interpolate(np.array([0.6, 0.4, 0.3]))
    programme = Epigraph(problem, problem.local(u), u)
    assert len(programme.start) == len(programme.lower) == 3
    weights = np.array([0.3, -1.2, 0.7])
    h = 1e-6 * np.eye(3)

    def slope(z: np.ndarray) -> np.ndarray:
        return programme.gradient(z) * 0.8 + programme.jacobian(z).T @ weights

    gradient = [(programme.f(u + s) - programme.f(u - s)) / 2e-6 for s in h]
    jacobian = np.array([(programme.g(u + s) - programme.g(u - s)) / 2e-6 for s in h]).T
    hessian = np.array([(slope(u + s) - slope(u - s)) / 2e-6 for s in h])
    assert programme.gradient(u) == pytest.approx(np.array(gradient), rel=1e-6, abs=1e-7)
    assert programme.jacobian(u) == pytest.approx(jacobian, rel=1e-6, abs=1e-7)
    assert programme.hessian(u, 0.8, weights) == pytest.approx(hessian, rel=1e-6, abs=1e-6)


def test_infeasible_problem_minimises_violation(problem: Problem) -> None:
    """a + b = 3 allows no product above 9/4. For 11/4 the sum alone gives way, to 2 sqrt(11/4)."""
    hard = toy(problem.box.unit[0] == 1, limit=2.75)
    nearest = find_feasible_or_nearest(hard, hard.constraints, sample_starts(hard, 2, 0))
    assert not nearest.is_feasible
    assert nearest.excess == pytest.approx([2 * np.sqrt(2.75) - 3, 0, 0], abs=1e-4)
    assert minimise_violation(problem, problem.constraints, problem.start).is_feasible


def test_without_constraints_the_inside_needs_no_multipliers() -> None:
    x = ca.SX.sym("x", 2)
    f = (x[0] - 0.3) ** 2 + (x[1] + 0.2) ** 2 + 1
    box = DesignBox.shares(("a", "b"), -np.ones(2), np.ones(2), np.zeros(2))
    problem = Problem(SmoothObjective(SymbolicFunction(x, f), 2, unit=2.0), box)
    (optimum,) = search_from_points(problem, [problem.start])
    assert problem.design(optimum.u) == pytest.approx([0.3, -0.2], abs=1e-8)
    assert (problem.scale, optimum.violation) == (2.0, 0.0)
    assert optimum.settled
    assert optimum.stationary
    assert kkt_residual(problem, optimum.u + 1e-4) > STATIONARITY_TOLERANCE


class Partial(SymbolicFunction):
    """A function without values where its first parameter is below a limit."""

    limit = -np.inf

    def value(self, x: Array) -> float:
        if x[0] < self.limit:
            raise ComputationError("there is no value here")
        return super().value(x)


def test_failed_starts_are_left_out() -> None:
    x = ca.SX.sym("x", 2)
    function = Partial(x, (x[0] - 0.7) ** 2 + x[1] ** 2 + 1)
    problem = Problem(
        SmoothObjective(function, 2),
        DesignBox.shares(("a", "b"), -np.ones(2), np.ones(2), np.full(2, 0.5)),
    )
    assert len(list(search_from_starts(problem, 6, seed=3))) == 6
    function.limit = 0.0
    minima = list(search_from_starts(problem, 6, seed=3))
    assert 0 < len(minima) < 6
    assert [minimum.objective for minimum in minima] == pytest.approx([1.0] * len(minima), abs=1e-9)
    assert np.isinf(problem.merit(np.zeros(2)))
    function.limit = 2.0
    with pytest.raises(ComputationError, match="no start leads anywhere: there is no value here"):
        list(search_from_starts(problem.anew(), 2, seed=3))
