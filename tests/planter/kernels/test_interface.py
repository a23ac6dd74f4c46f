"""Loops as functions of CasADi's, for its solvers."""

import casadi as ca
import numpy as np
import pytest

from planter.kernels import Kernel, backends
from tests.support.lanes import needs_compiler, work

pytestmark = [needs_compiler, pytest.mark.usefixtures("kernel_cache")]

phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 2)
OUTPUTS = {"curve": x[0] * ca.sin(phi) + x[1], "both": ca.vertcat(phi**2, x[0] * phi)}
PHI = np.linspace(-1, 2, 9)


def build_backend(summed: bool) -> tuple[backends.LaneBackend, ca.Function]:
    way = backends.build_lane_backend(work("phi x", OUTPUTS, [phi, x], "phi", summed))
    assert isinstance(way, backends.LaneBackend)
    return way, way.interface(len(PHI))


@pytest.mark.parametrize("summed", [False, True])
def test_interface_equals_loop(summed: bool) -> None:
    way, function = build_backend(summed)
    expected = way([PHI[None], np.array([[0.3], [2.0]])], len(PHI))
    for value, reference in zip(function(PHI, [0.3, 2.0]), expected, strict=True):
        assert (np.array(value) == reference.T).all()


def test_unrequested_results_are_skipped() -> None:
    """A graph that uses one output hands out no memory for the other."""
    _, function = build_backend(summed=False)
    inputs = ca.MX.sym("given", 2)
    second = ca.Function("second", [inputs], [function(PHI, inputs)[1]])
    first = ca.Function("first", [inputs], [ca.sum1(function(PHI, inputs)[0])])
    assert np.array(second([0.3, 2.0])) == pytest.approx(np.stack([PHI**2, 0.3 * PHI], axis=1))
    assert float(first([0.3, 2.0])) == pytest.approx((0.3 * np.sin(PHI) + 2).sum())


def test_inside_a_solver() -> None:
    """Least squares with the loop's values and slopes: no other derivatives are there."""
    slope = ca.jacobian(OUTPUTS["curve"], x).T
    residual = backends.build_lane_backend(
        work("phi x", {"y": OUTPUTS["curve"], "g": ca.densify(slope)}, [phi, x], "phi")
    )
    assert isinstance(residual, backends.LaneBackend)
    step = residual.interface(len(PHI))
    target, at = 0.7 * np.sin(PHI) - 0.2, np.zeros(2)
    for _ in range(2):
        y, g = (np.array(v) for v in step(PHI, at))
        at = at + np.linalg.lstsq(g, target - y[:, 0], rcond=None)[0]
    assert at == pytest.approx([0.7, -0.2], rel=1e-12)


def test_only_lane_kernels_have_the_interface(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = Kernel(work("phi x", OUTPUTS, [phi, x], "phi").function, lanes=["phi"])
    assert kernel.interface(9) is None
    kernel.compile()
    assert isinstance(kernel.interface(9), ca.Function)
    monkeypatch.setenv("PLANTER_KERNELS", "casadi-c")
    kernel.compile()
    assert kernel.way == "casadi-c"
    assert kernel.interface(9) is None
