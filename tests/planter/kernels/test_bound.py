"""Kernels on arrays that stay: the same numbers and the same strictness as a call, in some
microseconds less.
"""

from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from planter.errors import ComputationError
from planter.kernels import Array, BoundKernel, CallError, Kernel
from planter.kernels import kernel as kernel_module
from tests.support.lanes import needs_compiler, shortest

pytestmark = pytest.mark.usefixtures("kernel_cache")

WAYS = [*(pytest.param(way, marks=needs_compiler) for way in ("lanes", "casadi-c")), "casadi-vm"]
OVERHEAD_US = 5
phi, x, r, m = ca.SX.sym("phi"), ca.SX.sym("x", 2), ca.SX.sym("r"), ca.SX.sym("m", 2, 3)
PHI = np.linspace(0, 1, 7)


def build_kernel(
    outputs: dict[str, ca.SX], inputs: list[ca.SX], lanes: str = "phi", summed: bool = False
) -> Kernel:
    names = [argument.name().partition("_")[0] for argument in (ca.vec(i)[0] for i in inputs)]
    return Kernel(
        ca.Function("f", inputs, list(outputs.values()), names, list(outputs)),
        lanes.split(),
        summed,
    )


def wave() -> Kernel:
    return build_kernel({"y": x[0] * ca.sin(phi) + x[1], "root": ca.sqrt(1 + phi)}, [phi, x])


@pytest.fixture(params=WAYS)
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("PLANTER_KERNELS", request.param)
    return str(request.param)


def compiled(kernel: Kernel, way: str) -> Kernel:
    kernel.compile()
    assert kernel.way == way
    return kernel


class TestNumbers:
    def test_they_are_those_of_a_call(self, way: str) -> None:
        kernel = compiled(wave(), way)
        angles, values = PHI.copy(), np.array([2.0, 3.0])
        bound = kernel.bind(phi=angles, x=values)
        outputs = bound.outputs
        for factor in (1.0, -0.5, 2.5):
            angles[:] = factor * PHI
            values[:] = factor, 3.0
            expected = kernel(phi=angles, x=values)
            assert bound() is outputs
            for name, value in expected.items():
                assert outputs[name].shape == value.shape
                assert (outputs[name] == value).all(), name

    @pytest.mark.parametrize("summed", [False, True])
    def test_matrices_sums_and_inputs_of_any_kind(self, way: str, summed: bool) -> None:
        outputs = {
            "matrix": ca.densify(ca.mtimes(m.T, x) @ ca.horzcat(ca.sin(phi), r)),
            "column": x * phi,
        }
        kernel = compiled(build_kernel(outputs, [phi, x, r, m], "phi x", summed), way)
        rng = np.random.default_rng(2)
        values = {
            "phi": rng.normal(size=7),
            "x": rng.normal(size=(2, 7)),
            "r": np.array(0.7),
            "m": np.asfortranarray(rng.normal(size=(2, 3))),
        }
        actual, expected = kernel.bind(**values)(), kernel(**values)
        for name, value in expected.items():
            assert actual[name].shape == value.shape
            assert (actual[name] == value).all(), name

    def test_without_lanes(self, way: str) -> None:
        kernel = build_kernel({"y": ca.dot(x, x)}, [x], lanes="")
        kernel.compile()
        values = np.array([3.0, 4.0])
        bound = kernel.bind(x=values)
        assert bound()["y"].tolist() == [[25]]
        values[0] = 0
        assert bound()["y"].tolist() == [[16]]

    @needs_compiler
    def test_bound_kernel_uses_later_compilation_in_place(self) -> None:
        kernel, angles = wave(), PHI.copy()
        bound = kernel.bind(phi=angles, x=np.array([2.0, 3.0]))
        slow, outputs = bound()["y"].copy(), bound.outputs
        values = outputs["y"]
        kernel.compile()
        assert kernel.way == "lanes"
        assert bound() is outputs
        assert outputs["y"] is values
        assert values == pytest.approx(slow, rel=1e-15)
        angles += 1
        bound()
        assert values[0] == pytest.approx(2 * np.sin(PHI + 1) + 3, rel=1e-15)


WRONG: dict[str, tuple[dict[str, object], str]] = {
    "a list": ({"phi": PHI, "x": [1.0, 2.0]}, "input x must be an array of float64"),
    "whole numbers": (
        {"phi": np.arange(7), "x": np.zeros(2)},
        "input phi must be an array of float64",
    ),
    "single precision": (
        {"phi": PHI.astype(np.float32), "x": np.zeros(2)},
        "input phi must be an array of float64",
    ),
    "the other byte order": (
        {"phi": PHI.astype(PHI.dtype.newbyteorder()), "x": np.zeros(2)},
        "array of float64",
    ),
    "not aligned": (
        {"phi": np.zeros(57, np.uint8)[1:].view(float), "x": np.zeros(2)},
        "array of float64",
    ),
    "too long": ({"phi": PHI, "x": np.zeros(3)}, r"input x has the shape .* expected \(2, 1\)"),
    "every second": (
        {"phi": np.linspace(0, 2, 14)[::2], "x": np.zeros(2)},
        "input phi must be contiguous, row by row",
    ),
    "a column": (
        {"phi": PHI, "x": np.zeros((2, 4))[:, 1]},
        "input x must be contiguous, column by column",
    ),
}


