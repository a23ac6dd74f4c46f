"""The three methods on the machine: never worse than either alone, reproducible, stoppable, and
what they tell.
"""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from planter.engine.solvers import optimiser
from planter.engine.solvers.local_search import search_locally
from planter.errors import InputError
from planter.papers.planting import optimisation
from planter.papers.planting.optimisation import OptimisationInterrupted
from planter.task import AUTO, Means
from tests.planter.engine.solvers import toys

N, STARTS = 36, 2


@pytest.fixture(scope="module")
def results():
    """By method; two workers run the starts of hybrid, beside the genetic algorithm."""
    means = {"hybrid": Means(2)}
    return {
        m: optimisation.search_optimum(
            toys.device(), m, samples=N, seed=1, starts=STARTS, means=means.get(m, AUTO)
        )
        for m in optimiser.METHODS
    }


def test_hybrid_is_never_worse_than_either_alone(results):
    assert results["hybrid"].objective <= min(results["ga"].objective, results["ipopt"].objective)


def test_hybrid_runs_the_same_search_and_the_same_starts(results):
    together = results["hybrid"]
    assert together.history["ga"] == results["ga"].history["ga"]
    assert together.history["ipopt"] == results["ipopt"].history["ipopt"]
    assert together.certificate.spread == results["ipopt"].certificate.spread
    assert together.evaluations.gradient > results["ipopt"].evaluations.gradient > 0
    assert results["ga"].evaluations.gradient == results["ga"].evaluations.hessian == 0


def test_certificate_distinguishes_optima(results):
    for method in ("ipopt", "hybrid"):
        certificate = results[method].certificate
        assert certificate.kkt_residual < 1e-6
        assert 1 <= certificate.agreeing_starts <= certificate.starts == STARTS
        assert certificate.spread >= 0
    assert results["ga"].certificate.kkt_residual > 1e-6
    assert (results["ga"].certificate.starts, results["ga"].certificate.spread) == (0, 0.0)


@pytest.mark.parametrize(
    ("objectives", "breeds"),
    [([1, 1, 2], False), ([1, 2, 3], True), ([1], False), ([1] + [2] * 5, True)],
)
def test_a_start_that_agrees_with_itself_alone_is_no_agreement(objectives, breeds):
    run = optimiser.OptimiserRun(toys.problem(N), settings=None)
    run.descents = [None] * len(objectives)
    run.minima = [SimpleNamespace(objective=float(o), violation=0.0) for o in objectives]
    assert run._starts_disagree() is breeds


def test_the_table_is_json_with_the_keys_of_the_interface(results):
    optimum = results["hybrid"]
    table = json.loads(json.dumps(optimum.build_record(toys.device()).table(), allow_nan=False))
    keys = {
        "method",
        "objective",
        "design",
        "range_N",
        "variance_N2",
        "start_objective",
        "evaluations",
        "seconds",
    }
    assert keys < set(table)
    assert set(table["certificate"]) == {
        "kkt_residual",
        "active_bounds",
        "active_constraints",
        "starts",
        "agreeing_starts",
        "spread",
    }
    assert set(table["evaluations"]) == {"objective", "gradient", "hessian"}
    assert list(table["design"]) == list(toys.device().names)
    assert table["objective"] == pytest.approx(
        0.6 * table["range_N"] + 0.4 * table["variance_N2"], rel=1e-12
    )
    for name, (lower, upper) in toys.device().machine.bounds.items():
        assert lower * (1 - 1e-15) <= table["design"][name] <= upper * (1 + 1e-15)


@pytest.mark.parametrize("method", optimiser.METHODS)
def test_an_interrupt_hands_over_the_best_so_far(method):
    seen = []

    def stop(event):
        seen.append(event)
        if len(seen) == 2:
            raise KeyboardInterrupt

    with pytest.raises(OptimisationInterrupted) as caught:
        optimisation.search_optimum(
            toys.device(), method, samples=N, seed=1, starts=STARTS, progress=stop
        )
    best = caught.value.best
    assert best is not None
    assert best.objective <= seen[-1].best * (1 + 1e-12)
    assert caught.value.exit_code == 130
    assert caught.value.partial["objective"] == best.objective


def test_ipopt_is_interrupted_inside_a_solve(monkeypatch):
    problem = toys.problem(N)
    curvature, calls = toys.planting().curves.curvature, []

    def stop(*arguments):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return curvature(*arguments)

    monkeypatch.setattr(toys.planting().curves, "curvature", stop)
    with pytest.raises(KeyboardInterrupt):
        search_locally(problem, problem.start)
    assert len(calls) == 3
    assert problem.best.objective <= problem.reference.objective


def test_an_unknown_method_is_refused():
    with pytest.raises(InputError, match="hybrid, ipopt, ga"):
        optimisation.search_optimum(toys.device(), "annealing")


def test_refined_needs_no_samples():
    optimum = optimisation.search_optimum(toys.device(), "ipopt", samples="refined", starts=2)
    assert optimum.certificate.kkt_residual < 1e-6
    assert optimum.certificate.agreeing_starts == 2
    assert optimum.evaluation.objective == pytest.approx(1.9044107244, abs=1e-9)


def test_the_import_is_light():
    code = (
        "import sys, planter.engine.solvers; print([m for m in ('casadi', 'scipy', 'numpy') if m in "
        "sys.modules])"
    )
    root = str(Path(__file__).parents[4])
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root
    )
    assert done.stdout.strip() == "[]"
