"""Equations: points are taken onto them to rounding within the box, by every way to search, and
never give way.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from planter.engine.solvers import optimiser
from planter.engine.solvers.certificate import kkt_residual
from planter.engine.solvers.constraints import (
    DesignBox,
    JoinedConstraints,
    NamedConstraint,
    compute_short_step,
    join_constraints,
    project_onto_equations,
)
from planter.engine.solvers.curve_sum import scale_slopes
from planter.engine.solvers.expressions import (
    SmoothObjective,
    SymbolicConstraints,
    SymbolicFunction,
)
from planter.engine.solvers.feasibility import minimise_violation
from planter.engine.solvers.insensitive import find_insensitive
from planter.engine.solvers.local_search import STATIONARITY_TOLERANCE
from planter.engine.solvers.optimiser import METHODS, Method, OptimiserRun
from planter.engine.solvers.problem import Problem
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.test_smooth import SHORT

LOWER, UPPER = np.array([-2.0, -2.0, -2.0]), np.array([2.0, 2.0, 2.0])
NAMES = ("a", "b", "c")
X = ca.SX.sym("x", 3)


def rows(g: ca.SX, lower: list[float], upper: list[float], *names: str) -> SymbolicConstraints:
    kinds = [NamedConstraint(name, ("min", "max")) for name in names]
    return SymbolicConstraints(
        X, g, (np.array(lower), np.array(upper)), kinds, np.arange(len(names))
    )


class Held(SymbolicConstraints):
    """Rows that do not give way."""

    @property
    def giving(self) -> np.ndarray:
        return np.zeros(len(self.kinds), dtype=bool)


def sphere(radius: float = 1.5) -> SymbolicConstraints:
    return rows(ca.sumsqr(X), [radius**2], [radius**2], "sphere")


def halfspace() -> SymbolicConstraints:
    return rows(X[0] + X[1], [0.4], [np.inf], "half space")


def task(f: ca.SX = X[0] + 2 * X[1] + X[2] ** 2) -> Problem:
    """Least f on a sphere and in a half space."""
    box = DesignBox.shares(NAMES, LOWER, UPPER, np.array([0.3, 1.1, 0.2]))
    return Problem(
        SmoothObjective(SymbolicFunction(X, f), 3), box, join_constraints([halfspace(), sphere()])
    )


def test_points_are_taken_onto_equations_to_rounding() -> None:
    problem, rng = task(), np.random.default_rng(4)
    for u in rng.random((50, 3)):
        reached = problem.onto(u)
        assert np.linalg.norm(problem.design(reached)) == pytest.approx(1.5, rel=1e-14)
        assert min(problem.box.slack(reached)[0].min(), problem.box.slack(reached)[1].min()) >= 0
        assert np.abs(problem.onto(reached) - reached).max() < 1e-14


def test_coordinates_at_bounds_stay_if_others_suffice() -> None:
    box = DesignBox.shares(NAMES, np.array([-1.0, -1.0, -1.0]), UPPER, np.zeros(3))
    start = np.array([0.0, 0.5, 0.6])
    reached = project_onto_equations(box, sphere(), start)
    assert reached[0] == 0.0
    assert np.linalg.norm(box.at(reached)) == pytest.approx(1.5, rel=1e-14)


def test_step_stops_at_bounds_and_others_continue() -> None:
    slopes, miss = np.array([[1.0, 1.0, 0.0]]), np.array([1.0])
    step = compute_short_step(slopes, miss, np.full(3, -1.0), np.array([0.2, 1.0, 1.0]))
    assert step == pytest.approx([0.2, 0.8, 0.0])
    short = compute_short_step(slopes, miss, np.full(3, -1.0), np.array([0.2, 0.3, 1.0]))
    assert short == pytest.approx([0.2, 0.3, 0.0])


def test_infeasible_equations_return_nearest_point() -> None:
    box = DesignBox.shares(NAMES, LOWER, UPPER, np.zeros(3))
    reached = project_onto_equations(box, sphere(9.0), np.array([0.7, 0.6, 0.9]))
    assert np.abs(box.at(reached)).max() <= 2
    assert abs(np.linalg.norm(box.at(reached)) - 9) > 1


def test_joined_constraints_are_stacked() -> None:
    parts, x, weights = (halfspace(), sphere()), np.array([0.3, -0.2, 0.9]), np.array([0.7, -1.3])
    joined = JoinedConstraints(parts)
    assert joined.values(x) == pytest.approx(np.concatenate([part.values(x) for part in parts]))
    assert joined.slopes(x) == pytest.approx(np.vstack([part.slopes(x) for part in parts]))
    assert joined.curvature(x, weights) == pytest.approx(-1.3 * parts[1].curvature(x, np.ones(1)))
    assert [kind.name for kind in joined.kinds] == ["half space", "sphere"]
    assert joined.owner.tolist() == [0, 1]
    assert joined.equations is not None
    assert joined.equations.values(x) == pytest.approx(parts[1].values(x))
    assert join_constraints([]) is None
    assert halfspace().equations is None


@pytest.mark.parametrize("method", METHODS)
def test_every_method_ends_on_them(method: Method) -> None:
    """Least a + 2 b there: by hand the half space holds it, with a + b = 0.4."""
    problem = task()
    optimum = OptimiserRun(problem, SHORT, seed=2, starts=3).run(
        method, candidates=[problem.onto(problem.start)]
    )
    assert np.linalg.norm(optimum.design) == pytest.approx(1.5, rel=1e-14)
    if method != "ga":
        assert optimum.certificate.kkt_residual < STATIONARITY_TOLERANCE
        assert {constraint.name for constraint in optimum.certificate.active_constraints} == {
            "half space",
            "sphere",
        }


def test_a_point_off_an_equation_fails_the_certificate() -> None:
    problem = task()
    optimum = OptimiserRun(problem, SHORT, seed=2, starts=2).run("ipopt")
    u = (optimum.design - problem.box.origin) / problem.box.unit
    assert kkt_residual(problem, u) < STATIONARITY_TOLERANCE
    assert (
        kkt_residual(problem, (optimum.design * (1 + 1e-6) - problem.box.origin) / problem.box.unit)
        > STATIONARITY_TOLERANCE
    )


def test_a_population_lives_on_them() -> None:
    problem = task()
    for point in optimiser.search_genetically(problem, SHORT, seed=1):
        assert np.linalg.norm(problem.design(point.u)) == pytest.approx(1.5, rel=1e-12)


def test_fixed_constraints_hold_while_others_relax() -> None:
    """No point of the sphere has a >= 1.7: it comes as near as 1.5, and the sphere stays."""
    far = rows(X[0], [1.7], [np.inf], "far")
    constraint = Held(
        X, ca.sumsqr(X), (np.array([2.25]),) * 2, [NamedConstraint("sphere")], np.arange(1)
    )
    both = JoinedConstraints((far, constraint))
    box = DesignBox.shares(NAMES, LOWER, UPPER, np.array([0.3, 0.4, 0.2]))
    problem = Problem(SmoothObjective(SymbolicFunction(X, X[2]), 3), box, both)
    nearest = minimise_violation(problem, both, problem.onto(problem.start))
    assert nearest.excess == pytest.approx([0.2, 0.0], abs=1e-6)
    assert not nearest.is_feasible


def test_constrained_parameters_have_an_effect() -> None:
    """The first toy's parameter does not move a force that has none of it: held, it is
    determined.
    """
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 3)
    toy = toys.Toy(phi, x, x[0] * ca.cos(phi), lower=-np.ones(3), upper=np.ones(3))
    free = find_insensitive(toy.names, scale_slopes(toy, np.full(3, 0.5), 36))
    assert (free.effective_parameters, len(free.directions)) == (1, 2)
    insensitivity = find_insensitive(
        toy.names,
        scale_slopes(toy, np.full(3, 0.5), 36),
        np.array([[0.3, 1.0, 1.0]]) * (toy.upper - toy.lower),
    )
    assert insensitivity.effective_parameters == 1
    assert len(insensitivity.space) == 1
    assert insensitivity.space[0] / insensitivity.space[0, 1] == pytest.approx(
        [0, 1, -1], abs=1e-12
    )
    assert not insensitivity.zero.any()


def test_a_response_is_optimised_on_them() -> None:
    toy, _, _ = toys.linear(3)
    x = ca.SX.sym("x", 3)
    circle = SymbolicConstraints(
        x,
        ca.sumsqr(x),
        (np.array([0.5]),) * 2,
        [NamedConstraint("sphere", ("min", "max"))],
        np.arange(1),
    )
    problem = toys.over_turn(toy, toys.PAPER, 40, circle)
    optimum = OptimiserRun(problem, SHORT, seed=2, starts=3).run(
        "ipopt", candidates=[problem.onto(problem.start)]
    )
    assert optimum.design @ optimum.design == pytest.approx(0.5, rel=1e-14)
    assert optimum.certificate.kkt_residual < STATIONARITY_TOLERANCE
