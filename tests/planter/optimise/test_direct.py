"""IPOPT on compiled functions against the same programme in plain ones."""

from __future__ import annotations

import time
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from planter.kernels import backends
from planter.kernels.backends import LaneTask
from planter.optimise import epigraph, ipopt
from planter.optimise.epigraph import Epigraph
from planter.optimise.local_search import search_locally
from planter.optimise.range_variance import build_range_problem as over_turn
from planter.planting import file, optimisation
from planter.planting.functions import MODELS, Model
from planter.planting.model import Device
from planter.planting.objective import build_problem as problem_of
from planter.planting.objective import read_weights
from tests.support.lanes import needs_compiler

SAMPLES = 120


pytestmark = [needs_compiler, pytest.mark.usefixtures("kernel_cache")]


def programme(device: Device, kind: str = "paper") -> Epigraph:
    chosen = replace(read_weights(device.machine), kind=kind)
    problem = over_turn(device.force, chosen, SAMPLES)
    return Epigraph(problem, problem.objective.turn.local(problem.design(problem.start)), problem.start)


@pytest.fixture(
    scope="module", params=[MODELS[0], *(pytest.param(model, marks=pytest.mark.long) for model in MODELS[1:])]
)
def device(request: pytest.FixtureRequest) -> Device:
    model: Model = request.param
    device = Device(file.load("wang2017"), model)
    device.compile()
    device.force.response.hessian_kernel.compile()
    return device


def values(function: ca.Function, arguments: list[object]) -> list[np.ndarray]:
    return [np.array(ca.densify(result)) for result in function.call(arguments)]


@pytest.mark.parametrize("kind", ["paper", "newton"])
def test_the_compiled_functions_are_those_of_the_programme(device: Device, kind: str) -> None:
    plain, failures = programme(device, kind), []
    compiled, called_back = epigraph.compile_epigraph(plain), ipopt._build_functions(plain, failures)
    rng = np.random.default_rng(3)
    z = np.clip(plain.start + 1e-2 * rng.standard_normal(len(plain.start)), plain.lower, plain.upper)
    dual = [0.7, rng.standard_normal(len(plain.g_lower))]
    for name, function in compiled.items():
        arguments = [z, ca.DM(0, 0), *(dual if name == "hess_lag" else [])]
        for actual, other in zip(values(function, arguments), values(called_back[name], arguments), strict=True):
            assert actual == pytest.approx(other, abs=1e-11 * np.abs(other).max())
    assert not failures


def test_a_tampered_width_is_noticed(device: Device) -> None:
    plain = programme(device)
    called_back = ipopt._build_functions(plain, [])["grad_f"]
    before = values(epigraph.compile_epigraph(plain)["grad_f"], [plain.start, ca.DM(0, 0)])
    box = plain.problem.box
    plain.problem.box = replace(box, unit=box.unit * 1.001)
    after = values(epigraph.compile_epigraph(plain)["grad_f"], [plain.start, ca.DM(0, 0)])
    assert np.abs(after[1] - before[1]).max() > 1e-6 * np.abs(before[1]).max()
    assert values(called_back, [plain.start, ca.DM(0, 0)])[1].shape == after[1].shape


def test_both_ways_end_at_the_same_minimum(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    def minimum() -> tuple[float, float, int]:
        problem = problem_of(device, SAMPLES)
        optimum = search_locally(problem, problem.start)
        assert problem.counts.gradient > 5
        return optimum.objective, optimum.residual, optimum.iterations

    fast = minimum()
    monkeypatch.setattr(epigraph, "compile_epigraph", lambda programme: None)
    slow = minimum()
    assert fast[0] == pytest.approx(slow[0], rel=1e-10)
    assert max(fast[1], slow[1]) < 1e-8


def test_no_compiled_functions_without_compiled_kernels() -> None:
    assert epigraph.compile_epigraph(programme(Device(file.load("wang2017")))) is None


def test_counts_do_not_hang_on_when_the_compiler_ends(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Hessian is compiled in the background: a search that began before its end took other steps."""
    counts = optimisation.search_optimum(device, "ipopt", SAMPLES, starts=1).evaluations
    late, fastest = Device(device.machine, device.model), backends.select_fastest

    def slow(work: LaneTask) -> backends.Backend:
        time.sleep(1.0 if work.function.name() == "bending" else 0.0)
        return fastest(work)

    monkeypatch.setattr(backends, "is_compiled", lambda work: False)
    monkeypatch.setattr(backends, "select_fastest", slow)
    late.compile()
    assert late.force.response.hessian_kernel.way == "casadi-vm"
    assert optimisation.search_optimum(late, "ipopt", SAMPLES, starts=1).evaluations == counts
