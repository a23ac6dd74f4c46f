"""The strict call layer, in CasADi's virtual machine and compiled."""

import pickle
import signal
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from planter.errors import ComputationError
from planter.kernels import CallError, Kernel, backends, toolchain
from planter.kernels.backends import Backend, LaneTask
from planter.kernels.compiler import CompilerError
from planter.kernels.kernel import StackedKernel, VectorFunction
from planter.kernels.lane_graph import NotPrintableError
from tests.support.lanes import needs_compiler


@pytest.fixture
def kernel() -> Kernel:
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 2)
    return Kernel(
        ca.Function("f", [phi, x], [x[0] * ca.sin(phi) + x[1]], ["phi", "x"], ["y"]), lanes=["phi"]
    )


def test_lanes(kernel: Kernel) -> None:
    phi = np.linspace(0, 1, 7)
    assert kernel(phi=phi, x=[2.0, 3.0])["y"] == pytest.approx(2 * np.sin(phi)[None] + 3)


REFUSED: dict[str, tuple[dict[str, object], str]] = {
    "missing": ({"phi": 0.5}, r"f takes \['phi', 'x'\], and was given \['phi'\]"),
    "unknown": ({"phi": 0.5, "x": [1.0, 2.0], "y": 3.0}, "was given"),
    "a scalar for a vector": ({"phi": 0.5, "x": 1.0}, r"x has the shape .* expected \(2, 1\)"),
    "too long": ({"phi": 0.5, "x": [1.0, 2.0, 3.0]}, "has the shape"),
    "a row": ({"phi": 0.5, "x": [[1.0, 2.0]]}, "has the shape"),
    "no number": ({"phi": 0.5, "x": [1.0, np.nan]}, "f: input x is not finite"),
    "infinite in a lane": ({"phi": [0.5, np.inf], "x": [1.0, 2.0]}, "f: input phi is not finite"),
}


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.parametrize("is_compiled", [False, pytest.param(True, marks=needs_compiler)])
def test_invalid_inputs_are_refused(
    kernel: Kernel, case: str, is_compiled: bool, kernel_cache: None
) -> None:
    if is_compiled:
        kernel.compile()
    inputs, message = REFUSED[case]
    with pytest.raises(CallError, match=message):
        kernel(**inputs)


def test_no_nan_leaves() -> None:
    x = ca.SX.sym("x")
    root = Kernel(ca.Function("root", [x], [ca.sqrt(x)], ["x"], ["y"]), lanes=["x"])
    with pytest.raises(ComputationError, match=r"root: output y\[0\] is not finite in lane 1"):
        root(x=np.array([4.0, -1.0]))


def build_solver() -> Kernel:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    solver = ca.rootfinder(
        "solver", "fast_newton", ca.Function("g", [x, p], [x**2 + p]), {"error_on_fail": True}
    )
    start, parameter = ca.MX.sym("start"), ca.MX.sym("p")
    return Kernel(
        ca.Function("solve", [start, parameter], [solver(start, parameter)], ["start", "p"], ["x"])
    )


def test_a_failed_root_is_an_error() -> None:
    kernel = build_solver()
    assert kernel(start=1.0, p=-4.0)["x"][0, 0] == pytest.approx(2)
    with pytest.raises(ComputationError, match="solve"):
        kernel(start=1.0, p=4.0)


@pytest.mark.parametrize("converts", [False, True])
def test_interrupt_during_call_ends_it(monkeypatch: pytest.MonkeyPatch, converts: bool) -> None:
    """Also where CasADi has made another error of it on the way, as solvers do."""
    kernel, memory = build_solver(), ca.Function.buffer

    def slow() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            if converts:
                raise RuntimeError("an error of CasADi's") from None
            raise

    monkeypatch.setattr(ca.Function, "buffer", lambda function: (memory(function)[0], slow))
    outside = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # ignored where a shell started us in the background
    try:
        with pytest.raises(KeyboardInterrupt):
            kernel(start=1.0, p=-4.0)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, outside)


def test_results_belong_to_the_caller(kernel: Kernel) -> None:
    """A second call does not write into what the first one gave."""
    first = kernel(phi=[0.1, 0.2], x=[2.0, 3.0])["y"]
    copied = first.copy()
    kernel(phi=[1.1, 1.2], x=[2.0, 3.0])
    assert (first == copied).all()


