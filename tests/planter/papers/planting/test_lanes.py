"""A device's kernels in all three ways: the same numbers."""

from functools import cache

import numpy as np
import pytest

from planter.kernels import Array, Kernel, backends
from planter.papers.planting.file import load
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from tests.support import swapped
from tests.support.lanes import difference, needs_compiler

pytestmark = [needs_compiler, pytest.mark.usefixtures("kernel_cache")]

MACHINES = ("wang2017", "compact", "swapped")
ANGLES = np.linspace(0, 2 * np.pi, 90, endpoint=False) + 0.01
EQUAL, ROUNDING = 1e-12, 1e-3


@cache
def device(name: str, model: Model) -> Device:
    return Device(swapped.machine() if name == "swapped" else load(name), model)


def _arguments(kernel: Kernel, device: Device, x: Array) -> list[Array]:
    at = device.prologue(x)
    phi = np.add.outer(device.force.offsets, ANGLES).reshape(1, -1)
    weights = np.random.default_rng(3).normal(size=phi.shape)
    arguments = {"phi": phi, "d": at.d, "h": at.h, "dh": at.dh, "weights": weights}
    return [
        np.atleast_2d(arguments[n]) if n in kernel.lanes else arguments[n].reshape(-1, 1)
        for n in kernel.names
    ]


def _designs(device: Device) -> list[Array]:
    rng = np.random.default_rng(2)
    return [device.design, *(rng.uniform(device.lower, device.upper) for _ in range(2))]


def _check_rows(name: str, actual: Array, theirs: Array) -> None:
    """Each row by its own largest value; rows that are nothing but rounding by the largest of
    all.
    """
    size = np.abs(theirs).max(axis=1)
    assert actual.shape == theirs.shape
    assert (
        np.abs(actual - theirs).max(axis=1) <= EQUAL * np.maximum(size, ROUNDING * size.max())
    ).all(), name


def _compare(kernel: Kernel, device: Device, names: tuple[str, ...]) -> None:
    values = {name: backends.build_compiled(kernel.work, name) for name in names}
    for x in _designs(device):
        arguments = _arguments(kernel, device, x)
        expected = backends.VirtualMachine(kernel.work)(arguments, arguments[0].shape[1])
        for name, way in values.items():
            for actual, theirs in zip(way(arguments, arguments[0].shape[1]), expected, strict=True):
                _check_rows(name, actual, theirs)


@pytest.mark.parametrize("name", MACHINES[:2])
def test_summed_hessian(name: str) -> None:
    planting_device = device(name, "exact")
    _compare(planting_device.force.response.hessian_kernel, planting_device, ("lanes", "casadi-c"))


def test_a_kernel_of_another_model_is_not_equal() -> None:
    """The comparison can fail: the printed model's force is another one."""
    exact, printed = (device("wang2017", model) for model in MODELS)
    arguments = _arguments(exact.force.response.values_kernel, exact, exact.design)
    at = printed.prologue(exact.design)
    values = dict(zip(exact.force.response.values_kernel.names, arguments, strict=True)) | {
        "h": at.h.reshape(-1, 1)
    }
    theirs = [values[name] for name in printed.force.response.values_kernel.names]
    first = backends.build_compiled(exact.force.response.values_kernel.work, "lanes")(
        arguments, arguments[0].shape[1]
    )
    other = backends.build_compiled(printed.force.response.values_kernel.work, "lanes")(
        theirs, arguments[0].shape[1]
    )
    assert difference(first[0], other[0]) > 1e-3
