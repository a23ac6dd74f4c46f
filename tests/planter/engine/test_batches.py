"""Many designs of any machine: outputs by name, gradients against differences, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from planter import CallError, InputError, OutputBatch, evaluate_many, load_mechanism
from planter.engine.machine import Machine
from planter.kernels import backends
from tests.support import own

OUTPUTS = ("M_in_rms_Nm", "F_Ox_max_N")
ANGLES = 36


@pytest.fixture(autouse=True)
def plain_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "select_fastest", backends.VirtualMachine)


def slider_crank() -> Machine:
    return load_mechanism(str(own.generated("slider_crank") / "slider_crank.toml"))


def test_many_designs_have_exact_gradients_in_si() -> None:
    machine = slider_crank()
    steps = 1e-5 * np.diag(machine.design)
    designs = np.vstack([machine.design, machine.design + steps, machine.design - steps])
    batch = evaluate_many(machine, designs, ANGLES, gradients=True, outputs=OUTPUTS)
    assert isinstance(batch, OutputBatch)
    assert batch.gradient is not None
    above, below = batch.values[1:4], batch.values[4:]
    differences = ((above - below) / (2 * np.diag(steps))[:, None]).T
    scale = np.abs(differences).max(axis=1, keepdims=True)
    np.testing.assert_allclose(batch.gradient[0] / scale, differences / scale, atol=1e-7)
    assert np.abs(batch.gradient[1] / scale - differences / scale).max() > 1e-6, (
        "another design has another gradient"
    )
    np.testing.assert_array_equal(batch["F_Ox_max_N"], batch.values[:, 1])
    plain = evaluate_many(machine, designs, ANGLES, outputs=OUTPUTS, threads=2)
    np.testing.assert_array_equal(plain.values, batch.values)
    assert plain.gradient is None


def test_designs_without_a_cycle_have_no_numbers() -> None:
    machine = slider_crank().with_moved({"values.l_mm": (20, 300)})
    batch = evaluate_many(
        machine, np.array([[0.2], [0.02]]), ANGLES, gradients=True, outputs=OUTPUTS
    )
    assert batch.gradient is not None
    assert np.isfinite(batch.values[0]).all()
    assert np.isnan(batch.values[1]).all()
    assert np.isnan(batch.gradient[1]).all()


def test_wrong_outputs_and_shapes_are_refused() -> None:
    machine = slider_crank()
    with pytest.raises(InputError, match="no output M_in_rms: did you mean M_in_rms_Nm"):
        evaluate_many(machine, machine.design[None], outputs=["M_in_rms"])
    with pytest.raises(InputError, match="outputs is empty"):
        evaluate_many(machine, machine.design[None], outputs=[])
    with pytest.raises(CallError, match="shape"):
        evaluate_many(machine, machine.design, outputs=OUTPUTS)
    with pytest.raises(InputError, match="no values are to be varied"):
        evaluate_many(machine.with_moved({}), np.empty((1, 0)), outputs=OUTPUTS)
