"""Outputs of a machine in rows and batches: slopes against differences, first-order bands against
drawn ones, reasons, refusals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from planter import CallError, OutputBatch, evaluate_many, load_machine
from planter.engine.goal import Goal, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import parse_sum
from planter.engine.outputs import SampledOutputs, find_output, list_outputs
from planter.engine.summary import summarise_machine
from planter.errors import ComputationError, InputError, PlanterError
from planter.kernels import Array, backends
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from tests.support import own

INPUTS = ("values.r_mm", "values.m_r_kg", "values.omega_rpm")
NAMES = ("M_in_max_Nm", "F_Ox_min_N", "F_Ox_range_N", "M_in_mean_Nm", "F_Ax_std_N", "M_in_rms_Nm")
ANGLES = 36


@pytest.fixture(autouse=True)
def plain_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compile nothing: rows are few here."""
    monkeypatch.setattr(backends, "select_fastest", backends.VirtualMachine)


def slider_crank() -> Machine:
    return build_machine(own.file("slider_crank"))


def find_differences(function: Callable[[Array], Array], x: Array) -> Array:
    """Return central differences (k, n) of a function (m, n) -> (m, k)."""
    steps = np.diag(1e-5 * np.abs(x))
    return ((function(x + steps) - function(x - steps)) / (2 * steps.sum(axis=1)[:, None])).T


def test_slopes_of_outputs_agree_with_differences() -> None:
    outputs = SampledOutputs(slider_crank(), INPUTS, NAMES, ANGLES)
    x = outputs.machine.design / outputs.machine.scale
    values, slopes = outputs.slopes(x)
    np.testing.assert_array_equal(values, outputs.evaluated(x[None], 1)[0])
    differences = find_differences(lambda points: outputs.evaluated(points, 1), x)
    scale = np.abs(slopes).max(axis=1, keepdims=True)
    np.testing.assert_allclose(slopes / scale, differences / scale, atol=1e-7)
    assert np.abs(slopes[:, [1, 0, 2]] - differences).max() > 0.1, (
        "slopes in exchanged inputs are recognised"
    )


def test_a_row_without_a_cycle_has_the_reason_of_the_model() -> None:
    outputs = SampledOutputs(slider_crank(), ("values.r_mm", "values.mu"), NAMES[:1], ANGLES)
    for r, mu in ((260.0, 0.1), (5000.0, 0.1), (50.0, 40.0)):
        with pytest.raises(PlanterError) as refusal:
            Model(own.machine("slider_crank", r_mm=r, mu=mu))(outputs.rows.angles)
        with pytest.raises(ComputationError) as error:
            outputs.slopes(np.array([r, mu]))
        assert error.value.message == refusal.value.message


def test_outputs_are_called_after_quantity_measure_and_unit() -> None:
    outputs = list_outputs(slider_crank())
    assert {"M_in_max_Nm", "beta_range_deg", "F_Ox_rms_N"} <= outputs.keys()
    assert outputs["F_Ox_rms_N"].meaning.endswith(": root mean square over a turn")


def test_every_measure_text_is_an_output() -> None:
    """A plain measure is that of its name; others are those of a goal, and have its slopes."""
    texts = (
        "rms M_in",
        "jump F_Ox [N]",
        "abs beta where s is least",
        "min M_in while s <= 0.2 m",
        "beta at 90 [deg]",
    )
    outputs = SampledOutputs(slider_crank(), INPUTS, ["M_in_rms_Nm", *texts], ANGLES)
    names = [output.name for output in outputs.outputs[1:]]
    assert names == [
        "rms M_in [N m]",
        "jump F_Ox [N]",
        "abs beta where s is least [deg]",
        "min M_in while s <= 200 mm [N m]",
        "beta at 90 [deg]",
    ]
    x = outputs.machine.design / outputs.machine.scale
    values, slopes = outputs.slopes(x)
    assert values[0] == values[1]
    shocks = [
        shock for shock in summarise_machine(slider_crank()).shocks if shock.quantity == "F_Ox"
    ]
    assert values[2] == pytest.approx(
        max(abs(shock.after - shock.before) for shock in shocks), rel=1e-12
    )
    differences = find_differences(lambda points: outputs.evaluated(points, 1), x)
    np.testing.assert_allclose(slopes, differences, atol=2e-6 * np.abs(slopes).max(axis=1).max())


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("jumb F_Ox", "did you mean jump"),
        ("jump F_Oxx", "did you mean F_Ox"),
        ("jump F_Ox [mm]", "it is in N"),
        ("s at 2 s", "an angle drives it"),
        ("F_Ox_rmss_N", "did you mean F_Ox_rms_N"),
        ("mean abs s", "takes no abs"),
    ],
)
def test_invalid_output_is_refused(name: str, part: str) -> None:
    with pytest.raises(InputError, match=part):
        find_output(slider_crank(), name)