def test_straight_code_is_called_without_deferral(
    kernel: Kernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would take most of the time of a small function."""
    deferred: list[object] = []

    def note(call: Callable[[], object]) -> None:
        deferred.append(call)
        call()

    monkeypatch.setattr(backends, "defer_interrupt", note)
    assert kernel(phi=0.5, x=[2.0, 3.0])["y"][0, 0] == pytest.approx(2 * np.sin(0.5) + 3)
    assert not deferred
    build_solver()(start=1.0, p=-4.0)
    assert len(deferred) == 1


def build_vector_function() -> VectorFunction:
    t, x, u = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("u", 0)
    sparse = ca.SX(ca.Sparsity.diag(2), x * t)
    return VectorFunction(
        ca.Function("f", [t, x, u], [ca.sqrt(x), sparse], list("txu"), ["y", "z"])
    )


def test_vector_function_returns_new_arrays_and_passes_nan_on() -> None:
    function = build_vector_function()
    y, z = function(2.0, [4.0, -1.0], [])
    assert (y[0, 0], np.isnan(y[1, 0]), z.tolist()) == (2, True, [[8, 0], [0, -2]])
    function(1.0, np.ones(2), np.zeros(0))
    assert z.tolist() == [[8, 0], [0, -2]]


@pytest.mark.parametrize("x", [1.0, [1.0], [1.0, 2.0, 3.0], [[1.0, 2.0]], [[1.0], [2.0]]])
def test_vector_of_another_shape_is_refused(x: object) -> None:
    with pytest.raises(CallError, match=r"f: inputs .* expected \[\(1,\), \(2,\), \(0,\)\]"):
        build_vector_function()(0.0, x, [])  # type: ignore[arg-type]


def test_threads_call_a_vector_function_in_memory_of_their_own() -> None:
    function = build_vector_function()

    def run(number: int) -> bool:
        x = np.array([number, 1.0])
        return all(function(1.0, x, [])[1][0, 0] == number for _ in range(500))

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(run, range(8)))


def test_a_sparse_output_is_filled_up() -> None:
    x = ca.SX.sym("x", 2)
    f = ca.Function("f", [x], [ca.SX(ca.Sparsity.diag(2), x**2)], ["x"], ["y"])
    assert Kernel(f)(x=[2.0, 3.0])["y"].tolist() == [[4, 0], [0, 9]]


@needs_compiler
@pytest.mark.usefixtures("kernel_cache")
class TestCompiled:
    def test_it_says_how_it_is_evaluated(self, kernel: Kernel) -> None:
        assert kernel.way == "casadi-vm"
        kernel.compile()
        assert kernel.way == "lanes"
        assert backends.is_compiled(kernel.work)
        assert kernel(phi=[0.5, 1.5], x=[2.0, 3.0])["y"] == pytest.approx(
            2 * np.sin([[0.5, 1.5]]) + 3, rel=1e-15
        )

    def test_kernel_without_lanes_uses_casadi_code(self) -> None:
        x = ca.SX.sym("x")
        kernel = Kernel(ca.Function("square", [x], [x**2], ["x"], ["y"]))
        kernel.compile()
        assert kernel.way == "casadi-c"
        assert kernel(x=3.0)["y"][0, 0] == 9

    @pytest.mark.parametrize("way", ["lanes", "casadi-c", "casadi-vm"])
    def test_the_variable_names_the_fastest_way_allowed(
        self, kernel: Kernel, way: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("PLANTER_KERNELS", way)
        kernel.compile()
        assert kernel.way == way
        assert kernel(phi=0.5, x=[2.0, 3.0])["y"][0, 0] == pytest.approx(
            2 * np.sin(0.5) + 3, rel=1e-15
        )

    def test_no_nan_leaves_a_loop(self) -> None:
        """Its compiler may assume that there is none: what comes out is looked at outside."""
        x = ca.SX.sym("x")
        root = Kernel(ca.Function("root", [x], [ca.sqrt(x), 1 / x], ["x"], ["y", "z"]), lanes=["x"])
        root.compile()
        assert root.way == "lanes"
        for bad in (-1.0, 0.0):
            with pytest.raises(
                ComputationError, match=r"root: output [yz]\[0\] is not finite in lane 1"
            ):
                root(x=np.array([4.0, bad]))


@pytest.mark.parametrize("lacking", ["compiler", "cache", "execution"])
def test_without_compiler_or_cache_it_works_all_the_same(
    kernel: Kernel,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    lacking: str,
) -> None:
    """Slower, which one warning says; also on a disk that forbids execution."""

    def refuse(path: object) -> None:
        raise CompilerError(f"{path} cannot be loaded: failed to map segment")

    if lacking == "execution":
        monkeypatch.setattr(toolchain, "load_library", refuse)
    else:
        values = {"compiler": ("CC", "no-such-compiler"), "cache": ("PLANTER_CACHE", "/dev/null/x")}
        monkeypatch.setenv(*values[lacking])
        assert not backends.is_compiled(kernel.work)
    monkeypatch.setattr(toolchain, "_warnings", [])
    kernel.compile()
    kernel.compile()
    assert kernel.way == "casadi-vm"
    assert kernel(phi=0.0, x=[2.0, 3.0])["y"][0, 0] == 3
    assert [r.levelname for r in caplog.records] == ["WARNING"]


def test_a_pickled_kernel_is_the_same_function(kernel: Kernel) -> None:
    again = pickle.loads(pickle.dumps(kernel))
    assert (again.lanes, again.names, again.way) == (kernel.lanes, kernel.names, "casadi-vm")
    inputs = {"phi": [0.0, 1.0], "x": [2.0, 3.0]}
    assert again(**inputs)["y"].tolist() == kernel(**inputs)["y"].tolist()


def test_bound_kernel_suggests_pickling_kernel(kernel: Kernel) -> None:
    bound = kernel.bind(phi=np.zeros((1, 2)), x=np.ones((2, 1), order="F"))
    with pytest.raises(TypeError, match="pickle the kernel"):
        pickle.dumps(bound)


@pytest.mark.parametrize("build", [backends.VirtualMachine, backends.select_fastest])
@pytest.mark.parametrize("summed", [False, True])
def test_no_lanes_give_empty_outputs(build: Callable[[LaneTask], Backend], summed: bool) -> None:
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 2)
    matrix = ca.horzcat(phi * x, ca.sin(phi) * x, x)
    function = ca.Function(
        "f", [phi, x], [ca.densify(matrix), x * phi], ["phi", "x"], ["wide", "y"]
    )
    way = build(LaneTask(function, ("phi",), summed))
    shapes = [result.shape for result in way([np.empty((1, 0)), np.ones((2, 1))], 0)]
    assert shapes == ([(2, 3), (2, 1)] if summed else [(2, 0), (2, 0)])


def build_stack() -> ca.Function:
    phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", 2), ca.SX.sym("q", 2)
    rows = ca.vertcat(d[0] * ca.sin(phi) + q[0], d[1] / (2 + ca.cos(phi + q[1])), q[0] * q[1])
    return ca.Function("stacked_rows", [phi, d, q], [rows], ["phi", "d", "q"], ["rows"])


@pytest.mark.parametrize("summed", [False, True])
@pytest.mark.parametrize("is_compiled", [False, True])
def test_stack_equals_single_calls(
    summed: bool, is_compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not is_compiled:
        monkeypatch.setattr(backends, "select_fastest", backends.VirtualMachine)
    rng, calls, lanes = np.random.default_rng(2), 3, 7
    phi, d, q = (
        rng.normal(size=(1, lanes)),
        rng.normal(size=(calls, 2)),
        rng.normal(size=(calls, 2, lanes)),
    )
    stacked = StackedKernel(build_stack(), ["phi", "q"], ["d", "q"], summed)
    stacked.compile()
    rows = stacked(phi=phi, d=d, q=q)["rows"]
    kernel = Kernel(build_stack(), ["phi", "q"])
    for call in range(calls):
        expected = kernel(phi=phi, d=d[call], q=q[call])["rows"]
        np.testing.assert_allclose(
            rows[call], expected.sum(axis=1) if summed else expected, rtol=1e-13, atol=1e-15
        )


def test_a_stack_of_another_shape_is_refused() -> None:
    stacked = StackedKernel(build_stack(), ["phi", "q"], ["d", "q"])
    with pytest.raises(CallError, match="input q has the shape"):
        stacked(phi=np.zeros((1, 4)), d=np.zeros((3, 2)), q=np.zeros((2, 2, 4)))


@needs_compiler
def test_a_loop_of_too_many_operations_is_left_to_casadi(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "MAX_LOOP_SIZE", 5)
    stacked = StackedKernel(build_stack(), ["phi", "q"], ["d", "q"])
    assert backends.predict_backend(stacked.kernel.work) == "casadi-c"
    with pytest.raises(NotPrintableError, match="more than 5"):
        _ = stacked.kernel.work.loop
