"""What becomes of a function: selects, truth values, sums, what varies, what has no such form."""

import casadi as ca
import numpy as np
import pytest

from planter.kernels import Kernel, backends
from planter.kernels.backends import LaneTask
from planter.kernels.lane_graph import OPERATIONS, LaneGraph, NotPrintableError, ScalarOperation
from planter.kernels.lane_source import print_function
from tests.support.lanes import (
    both,
    difference,
    evaluated,
    for_processor,
    needs_compiler,
    unsummed,
    work,
)

pytestmark = pytest.mark.usefixtures("kernel_cache")

phi, x, y = ca.SX.sym("phi"), ca.SX.sym("x", 2), ca.SX.sym("y")
PHI = np.linspace(-4, 4, 41)
RNG = np.random.default_rng(7)


@needs_compiler
class TestSelects:
    """The side that is not taken may be anything, also infinite or no number."""

    root = work(
        "phi y",
        {
            "pole": ca.if_else(phi > 0, 1 / phi, 2.0),
            "root": ca.if_else(phi >= 1, ca.sqrt(phi - 1), phi),
            "logarithm": ca.if_else(phi <= 0, -1.0, ca.log(phi)),
            "power": ca.if_else(phi > 0, phi**1.5, 0.0),
            "far": ca.if_else(phi < 2, 0.5, ca.exp(1e4 * phi)),
            "flag": ca.if_else(y, 1 / phi, phi),
        },
        [phi, y],
        "phi y",
    )
    at = np.array(
        [[-3.0, -1.0, -0.0, 0.0, 1e-300, 0.5, 1.0, 1.5, 1.999999], [1, 1, 0, 0, 1, 0, 0, 1, 1]]
    )

    def test_the_other_side_does_not_show(self) -> None:
        with np.errstate(all="ignore"):
            actual, expected = both(self.root, *self.at)
        for name, value in expected.items():
            assert np.isfinite(actual[name]).all()
            assert actual[name] == pytest.approx(value, rel=1e-14)

    def test_a_product_in_place_of_a_select_would_show(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setitem(OPERATIONS, ca.OP_IF_ELSE_ZERO, ScalarOperation("{0} * {1}", 2))
        task = LaneTask(self.root.function, ("phi", "y"), summed=False)
        with np.errstate(all="ignore"):
            actual = evaluated(task, backends.build_compiled(task, "lanes"), *self.at)
        assert not np.isfinite(actual["flag"]).all()

    def test_a_derivative_takes_the_same_side(self) -> None:
        slope = ca.gradient(ca.if_else(phi > 0, phi**2.5, ca.sin(phi)), phi)
        actual, expected = both(work("phi", {"slope": slope}, [phi], "phi"), self.at[0])
        assert actual["slope"] == pytest.approx(expected["slope"], rel=1e-14)


@needs_compiler
def test_truth_of_other_numbers() -> None:
    """For CasADi as for C, what is not zero is true: logic of 0.5 and -3 is that of ones."""
    p, q = ca.SX.sym("p"), ca.SX.sym("q")
    outputs = {
        "both": ca.logic_and(p, q),
        "either": ca.logic_or(p, q),
        "neither": ca.logic_not(ca.logic_or(p, q)),
        "chosen": ca.if_else(p, 2.0, 3.0),
        "mixed": ca.logic_and(p > q, q),
    }
    table = np.array(
        [(p, q) for p in (0.0, -0.0, 0.5, -3.0, 1.0, 1e-300) for q in (0.0, 0.25, -2.0, 1.0)]
    ).T
    task = work("p q", outputs, [p, q], "p q")
    actual, expected = both(task, *table)
    first, second = table != 0
    assert (expected["both"][0] == (first & second)).all()
    for name, value in expected.items():
        assert (actual[name] == value).all(), name


FORCE = {"one": x[0] * ca.sin(phi) + x[1] * y, "two": ca.cos(x[0]) + phi * y**2}


@needs_compiler
class TestWhatVaries:
    @pytest.mark.parametrize("varying", ["phi", "x", "phi x", "x y", "phi x y", "y"])
    @pytest.mark.parametrize("summed", [False, True])
    def test_angles_designs_or_both(self, varying: str, summed: bool) -> None:
        task = work("phi x y", FORCE, [phi, x, y], varying, summed)
        sizes = {"phi": 1, "x": 2, "y": 1}
        arrays = [
            RNG.normal(size=(rows, 37 if name in varying.split() else 1))
            for name, rows in sizes.items()
        ]
        actual, expected = both(task, *arrays)
        for name, value in expected.items():
            assert value.shape == (1, 1 if summed else 37)
            assert actual[name] == pytest.approx(value, rel=1e-13, abs=1e-13)

    def test_a_sum_is_the_sum_of_the_rows(self) -> None:
        task = work("phi x y", FORCE, [phi, x, y], "phi", summed=True)
        total, _ = both(task, PHI, [[0.3], [2.0]], 0.7)
        rows, _ = both(unsummed(task), PHI, [[0.3], [2.0]], 0.7)
        assert total["one"][0, 0] == pytest.approx(rows["one"].sum(), rel=1e-13)

    def test_invariants_precede_the_loop(self) -> None:
        graph = LaneGraph.from_function(
            work("phi x y", FORCE, [phi, x, y], "phi").function, ["phi"]
        )
        outside, inside = print_function(graph, summed=False).split("for (long i")
        assert "turned_cos(" in outside
        assert "turned_sin(" in inside
        assert "turned_cos(" not in inside

    @pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 8, 9, 63])
    def test_any_number_of_lanes(self, count: int) -> None:
        task = work("phi x y", FORCE, [phi, x, y], "phi")
        at = RNG.normal(size=(1, count))
        actual = backends.build_compiled(task, "lanes")(
            [at, np.array([[0.3], [2.0]]), np.array([[0.7]])], count
        )
        assert actual[0] == pytest.approx(0.3 * np.sin(at) + 1.4, rel=1e-14)