@pytest.mark.parametrize(
    "objective",
    [
        "range F_Ox + 2 std M_in",
        "2 rms M_in + beta at 90 + 0.1 abs beta at -80",
        "beta at 33.3",
        "max abs F_Ax while s >= 200 mm",
        "max abs F_Ax + 2 work M_in - work P_guide",
    ],
)
def test_objective_equals_sum_in_file(objective: str) -> None:
    """Sums of plain measures come from the samples, those with clauses from the machine's goal:
    both are a goal's.
    """
    machine = replace(slider_crank(), objective=parse_sum(objective))
    outputs = SampledOutputs(machine, INPUTS, ["objective"], ANGLES)
    terms = [resolve_measure(machine, measure) for measure in machine.objective]
    goal = Goal(outputs.machine, terms, [], ANGLES)
    x = goal.machine.design
    points = x / goal.machine.scale * np.array([[1.0], [1.02]])
    values, slopes = outputs.gradients(points, 1)
    assert bool(outputs._goals) == (
        objective in ("beta at 33.3", "max abs F_Ax while s >= 200 mm") or "P_guide" in objective
    )
    expected = [goal.evaluate(point * goal.machine.scale) for point in points]
    np.testing.assert_allclose(values[:, 0], expected, rtol=1e-12)
    np.testing.assert_allclose(outputs.evaluated(points, 1), values, rtol=1e-15)
    np.testing.assert_allclose(slopes[0, 0], goal.slope(x) * goal.machine.scale, rtol=1e-8)
    assert np.isnan(outputs.evaluated(np.array([[5000.0, *points[0, 1:]]]), 1)).all()


def test_variance_equals_components_of_objective() -> None:
    machine = replace(slider_crank(), objective=parse_sum("range F_Ox + 2 std M_in"))
    names = list_outputs(machine)
    assert [name for name in names if "variance" in name] == ["F_Ox_variance_N2"], (
        "no unit is called N m squared"
    )
    outputs = SampledOutputs(machine, INPUTS, ["F_Ox_variance_N2", "F_Ox_std_N"], ANGLES)
    variance, std = outputs.evaluated(outputs.machine.design[None] / outputs.machine.scale, 1)[0]
    assert variance == pytest.approx(std**2, rel=1e-12)


BATCH = ("M_in_rms_Nm", "F_Ox_max_N")


def bounded_crank() -> Machine:
    return load_machine(str(own.generated("slider_crank") / "slider_crank.toml"))


def test_many_designs_have_exact_gradients_in_si() -> None:
    machine = bounded_crank()
    steps = 1e-5 * np.diag(machine.design)
    designs = np.vstack([machine.design, machine.design + steps, machine.design - steps])
    batch = evaluate_many(machine, designs, ANGLES, gradients=True, outputs=BATCH)
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
    plain = evaluate_many(machine, designs, ANGLES, outputs=BATCH, threads=2)
    np.testing.assert_array_equal(plain.values, batch.values)
    assert plain.gradient is None


def test_designs_without_a_cycle_have_no_numbers() -> None:
    machine = bounded_crank().with_moved({"values.l_mm": (20, 300)})
    batch = evaluate_many(machine, np.array([[0.2], [0.02]]), ANGLES, gradients=True, outputs=BATCH)
    assert batch.gradient is not None
    assert np.isfinite(batch.values[0]).all()
    assert np.isnan(batch.values[1]).all()
    assert np.isnan(batch.gradient[1]).all()


def test_wrong_outputs_and_shapes_are_refused() -> None:
    machine = bounded_crank()
    with pytest.raises(InputError, match="no output M_in_rms: did you mean M_in_rms_Nm"):
        evaluate_many(machine, machine.design[None], outputs=["M_in_rms"])
    with pytest.raises(InputError, match="outputs is empty"):
        evaluate_many(machine, machine.design[None], outputs=[])
    with pytest.raises(CallError, match="shape"):
        evaluate_many(machine, machine.design, outputs=BATCH)
    with pytest.raises(InputError, match="no values are to be varied"):
        evaluate_many(machine.with_moved({}), np.empty((1, 0)), outputs=BATCH)
