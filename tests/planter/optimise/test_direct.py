"""A search does not depend on when the compiler ends."""

from __future__ import annotations

import time

import pytest

from planter.kernels import backends
from planter.kernels.backends import LaneTask
from planter.planting import file, optimisation
from planter.planting.functions import MODELS, Model
from planter.planting.model import Device
from tests.support.lanes import needs_compiler

SAMPLES = 120


pytestmark = [needs_compiler, pytest.mark.usefixtures("kernel_cache")]


@pytest.fixture(
    scope="module",
    params=[MODELS[0], *(pytest.param(model, marks=pytest.mark.long) for model in MODELS[1:])],
)
def device(request: pytest.FixtureRequest) -> Device:
    model: Model = request.param
    device = Device(file.load("wang2017"), model)
    device.compile()
    device.force.response.hessian_kernel.compile()
    return device


def test_counts_do_not_hang_on_when_the_compiler_ends(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The Hessian is compiled in the background: a search that began before its end took other
    steps.
    """
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