@needs_compiler
@pytest.mark.parametrize("summed", [False, True])
def test_a_matrix_for_each_lane(summed: bool) -> None:
    """Matrices stand beside each other, as CasADi's map has them; one memory for each element."""
    matrix = ca.vertcat(x[0], x[1], phi) @ ca.horzcat(ca.sin(phi), x[0] * phi)
    task = work("phi x", {"matrix": ca.densify(matrix), "column": x * phi}, [phi, x], "phi", summed)
    actual, expected = both(task, PHI, [[0.3], [2.0]])
    assert expected["matrix"].shape == (3, 2 if summed else 82)
    for name, value in expected.items():
        assert actual[name].shape == value.shape
        assert actual[name] == pytest.approx(value, rel=1e-13, abs=1e-13)


@needs_compiler
def test_constants_and_inputs_as_outputs() -> None:
    outputs = {
        "fixed": ca.SX([-2.5, 0.0, -0.0, 1e-300]),
        "same": phi,
        "negative": 3 - phi * (-1e300),
        "zero": phi * -0.0,
    }
    task = work("phi x", outputs, [phi, x], "phi")
    actual, expected = both(task, PHI, [[0.3], [2.0]])
    for name, value in expected.items():
        assert (actual[name] == value).all(), name


@needs_compiler
def test_repeated_expression_is_computed_once() -> None:
    twice = {"one": ca.sin(phi) * x[0], "two": ca.sin(phi) + x[0] * ca.sin(phi)}
    task = work("phi x", twice, [phi, x], "phi")
    loop = print_function(LaneGraph.from_function(task.function, ["phi"]), summed=False)
    assert loop.count("turned_sin") == 1
    assert loop.count("phi[i]") == 1
    actual, expected = both(task, PHI, [[0.3], [2.0]])
    assert difference(actual["two"], expected["two"]) < 1e-15


def _solver() -> ca.Function:
    u, p = ca.SX.sym("u"), ca.SX.sym("p")
    solver = ca.rootfinder("solver", "fast_newton", ca.Function("g", [u, p], [u**2 - p]))
    parameter = ca.MX.sym("p")
    return ca.Function("solved", [parameter], [solver(1.0, parameter)], ["p"], ["u"])


def _unlike(*outputs: ca.SX, names: tuple[str, str] = ("phi", "y")) -> ca.Function:
    return ca.Function("f", [phi, x], list(outputs), [names[0], "x"], [names[1]])


MATRIX, SPARSE = ca.SX.sym("m", 2, 2), ca.SX(ca.Sparsity.diag(2), x)
NO_FORM = {
    "a solver": (_solver(), "p", r"solved: instruction \d+ \(operation \d+\) has no form in C"),
    "no such input": (_unlike(phi), "psi", "f has no input psi, which is to vary over the lanes"),
    "a sparse output": (_unlike(SPARSE), "phi", "f: y must be dense"),
    "a sparse input": (
        ca.Function("f", [phi, SPARSE], [phi], ["phi", "s"], ["y"]),
        "phi",
        "f: s must be dense",
    ),
    "a name of the loop": (
        _unlike(phi, names=("t12", "y")),
        "t12",
        "f: the name t12 is used by the loop itself",
    ),
    "the counter's name": (
        _unlike(phi, names=("phi", "i")),
        "phi",
        "f: the name i is used by the loop itself",
    ),
    "an infinite constant": (_unlike(phi + ca.inf), "phi", "the constant inf is not finite"),
    "a matrix that varies": (
        ca.Function("f", [MATRIX], [MATRIX[0, 1]], ["m"], ["y"]),
        "m",
        "f: m varies over the lanes and must be a column",
    ),
    "an operation without a form": (_unlike(ca.erfinv(phi)), "phi", "has no form in C"),
}


@pytest.mark.parametrize("case", NO_FORM)
def test_unsupported_form_has_a_reason(case: str) -> None:
    function, varying, reason = NO_FORM[case]
    with pytest.raises(NotPrintableError, match=reason):
        LaneGraph.from_function(function, [varying])


@needs_compiler
def test_unsupported_form_uses_another_backend(capfd: pytest.CaptureFixture[str]) -> None:
    kernel = Kernel(_solver(), lanes=["p"])
    kernel.compile()
    assert kernel.way == "casadi-c"
    assert kernel(p=[[4.0, 9.0]])["u"][0] == pytest.approx([2, 3])
    assert capfd.readouterr() == ("", "")


@needs_compiler
def test_a_function_of_matrices_is_expanded() -> None:
    m, p = ca.MX.sym("m", 2), ca.MX.sym("p")
    function = ca.Function("f", [p, m], [ca.dot(m, ca.vertcat(ca.sin(p), p))], ["p", "m"], ["y"])
    actual, expected = both(LaneTask(function, ("p",), summed=False), PHI, [[0.3], [2.0]])
    assert difference(actual["y"], expected["y"]) < 1e-15


@needs_compiler
def test_angles_in_lanes_for_a_plain_processor(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """Sine and cosine of one angle, which a compiler would merge into a call that has no vector
    form.
    """
    task = work("phi", {"s": ca.sin(phi), "c": ca.cos(phi)}, [phi], "phi")
    for march in ("x86-64", "native"):
        actual = evaluated(task, for_processor(task, march, tmp_path / march), PHI)
        assert actual["s"] ** 2 + actual["c"] ** 2 == pytest.approx(
            np.ones((1, len(PHI))), rel=1e-15
        )
