"""The certificate passes true optima and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from planter.engine.solvers import certificate, ipopt
from planter.engine.solvers.certificate import check_conditions, estimate_multipliers, kkt_residual
from planter.engine.solvers.epigraph import Epigraph
from planter.engine.solvers.local_search import STATIONARITY_TOLERANCE, search_locally
from tests.planter.engine.solvers import toys

SAMPLINGS = [360, 91, "refined"]


@pytest.fixture(scope="module", params=SAMPLINGS)
def optimum(request):
    problem = toys.problem(request.param)
    return problem, search_locally(problem, problem.start).u


def test_a_true_optimum_passes(optimum):
    problem, u = optimum
    assert (
        check_conditions(problem, u, estimate_multipliers(problem, u)).worst
        < STATIONARITY_TOLERANCE
    )


@pytest.mark.parametrize("step", [1e-2, 1e-3])
def test_a_moved_optimum_fails(optimum, step):
    problem, u = optimum
    for j in problem.free:
        moved = u.copy()
        moved[j] += step if u[j] < 0.5 else -step
        assert kkt_residual(problem, moved) > STATIONARITY_TOLERANCE, problem.box.names[j]


def test_a_point_outside_the_box_fails(optimum):
    problem, u = optimum
    m = estimate_multipliers(problem, u)
    outside = u.copy()
    outside[problem.free[0]] = 1 + 1e-3
    assert check_conditions(problem, outside, m).feasibility == pytest.approx(1e-3)


@pytest.mark.parametrize("field", ["rows", "at_lower", "at_upper"])
@pytest.mark.parametrize("change", ["zeroed", "doubled", "negated", "moved to the next"])
def test_a_wrong_multiplier_fails(optimum, field, change):
    problem, u = optimum
    m = estimate_multipliers(problem, u)
    values = getattr(m, field)
    assert values.max() > 0
    wrong = {
        "zeroed": 0 * values,
        "doubled": 2 * values,
        "negated": -values,
        "moved to the next": np.roll(values, 1),
    }[change]
    if np.array_equal(wrong, values):
        pytest.skip("one row alone cannot move")
    assert check_conditions(problem, u, replace(m, **{field: wrong})).worst > STATIONARITY_TOLERANCE


def test_a_solver_stopped_after_three_iterations_fails(optimum):
    problem, _ = optimum
    programme = Epigraph(
        problem, problem.objective.local(problem.design(problem.start)), problem.start
    )
    stopped = ipopt.solve_program(programme, programme.start, most_iterations=3)
    assert stopped.iterations == 3
    assert kkt_residual(problem, programme.point(stopped.z)) > STATIONARITY_TOLERANCE


def test_multipliers_are_prices_of_bounds():
    """Giving way by 1e-4 of the box saves multiplier times 1e-4."""
    problem = toys.problem("refined")
    u = search_locally(problem, problem.start).u
    for bound in certificate.find_active_bounds(problem, estimate_multipliers(problem, u)):
        j = problem.box.names.index(bound.name)
        x, step = problem.design(u), 1e-4 * problem.box.unit[j]
        x[j] += step if bound.side == "upper" else -step
        saved = problem.evaluate(u).objective - problem.score(x).objective
        assert saved == pytest.approx(1e-4 * bound.multiplier, rel=0.05), bound.name


def test_third_harmonic_shares_of_tied_peaks():
    """By symmetry the four tied peaks, two of each sign, need shares that add up to the weight of
    the range.
    """
    problem = toys.over_turn(toys.third_harmonic(), toys.RANGE, "refined")
    u = np.array([(0.5 - 1 / 6) / 0.9])
    m = estimate_multipliers(problem, u)
    assert check_conditions(problem, u, m).worst < 1e-12
    groups = problem.conditions(u).groups
    assert np.bincount(groups, m.rows) == pytest.approx([1, 1], abs=1e-12)
    assert kkt_residual(problem, u + 1e-3) > STATIONARITY_TOLERANCE


def test_clarke_conditions_at_an_optimal_kink():
    """Variance over 12 samples; the corner on a sample: neither one-sided gradient is zero, their
    mixture is.
    """
    problem = toys.over_turn(toys.corner(), toys.VARIANCE, 12)
    u = search_locally(problem, problem.start).u
    conditions = problem.conditions(u)
    assert len(conditions.kinks) == 1
    first, other = conditions.smooth[0], (conditions.smooth + conditions.kinks[0])[0]
    assert first * other < 0
    m = estimate_multipliers(problem, u)
    assert 0 < m.kinks[0] < 1
    assert check_conditions(problem, u, m).worst < STATIONARITY_TOLERANCE
    for wrong in (0.0, 1.0, -1e-3, 1 + 1e-3):
        assert (
            check_conditions(problem, u, replace(m, kinks=np.array([wrong]))).worst
            > STATIONARITY_TOLERANCE
        )
    assert kkt_residual(problem, u + 1e-4) > STATIONARITY_TOLERANCE


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_residual_does_not_depend_on_units(unit):
    plain = toys.problem(90)
    scaled = toys.problem(90, toys.Weights(0.6 * unit, 0.4 * unit, "paper"))
    u = np.full(10, 0.4)
    assert kkt_residual(scaled, u) == pytest.approx(kkt_residual(plain, u), rel=1e-6)
