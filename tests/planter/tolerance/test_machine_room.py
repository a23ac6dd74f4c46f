"""Sweeps of machines of other rooms: read again from what is kept of them, rows of the machine alone, slopes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.engine.response import Response
from planter.errors import InputError
from planter.files import examples
from planter.kernels import backends
from planter.sweeps.room import Held

CASES = {
    "shi2021": (("linkage.crank_mm", "linkage.rod_mm"), "M_link_max_Nm"),
    "yu2023": (("bars.L2_mm", "carrier.gamma_deg"), "x_S_range_mm"),
}


@pytest.fixture(autouse=True)
def plain_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "fastest", backends.virtual_machine)


@pytest.mark.parametrize("name", CASES)
def test_rows_are_those_of_the_machine_alone(name: str) -> None:
    inputs, output = CASES[name]
    held, machine = Held(name), load_machine(name)
    frozen = json.loads(json.dumps(held.room.frozen(held.machine)))
    nominal = held.room.nominal(held.machine)
    x = np.array([nominal[path] for path in inputs])
    subject = held.room.subject(frozen, {}, {path: (nominal[path],) * 2 for path in inputs}, [output])
    (value,), slopes = subject.slopes(x)
    (term,) = subject.outputs[0].terms
    quantity = machine.find_quantity(term.name)
    response = Response(machine, [quantity.name])
    samples = response.values(response.at(machine.design), subject.rows.angles)[0] / quantity.factor
    expected = samples.max() if term.kind == "max" else np.ptp(samples)
    assert value == pytest.approx(expected, rel=1e-12)
    steps = np.diag(1e-6 * x)
    difference = (subject.evaluated(x + steps, 1) - subject.evaluated(x - steps, 1))[:, 0] / (2e-6 * x)
    np.testing.assert_allclose(slopes[0], difference, atol=1e-6 * np.abs(slopes).max())
    assert np.abs(slopes).max() > 0


def test_a_file_that_changes_meanwhile_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(examples.text("shi2021", "clutch"), encoding="utf-8")
    held = Held(str(path), {"crank_mm": 31.0})
    frozen = held.room.frozen(held.machine)
    assert held.room.thaw(frozen).numbers()["linkage.crank_mm"] == 31.0
    path.write_text(path.read_text().replace("rod_mm = ", "rod_mm = 1"), encoding="utf-8")
    with pytest.raises(InputError):
        held.room.thaw(frozen)
