"""The strict call layer, in CasADi's virtual machine and compiled."""

import shutil
import signal
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from planter import compiled, machine
from planter.device import MODELS, Device, Model
from planter.errors import ComputationError
from planter.kernels import CallError, Kernel

HAS_COMPILER = shutil.which("cc") is not None


@pytest.fixture
def kernel() -> Kernel:
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 2)
    return Kernel(ca.Function("f", [phi, x], [x[0] * ca.sin(phi) + x[1]], ["phi", "x"], ["y"]), lanes=["phi"])


def test_lanes(kernel: Kernel) -> None:
    phi = np.linspace(0, 1, 7)
    assert kernel(phi=phi, x=[2.0, 3.0])["y"] == pytest.approx(2 * np.sin(phi)[None] + 3)


def test_a_missing_input_is_no_zero(kernel: Kernel) -> None:
    with pytest.raises(CallError, match=r"f takes \['phi', 'x'\], and was given \['phi'\]"):
        kernel(phi=0.5)


def test_an_unknown_input_is_refused(kernel: Kernel) -> None:
    with pytest.raises(CallError, match="was given"):
        kernel(phi=0.5, x=[1.0, 2.0], y=3.0)


@pytest.mark.parametrize("x", [1.0, [1.0, 2.0, 3.0], [[1.0, 2.0]]])
def test_a_scalar_does_not_fill_a_vector(kernel: Kernel, x: object) -> None:
    with pytest.raises(CallError, match=r"f: input x has the shape .* expected \(2, 1\)"):
        kernel(phi=0.5, x=x)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_number_that_is_not_finite_is_refused(kernel: Kernel, bad: float) -> None:
    with pytest.raises(CallError, match="f: input x is not finite"):
        kernel(phi=0.5, x=[1.0, bad])


def test_no_nan_leaves() -> None:
    x = ca.SX.sym("x")
    root = Kernel(ca.Function("root", [x], [ca.sqrt(x)], ["x"], ["y"]), lanes=["x"])
    with pytest.raises(ComputationError, match=r"root: output y\[0\] is not finite in lane 1"):
        root(x=np.array([4.0, -1.0]))


def test_a_failed_root_is_an_error() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    solver = ca.rootfinder("solver", "fast_newton", ca.Function("g", [x, p], [x**2 + p]), {"error_on_fail": True})
    start, given = ca.MX.sym("start"), ca.MX.sym("p")
    kernel = Kernel(ca.Function("solve", [start, given], [solver(start, given)], ["start", "p"], ["x"]))
    assert kernel(start=1.0, p=-4.0)["x"][0, 0] == pytest.approx(2)
    with pytest.raises(ComputationError, match="solve"):
        kernel(start=1.0, p=4.0)


def test_ctrl_c_inside_a_call_waits_for_its_end(kernel: Kernel, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def slow(*arguments: object) -> float:
        signal.raise_signal(signal.SIGINT)
        calls.append(arguments)
        return 1.0

    monkeypatch.setattr(kernel, "_mapped", lambda count: slow)
    outside = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # ignored where a shell started us in the background
    try:
        with pytest.raises(KeyboardInterrupt):
            kernel(phi=0.5, x=[1.0, 2.0])
        assert len(calls) == 1
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, outside)


@pytest.mark.skipif(not HAS_COMPILER, reason="no C compiler")
@pytest.mark.parametrize("model", MODELS)
def test_machine_code_agrees_with_the_virtual_machine(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path))
    device = Device(machine.load("wang2017"), model)
    at, phi = device.prologue(device.design), np.linspace(0, 3, 50)
    by_machine = device.support_slopes(at, phi)
    device._support.compile()
    device._slopes.compile()
    assert len(list(tmp_path.glob("*.so"))) == 2
    for compiled_one, other in zip(device.support_slopes(at, phi), by_machine, strict=True):
        assert np.abs(compiled_one - other).max() <= 1e-12 * np.abs(other).max()
    assert device.support(at, phi) == pytest.approx(by_machine[0], rel=1e-13)


@pytest.mark.parametrize(("variable", "value"), [("CC", "no-such-compiler"), ("PLANTER_CACHE", "/dev/null/cache")])
def test_without_compiler_or_cache_it_works_all_the_same(
    kernel: Kernel, monkeypatch: pytest.MonkeyPatch, variable: str, value: str
) -> None:
    monkeypatch.setenv(variable, value)
    compiled._compiler.cache_clear()
    kernel.compile()
    compiled._compiler.cache_clear()
    assert kernel(phi=0.0, x=[2.0, 3.0])["y"][0, 0] == 3
