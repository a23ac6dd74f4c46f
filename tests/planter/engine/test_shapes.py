"""Shapes of composed functions: every number of hoisted and moved values, quantities and
samples.
"""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from planter.engine.goal import Goal
from planter.engine.machine import Machine, Quantity, Value
from planter.engine.measures import Measure
from planter.engine.outputs import SampledOutputs
from planter.engine.response import MachineResponse
from planter.engine.rows import MachineRows
from planter.engine.sensitivity import compute_sensitivity
from planter.engine.summary import PiecewiseCycle, build_rows, summarise
from planter.exports.quantities import SampledGoal, build_motion, build_prologues
from planter.kernels import Array, CallError, Kernel
from planter.rows.robust import RobustGoal, Settings

STEP = 1e-30
"""Step of complex differences, whose error is rounding."""
SMALL = 1e-5
"""Step of differences of exact slopes: the square of it, times a third derivative, is below
TOLERANCE.
"""
TOLERANCE = 1e-8
DATA = np.array([0.7, 1.3, 2.0])
NAMES = ("a", "b", "n")
SHAPES = list(itertools.product((0, 1, 2), (0, 1, 2), (1, 2), (False, True)))
"""Numbers of hoisted values, moved values and quantities, and whether an angle changes the
quantities.
"""


def hoist(d: Any, count: int) -> list[Any]:
    return [d[0] * d[1] ** 2, d[0] ** 3 / d[1]][:count]


def formulas(phi: Any, d: Any, hoisted: list[Any], count: int, turning: bool, xp: Any) -> list[Any]:
    """Quantities by the same formulas in CasADi and NumPy; what is not hoisted is computed where it
    is.
    """
    first, second = [*hoisted, *hoist(d, 2)[len(hoisted) :]]
    wave = xp.sin(phi + d[1]) if turning else 1.0
    return [first * wave + second, second**2 + d[0] * wave][:count]


def build(hoisted: int, moved: int, count: int, turning: bool) -> Machine:
    phi, d = ca.SX.sym("phi"), ca.SX.sym("d", len(DATA))
    h, q = ca.SX.sym("h", hoisted), ca.SX.sym("q", 0)
    rows = formulas(phi, d, [h[i] for i in range(hoisted)], count, turning, ca)
    named = ["phi", "d", "h", "q"]
    prologue = ca.Function(
        "prologue", [d], [ca.vertcat(ca.SX(0, 1), *hoist(d, hoisted))], ["d"], ["y"]
    )
    return Machine(
        document=SimpleNamespace(name="shapes", source="shapes.toml", numbers=dict),  # type: ignore[arg-type]
        build=lambda document: build(hoisted, moved, count, turning),
        assumptions=(),
        values=tuple(Value(name, "1", name, f"values.{name}") for name in NAMES),
        data=DATA,
        moved=tuple(range(moved)),
        lower=0.5 * DATA[:moved],
        upper=1.5 * DATA[:moved],
        quantities=tuple(Quantity(f"y{i}", "1", "a quantity", f"y{i}") for i in range(count)),
        prologue=prologue,
        lane=ca.Function("lane", [phi, d, h, q], [ca.densify(ca.vertcat(*rows))], named, ["y"]),
        speed=2,
        objective=tuple(Measure("mean", f"y{i}") for i in range(count)),
        samples=5,
    )


def expected_values(shape: tuple[int, int, int, bool], phi: Array, data: Array = DATA) -> Array:
    _, _, count, turning = shape
    rows = formulas(phi, data, [], count, turning, np)
    return np.array([row * np.ones_like(phi) for row in rows])


def expected_slopes(shape: tuple[int, int, int, bool], phi: Array) -> Array:
    """Slopes (m, n, 1 + p) in the angle and the moved values, by complex differences."""
    steps = []
    for index in range(-1, shape[1]):
        data = DATA.astype(complex)
        angles = phi.astype(complex)
        if index < 0:
            angles = angles + 1j * STEP
        else:
            data[index] += 1j * STEP
        steps.append(expected_values(shape, angles, data).imag / STEP)
    return np.stack(steps, axis=2)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("samples", [1, 5])
