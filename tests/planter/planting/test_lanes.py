"""A device's kernels in all three ways: the same numbers."""

from functools import cache
from itertools import product

import numpy as np
import pytest

from planter.kernels import Array, Kernel, backends, toolchain
from planter.planting.file import load
from planter.planting.functions import MODELS, Model
from planter.planting.model import Device
from tests.support import swapped
from tests.support.lanes import apart, needs_compiler
from tests.support.sampled import sampled

pytestmark = [needs_compiler, pytest.mark.usefixtures("kernel_cache")]

MACHINES = ("wang2017", "compact", "swapped")
ANGLES = np.linspace(0, 2 * np.pi, 90, endpoint=False) + 0.01
EQUAL, ROUNDING = 1e-12, 1e-3


@cache
def device(name: str, model: Model) -> Device:
    return Device(swapped.machine() if name == "swapped" else load(name), model)


def test_the_swapped_machine_is_another_function_of_another_machine() -> None:
    one, other = (device(name, "exact") for name in ("wang2017", "swapped"))
    assert [s.family for s in one.stages] == [s.family for s in reversed(other.stages)]
    assert one.force.response.values_kernel.work.loop != other.force.response.values_kernel.work.loop


def _arguments(kernel: Kernel, own: Device, x: Array) -> list[Array]:
    at = own.prologue(x)
    phi = np.add.outer(own.force.offsets, ANGLES).reshape(1, -1)
    weights = np.random.default_rng(3).normal(size=phi.shape)
    known = {"phi": phi, "d": at.d, "h": at.h, "dh": at.dh, "weights": weights}
    return [np.atleast_2d(known[n]) if n in kernel.lanes else known[n].reshape(-1, 1) for n in kernel.names]


def _designs(own: Device) -> list[Array]:
    rng = np.random.default_rng(2)
    return [own.design, *(rng.uniform(own.lower, own.upper) for _ in range(2))]


def _check_rows(name: str, mine: Array, theirs: Array) -> None:
    """Each row by its own largest value; rows that are nothing but rounding by the largest of all."""
    size = np.abs(theirs).max(axis=1)
    assert mine.shape == theirs.shape
    assert (np.abs(mine - theirs).max(axis=1) <= EQUAL * np.maximum(size, ROUNDING * size.max())).all(), name


def _compare(kernel: Kernel, own: Device, names: tuple[str, ...]) -> None:
    made = {"lanes": backends.build_lane_backend, "casadi-c": backends.build_casadi_backend}
    found = {name: made[name](kernel.work) for name in names}
    for x in _designs(own):
        arguments = _arguments(kernel, own, x)
        expected = backends.build_virtual_machine(kernel.work)(arguments, arguments[0].shape[1])
        for name, way in found.items():
            for mine, theirs in zip(way(arguments, arguments[0].shape[1]), expected, strict=True):
                _check_rows(name, mine, theirs)


@pytest.mark.parametrize(
    ("name", "model"),
    sampled([("wang2017", "exact"), ("compact", "exact"), ("swapped", "printed")], product(MACHINES, MODELS)),
)
def test_force_and_slopes(name: str, model: Model) -> None:
    own = device(name, model)
    for kernel in (own.force.response.values_kernel, own.force.response.slopes_kernel):
        _compare(kernel, own, ("lanes", "casadi-c"))


@pytest.mark.parametrize("name", MACHINES[:2])
def test_summed_hessian(name: str) -> None:
    own = device(name, "exact")
    _compare(own.force.response.hessian_kernel, own, ("lanes", "casadi-c"))


class TestWithoutPasses:
    """What takes a compiler long is compiled as it stands: text and loop are the same, the vectors are left out."""

    @pytest.fixture(autouse=True)
    def _swift(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(toolchain, "FEW_PASSES", ("-O0",))

    @pytest.mark.parametrize(
        ("name", "model"),
        sampled(
            [("swapped", "exact"), ("compact", "printed")], [("swapped", "exact"), *product(MACHINES, ["printed"])]
        ),
    )
    def test_summed_hessian(self, name: str, model: Model) -> None:
        own = device(name, model)
        _compare(own.force.response.hessian_kernel, own, ("lanes",))

    @pytest.mark.parametrize(("name", "model"), [("wang2017", "exact"), ("compact", "printed")])
    def test_hessian_at_each_angle(self, name: str, model: Model) -> None:
        own = device(name, model)
        _compare(own.force.response.hessians_kernel, own, ("lanes",))


def test_a_kernel_of_another_model_is_not_equal() -> None:
    """The comparison can fail: the printed model's force is another one."""
    exact, printed = (device("wang2017", model) for model in MODELS)
    arguments = _arguments(exact.force.response.values_kernel, exact, exact.design)
    at = printed.prologue(exact.design)
    known = dict(zip(exact.force.response.values_kernel.names, arguments, strict=True)) | {"h": at.h.reshape(-1, 1)}
    theirs = [known[name] for name in printed.force.response.values_kernel.names]
    one = backends.build_lane_backend(exact.force.response.values_kernel.work)(arguments, arguments[0].shape[1])
    other = backends.build_lane_backend(printed.force.response.values_kernel.work)(theirs, arguments[0].shape[1])
    assert apart(one[0], other[0]) > 1e-3


def test_rates_along_the_angle() -> None:
    own = device("wang2017", "exact")
    _compare(own.force.response.rates_kernel, own, ("lanes",))
