"""Sweeps and tolerances of mechanisms that move freely: rows against closed forms, bands against
linear theory.
"""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.engine.outputs import SampledOutputs, list_default_outputs
from tests.planter.mechanism.test_motion_measures import (
    BALL,
    OSCILLATOR,
    free_machine,
    oscillate,
)
from tests.support import own
from tests.support.cli import answer, refusal

SOURCE = "x at 1 s [mm]"


def write_plan(folder: Path, outputs: list[str], **inputs: list[float]) -> Path:
    path, source = folder / "plan.toml", own.generated(OSCILLATOR) / "own.toml"
    lines = [f"machine = {json.dumps(str(source))}", f"outputs = {json.dumps(outputs)}"]
    lines += ["[inputs]", *(f"{name} = {values}" for name, values in inputs.items())]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def sweep(folder: Path, outputs: list[str], **inputs: list[float]) -> np.ndarray[Any, Any]:
    plan = write_plan(folder, outputs, **inputs)
    answer(f"sweep {plan} --workers 1 --out", str(folder / "run"))
    with (folder / "run" / "rows.csv").open(encoding="utf-8") as file:
        rows = [line for line in csv.reader(file) if line[0][:1] in "-0123456789"]
    return np.array(rows, dtype=float)


@pytest.mark.usefixtures("blank_figures")
def test_rows_of_a_sweep_are_those_of_the_closed_form(tmp_path: Path) -> None:
    outputs = [SOURCE, "min x over 0.1..1 s", "rms x over 0..2 s"]
    rows = sweep(tmp_path, outputs, k_N_m=[30.0, 50.0], c_N_s_m=[0.1, 1.0, 2.0])
    assert len(rows) == 6
    times = np.linspace(0.0, 2.0, 200_001)
    for k, c, at, low, rms in rows:
        x = 1e3 * oscillate(0.5, k, c, 0.1, times)
        expected = [x[100_000], x[10_000:100_001].min(), np.sqrt(np.trapezoid(x**2, times) / 2)]
        assert [at, low, rms] == pytest.approx(expected, rel=1e-7)


def test_slopes_of_outputs_are_those_of_differences_through_contacts() -> None:
    machine = free_machine(BALL, "k y_0")
    names = ["y at 0.7 s", "max N_c over 0..0.5 s"]
    outputs = SampledOutputs(machine, machine.moved_paths, names)
    assert outputs.machine.motion is not None
    assert outputs.machine.motion.span == 0.7, "as long as the longest output asks"
    point = machine.design / machine.scale
    slopes = outputs.slopes(point)[1]
    for column, step in enumerate(np.diag(1e-4 * point)):
        above, below = (outputs.evaluated((point + s * step)[None], 1)[0] for s in (1, -1))
        assert slopes[:, column] == pytest.approx((above - below) / (2 * step.sum()), rel=1e-4)


def test_a_motion_that_fails_is_a_row_without_outputs() -> None:
    """A mass of zero, which nothing resists."""
    machine = free_machine(OSCILLATOR, "m_b")
    outputs = SampledOutputs(machine, machine.moved_paths, [SOURCE])
    values = outputs.evaluated(np.array([[0.5], [0.0]]), 1)
    assert np.isnan(values).ravel().tolist() == [False, True]


def test_default_outputs_are_objective_and_limits(tmp_path: Path) -> None:
    text = (
        '[objective]\nleast = "rms x over 0..3 s"\n[requirements]\nhold = ["x at 0.5 s >= 2 mm"]\n'
    )
    source = own.generated(OSCILLATOR) / "own.toml"
    path = tmp_path / "own.toml"
    path.write_text(
        source.read_text("utf-8").replace("[values]", f'folder = "{source.parent}"\n[values]', 1)
        + text,
        encoding="utf-8",
    )
    from planter.engine.machine import load_machine

    assert list_default_outputs(load_machine(str(path))) == ["objective", "x at 0.5 s [mm]"]


@pytest.mark.parametrize(
    ("output", "reason"),
    [
        ("", '"max x over 0..1 s" or "x at 1 s"'),
        ("x_max_mm", '"max x over 0..1 s" or "x at 1 s"'),
        ("max x", "a span of times"),
        ("max y over 0..1 s", "one of x"),
        ("max x over 0..1 s [m]", "it is in mm"),
        ("work kinetic over 0..1 s", "of a cycle"),
    ],
)
def test_outputs_without_a_time_are_refused(tmp_path: Path, output: str, reason: str) -> None:
    plan = write_plan(tmp_path, [output] if output else [], k_N_m=[30.0])
    assert reason in refusal("sweep", str(plan))