def test_response_equals_complex_differences(
    shape: tuple[int, int, int, bool], samples: int
) -> None:
    machine, phi = build(*shape), np.linspace(0.3, 2.0, samples)
    response = MachineResponse(machine)
    point = response.at(machine.design)
    values, slopes = response.slopes(point, phi)
    expected = expected_slopes(shape, phi)
    np.testing.assert_allclose(values, expected_values(shape, phi), rtol=1e-14)
    np.testing.assert_allclose(slopes, expected, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(response.values(point, phi), values, rtol=1e-15)
    np.testing.assert_allclose(
        response.derivatives(point, phi)[1], expected[:, :, 0], rtol=1e-13, atol=1e-14
    )
    assert [part.shape for part in response.rates(point, phi)] == [values.shape] * 2

    def weighted_slope(step: Array) -> Array:
        moved = response.slopes(response.at(machine.design + step[1:]), phi + step[0])[1]
        return np.einsum("mn,mnp->np", weights, moved)

    weights = np.random.default_rng(1).normal(size=values.shape)
    hessians = response.curvatures(point, phi, weights)
    for index in range(1 + shape[1]):
        step = SMALL * np.eye(1 + shape[1])[index]
        rise = (weighted_slope(step) - weighted_slope(-step)) / (2 * SMALL)
        np.testing.assert_allclose(hessians[:, index], rise, atol=TOLERANCE)
    np.testing.assert_allclose(
        response.curvature(point, phi, weights), hessians.sum(axis=0), atol=1e-12
    )


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("samples", [1, 5])
def test_sampled_outputs_equal_complex_differences(
    shape: tuple[int, int, int, bool], samples: int
) -> None:
    machine = build(*shape)
    names = [f"{q.name}_{kind}" for q in machine.quantities for kind in ("max", "mean", "rms")]
    paths = [machine.values[index].path for index in machine.moved]
    outputs = SampledOutputs(machine, paths, names, samples)
    angles = machine.list_angles(samples)
    curves, slopes = expected_values(shape, angles), expected_slopes(shape, angles)[:, :, 1:]
    root = np.sqrt((curves**2).mean(axis=1))
    top = curves.argmax(axis=1)
    rows = np.arange(len(curves))
    parts = [
        slopes[rows, top],
        slopes.mean(axis=1),
        (curves[:, :, None] * slopes).mean(axis=1) / root[:, None],
    ]
    expected = np.stack([curves.max(axis=1), curves.mean(axis=1), root], axis=1).ravel()
    for count in (1, 3, 70):  # few rows are not compiled, many are
        values, gradients = outputs.gradients(np.repeat(machine.design[None], count, axis=0), 1)
        np.testing.assert_allclose(values, np.tile(expected, (count, 1)), rtol=1e-12)
        stacked = np.stack(parts, axis=1).reshape(len(names), -1)
        np.testing.assert_allclose(
            gradients, np.tile(stacked, (count, 1, 1)), rtol=1e-11, atol=1e-13
        )
        np.testing.assert_allclose(
            outputs.evaluated(np.repeat(machine.design[None], count, 0), 1), values, rtol=1e-12
        )


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_all_computations_take_every_shape(shape: tuple[int, int, int, bool]) -> None:
    machine = build(*shape)
    rows = MachineRows(machine, [q.name for q in machine.quantities], 1)
    samples = rows.evaluate(DATA[None], lambda block: block.samples[:, 0])
    np.testing.assert_allclose(samples[0], expected_values(shape, np.zeros(1))[:, 0], rtol=1e-13)
    summary = summarise(PiecewiseCycle(machine, build_rows(machine)))
    assert {peak.name for peak in summary.peaks} == {q.name for q in machine.quantities}
    assert build_motion(machine).columns[0].values.shape == (6,)
    sampled = SampledGoal(machine)
    assert sampled.function.numel_out(0) == 1
    tangent = sampled.response.tangent
    for function in build_prologues(machine, tangent):
        assert Kernel(function)(d=DATA)["h"].size == shape[0]
    terms = [Measure("mean", q.name) for q in machine.quantities]
    assert Goal(machine, terms).slope(machine.design).shape == (shape[1],)
    if shape[1]:
        assert len(compute_sensitivity(machine, terms).gradient) == shape[1]
        robust = RobustGoal(machine, {}, Settings(machines=3), 4)
        assert robust.evaluate(machine.design)[1].shape == (3, shape[1])


def test_entries_left_as_a_row_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = build(1, 2, 1, True)
    rows = MachineRows(machine, ["y0"], 5)
    rows.find_slopes(1)
    monkeypatch.setattr(
        ca, "vec", lambda matrix: matrix
    )  # CasADi's own order of the entries of a row
    _ = rows.tangents
    weights = np.ones((1, 5, 1))
    with pytest.raises(CallError, match="dh"):
        rows.evaluate(DATA[None], lambda block: rows.gradients(block, [0], weights)[0])