class TestRefused:
    @pytest.mark.parametrize("case", WRONG)
    def test_to_be_bound(self, case: str, way: str) -> None:
        arguments, message = WRONG[case]
        with pytest.raises(CallError, match=message):
            compiled(wave(), way).bind(**arguments)  # type: ignore[arg-type]

    def test_lanes_and_matrices_in_the_wrong_order(self) -> None:
        kernel = build_kernel({"y": ca.sum1(x) * ca.sum2(ca.sum1(m))}, [x, m], lanes="x")
        columns, rows = np.asfortranarray(np.ones((2, 7))), np.ones((2, 3))
        with pytest.raises(CallError, match="input x must be contiguous, row by row"):
            kernel.bind(x=columns, m=np.asfortranarray(rows))
        with pytest.raises(CallError, match="input m must be contiguous, column by column"):
            kernel.bind(x=np.ascontiguousarray(columns), m=rows)

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize("name", ["phi", "x"])
    def test_non_finite_argument_is_refused_at_call(self, way: str, name: str, bad: float) -> None:
        inputs = {"phi": PHI.copy(), "x": np.array([2.0, 3.0])}
        bound = compiled(wave(), way).bind(**inputs)
        bound()
        values = {name: value.copy() for name, value in bound.outputs.items()}
        inputs[name][-1] = bad
        with pytest.raises(CallError, match=f"f: input {name} is not finite: {bad}"):
            bound()
        for output, value in values.items():
            assert (bound.outputs[output] == value).all()
        inputs[name][-1] = 1.0
        bound()

    def test_no_nan_leaves(self, way: str) -> None:
        angles = PHI.copy()
        bound = compiled(wave(), way).bind(phi=angles, x=np.array([2.0, 3.0]))
        angles[4] = -2
        with pytest.raises(ComputationError, match=r"f: output root\[0\] is not finite in lane 4"):
            bound()

    @needs_compiler
    def test_without_a_look_it_would(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(kernel_module, "build_finite_check", lambda arrays: lambda: 0)
        kernel = wave()
        kernel.compile()
        assert np.isnan(kernel.bind(phi=-2 * np.ones(3), x=np.ones(2))()["root"]).all()

    def test_another_thread(self, way: str) -> None:
        bound = compiled(wave(), way).bind(phi=PHI, x=np.array([2.0, 3.0]))
        with (
            ThreadPoolExecutor(1) as pool,
            pytest.raises(CallError, match="was bound in another thread"),
        ):
            pool.submit(bound).result()
        bound()

    def test_threads_bind_separately(self, way: str) -> None:
        kernel = compiled(wave(), way)

        def run(number: int) -> bool:
            values = np.array([float(number), 1.0])
            bound = kernel.bind(phi=PHI.copy(), x=values)
            return all((bound()["y"] == kernel(phi=PHI, x=values)["y"]).all() for _ in range(50))

        with ThreadPoolExecutor(4) as pool:
            assert all(pool.map(run, range(8)))


class TestFinite:
    """Numbers of all kinds, by the compiled look and by NumPy's."""

    EDGES = (
        0.0,
        -0.0,
        5e-324,
        2.2250738585072014e-308,
        1.7976931348623157e308,
        -1.7976931348623157e308,
    )

    @pytest.fixture(params=[pytest.param("cc", marks=needs_compiler), "/nonexistent"], autouse=True)
    def _compiler(self, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("CC", request.param)

    @pytest.mark.parametrize("size", [1, 7, 64, 1001])
    @pytest.mark.parametrize("bad", [np.nan, -np.nan, np.inf, -np.inf])
    def test_where_the_first_stands(self, size: int, bad: float) -> None:
        arrays = [
            np.resize(self.EDGES, size),
            np.full(size, 1.0),
            np.zeros(0),
            np.resize(self.EDGES, size),
        ]
        check = kernel_module.build_finite_check(arrays)
        assert check() == 0
        for number in (3, 1, 0):
            arrays[number][size // 2] = bad
            assert check() == number + 1


@needs_compiler
def test_bound_call_overhead_is_small() -> None:
    radius: Array = np.array([0.05])
    angles = np.linspace(0, 2 * np.pi, 360)
    kernel = build_kernel({"x": r * ca.cos(phi)}, [phi, r])
    kernel.compile()
    bound = kernel.bind(phi=angles, r=radius)
    assert isinstance(bound, BoundKernel)
    loop = kernel._way.prepared(bound._inputs, [bound.outputs["x"]], 360)  # type: ignore[attr-defined]
    assert shortest(bound) - shortest(loop) < OVERHEAD_US
