"""Stacks of calls: the same as the kernel call by call, compiled or not."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from planter.kernels import CallError, Kernel, backends
from planter.kernels.kernel import StackedKernel
from planter.kernels.lane_graph import NotPrintableError
from tests.support.lanes import needs_compiler


def build_function() -> ca.Function:
    phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", 2), ca.SX.sym("q", 2)
    rows = ca.vertcat(d[0] * ca.sin(phi) + q[0], d[1] / (2 + ca.cos(phi + q[1])), q[0] * q[1])
    return ca.Function("stacked_rows", [phi, d, q], [rows], ["phi", "d", "q"], ["rows"])


@pytest.mark.parametrize("summed", [False, True])
@pytest.mark.parametrize("compiled", [False, True])
def test_stack_equals_single_calls(
    summed: bool, compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not compiled:
        monkeypatch.setattr(backends, "select_fastest", backends.build_virtual_machine)
    rng, calls, lanes = np.random.default_rng(2), 3, 7
    phi, d, q = (
        rng.normal(size=(1, lanes)),
        rng.normal(size=(calls, 2)),
        rng.normal(size=(calls, 2, lanes)),
    )
    stacked = StackedKernel(build_function(), ["phi", "q"], ["d", "q"], summed)
    stacked.compile()
    rows = stacked(phi=phi, d=d, q=q)["rows"]
    kernel = Kernel(build_function(), ["phi", "q"])
    for call in range(calls):
        expected = kernel(phi=phi, d=d[call], q=q[call])["rows"]
        np.testing.assert_allclose(
            rows[call], expected.sum(axis=1) if summed else expected, rtol=1e-13, atol=1e-15
        )


def test_a_stack_of_another_shape_is_refused() -> None:
    stacked = StackedKernel(build_function(), ["phi", "q"], ["d", "q"])
    with pytest.raises(CallError, match="input q has the shape"):
        stacked(phi=np.zeros((1, 4)), d=np.zeros((3, 2)), q=np.zeros((2, 2, 4)))


@needs_compiler
def test_a_loop_of_too_many_operations_is_left_to_casadi(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "MAX_LOOP_SIZE", 5)
    stacked = StackedKernel(build_function(), ["phi", "q"], ["d", "q"])
    assert backends.predict_backend(stacked.kernel.work) == "casadi-c"
    with pytest.raises(NotPrintableError, match="more than 5"):
        _ = stacked.kernel.work.loop
