"""Sums of measures of any machine as problems: in which units, what optima gain, and how limits
hold.
"""

import pytest

from planter.engine.front import require_front
from planter.engine.goal import Goal, evaluate_measure, resolve_limit, resolve_measure
from planter.engine.machine import Machine, load_machine
from planter.engine.measures import Measure, parse_limit, parse_sum
from planter.engine.problem import DesignProblem, build_problem
from planter.engine.search import SearchSpec, minimise
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.local_search import sample_starts, search_locally
from planter.errors import InputError
from planter.mechanism.optimisation import optimise_machine
from planter.task import Means
from tests.support import own
from tests.support.cli import answer


@pytest.fixture(scope="module")
def arm() -> Machine:
    return own.machine("transplanting_arm")


def build(
    machine: Machine, text: str, *limits: str, sampling: Sampling = "refined"
) -> DesignProblem:
    measures = [resolve_measure(machine, measure) for measure in parse_sum(text)]
    return build_problem(
        machine, measures, [resolve_limit(machine, parse_limit(t)) for t in limits], sampling
    )


def test_machine_without_bounds_is_refused(arm: Machine) -> None:
    with pytest.raises(InputError, match=r"it has no \[bounds\]"):
        build(arm.with_moved({}), "range F_Ox")


@pytest.mark.parametrize(
    "text", ["2 range gamma + 3 variance gamma", "range F_Ox + 0.5 std F_Ox", "std gamma"]
)
def test_objective_equals_measures(arm: Machine, text: str) -> None:
    """Angles are in degrees in results: the sum is that of measures over the same samples, then
    over dense ones.
    """
    measures = [resolve_measure(arm, measure) for measure in parse_sum(text)]
    for sampling, count, tolerance in ((48, 48, 1e-12), ("refined", 20_000, 1e-6)):
        problem, goal = build(arm, text, sampling=sampling), Goal(arm, measures, (), count)
        assert problem.reference.objective == pytest.approx(
            goal.evaluate(arm.design), rel=tolerance
        )


def test_starts_agree_though_half_of_them_glide() -> None:
    """Half of the descents of one kind end in a local minimum of 14.6535 N, where peaks beside a
    jump tie.
    """
    problem = build(own.machine("slider_crank"), "range F_Ox")
    certificate = minimise(problem, SearchSpec(starts=8), means=Means(1)).result.certificate
    assert certificate.agreeing_starts >= 6
    assert certificate.kkt_residual < 1e-9
    plain = [search_locally(problem, start).objective for start in sample_starts(problem, 8, 0)]
    assert max(plain) == pytest.approx(14.6535, abs=1e-4)
    assert min(plain) == pytest.approx(14.5100016108, abs=1e-8)


@pytest.mark.parametrize(
    "limit", ["range F_Ox <= 16", pytest.param("jump F_Ox <= 2.5", marks=pytest.mark.long)]
)
def test_optimum_under_a_limit_has_its_price(limit: str) -> None:
    """Moving a limit by 1e-3 changes the objective by its multiplier."""
    machine = own.machine("slider_crank")
    name, sign, number = limit.rpartition(" ")[0].rpartition(" ")[0], "<=", float(limit.split()[-1])
    first, moved = (
        optimise_machine(
            machine, "rms M_in", [f"{name} {sign} {value}"], SearchSpec(starts=2), means=Means(1)
        )
        for value in (number, number + 1e-3)
    )
    (price,) = first.result.certificate.active_constraints
    assert first.result.holds[0].value == pytest.approx(number, rel=1e-9)
    change = (first.result.objective - moved.result.objective) / 1e-3
    assert change == pytest.approx(price.multiplier, rel=1e-2)


def test_limits_are_satisfied_between_nodes(arm: Machine) -> None:
    """The limit binds at a true extreme."""
    limit = "min F_Oy >= -4.2"
    free, bound = (
        optimise_machine(arm, "range F_Ox", holds, SearchSpec(starts=2)) for holds in ([], [limit])
    )
    peaks = [evaluate_measure(f.machine, Measure("min", "F_Oy")) for f in (free, bound)]
    assert peaks[0] < -4.5
    assert peaks[1] == pytest.approx(-4.2, abs=1e-6)


def test_values_without_effect_stay_where_they_are(arm: Machine) -> None:
    """The tip moves no force: its place on the coupler is left alone, and reported."""
    result = optimise_machine(arm, "range F_Ox", [], SearchSpec(24, starts=2)).result
    assert [list(part) for direction in result.insensitive for part in direction] == [
        ["p_mm"],
        ["n_mm"],
    ]
    assert result.effective_parameters == 5
    for name in ("p_mm", "n_mm"):
        assert result.design[name] == result.start_design[name]


def test_front_trades_range_against_variance(arm: Machine) -> None:
    source = own.generated("transplanting_arm") / "transplanting_arm.toml"
    options = ("--least", "range gamma", "--front", "--samples", "24", "--starts", "1")
    front = answer("optimise", str(source), *options)["front"]
    ranges, variances = ([point[key] for point in front] for key in ("range", "variance"))
    assert len(front) > 2
    assert ranges == sorted(ranges)
    assert variances == sorted(variances, reverse=True)
    changes = {f"values.{name}": value for name, value in front[1]["design"].items()}
    machine = load_machine(str(source), changes)
    for text, value in (("range gamma", ranges[1]), ("variance gamma", variances[1])):
        assert build(machine, text, sampling=24).reference.objective == pytest.approx(
            value, rel=1e-9
        )


def test_fronts_need_a_problem_without_limits(arm: Machine) -> None:
    with pytest.raises(InputError, match="under limits"):
        require_front(build(arm, "range F_Ox", "max F_Oy <= 12"))
    assert require_front(build(arm, "range F_Ox")) == "F_Ox"
