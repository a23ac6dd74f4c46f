"""CUDA of mechanisms of one's own, on ordinary threads: loops closed for each design, statistics of all results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.engine.response import MachineResponse
from planter.errors import ComputationError
from planter.exports import cuda
from tests.planter.exports.exported import SAMPLES, library, machine, machine_file
from tests.support.cuda_on_threads import build_on_threads, needs_threads
from tests.support.lanes import needs_compiler


@needs_threads
@needs_compiler
def test_cuda_objective_equals_c(tmp_path: Path) -> None:
    name = "slider_crank"
    owner, crank = machine(name), library(name)
    designs = owner.design + np.outer([0.0, 0.2, -0.3], owner.upper - owner.design)
    batches = cuda.Batches(owner, build_on_threads(owner, tmp_path))
    assert batches.samples == SAMPLES
    for row, x in zip(batches(designs), designs, strict=True):
        _, value, _ = crank.gradient(x)
        np.testing.assert_allclose(row, list(value.values()), rtol=1e-10)
    designs[1, 1] = 0.04
    with pytest.raises(ComputationError, match="in row 1"):
        batches(designs)


@needs_threads
@pytest.mark.long
def test_cuda_without_an_objective_has_all_results(tmp_path: Path) -> None:
    owner = load_machine(str(machine_file("cam_follower", objective=False)))
    batches = cuda.Batches(owner, build_on_threads(owner, tmp_path), samples=30)
    row = batches(owner.design[None])[0]
    names = [quantity.name for quantity in owner.results]
    response = MachineResponse(owner, names)
    values = response.values(response.at(owner.design), 2 * np.pi * np.arange(30) / 30)
    expected = np.column_stack([np.ptp(values, axis=1), values.var(axis=1), values.mean(axis=1)])
    scale = np.maximum(np.abs(expected).max(axis=1, keepdims=True), 1e-9)
    assert (np.abs(row.reshape(-1, 3) - expected) / scale).max() <= 1e-10
    assert [field.name for field in batches.goal.fields][:2] == [f"range_{names[0]}", f"variance_{names[0]}"]
