"""Sweeps of machines of other rooms: read again from what is kept of them, rows of the machine
alone, slopes.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.engine.response import MachineResponse
from planter.engine.summary import summarise_machine
from planter.errors import InputError
from planter.files import examples
from planter.kernels import backends
from planter.rows.sweeps.adapter import ResolvedMachine
from planter.rows.tolerance.job import Spread
from planter.rows.tolerance.results import RobustFound
from planter.rows.tolerance.robust import Settings, find_robust

CASES = {
    "shi2021": (("linkage.crank_mm", "linkage.rod_mm"), "M_link_max_Nm"),
    "yu2023": (("bars.L2_mm", "carrier.gamma_deg"), "x_S_range_mm"),
}


@pytest.fixture(autouse=True)
def plain_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "select_fastest", backends.VirtualMachine)


@pytest.mark.parametrize("name", CASES)
def test_rows_equal_single_machine_outputs(name: str) -> None:
    inputs, output = CASES[name]
    resolved, machine = ResolvedMachine(name), load_machine(name)
    frozen = json.loads(json.dumps(resolved.adapter.frozen(resolved.machine)))
    nominal = resolved.adapter.nominal(resolved.machine)
    x = np.array([nominal[path] for path in inputs])
    subject = resolved.adapter.subject(
        frozen, {}, {path: (nominal[path],) * 2 for path in inputs}, [output]
    )
    (value,), slopes = subject.slopes(x)
    (term,) = subject.outputs[0].terms
    quantity = machine.find_quantity(term.name)
    peak = next(peak for peak in summarise_machine(machine).peaks if peak.name == quantity.name)
    assert value == pytest.approx(peak.max if term.kind == "max" else peak.max - peak.min, rel=1e-9)
    steps = np.diag(1e-6 * x)
    difference = (subject.evaluated(x + steps, 1) - subject.evaluated(x - steps, 1))[:, 0] / (
        2e-6 * x
    )
    np.testing.assert_allclose(slopes[0], difference, atol=1e-6 * np.abs(slopes).max())
    assert np.abs(slopes).max() > 0


def test_file_changed_during_run_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(examples.read_source("shi2021", "clutch"), encoding="utf-8")
    resolved = ResolvedMachine(str(path), {"crank_mm": 31.0})
    frozen = resolved.adapter.frozen(resolved.machine)
    assert resolved.adapter.thaw(frozen).numbers()["linkage.crank_mm"] == 31.0
    path.write_text(path.read_text().replace("rod_mm = ", "rod_mm = 1"), encoding="utf-8")
    with pytest.raises(InputError):
        resolved.adapter.thaw(frozen)


def find(resolved: ResolvedMachine, settings: Settings, spreads: dict[str, Spread]) -> RobustFound:
    robust = resolved.adapter.build_robust(resolved.machine, {}, spreads, settings)
    return find_robust(robust, settings, None)


VARIED = {"bars.L1_mm": (90.0, 97.0)}


def test_stated_sum_limit_and_ranges_make_a_robust_design() -> None:
    """Alone, the range is least at an end of the bar's length; as a limit it binds where the needle
    shall reach far.
    """
    resolved, machine = ResolvedMachine("yu2023"), load_machine("yu2023")
    spreads = {"bars.L1_mm": Spread("normal", 93.2, 93.5)}

    def find_range(length: float) -> float:
        moved = machine.with_moved(VARIED)
        response = MachineResponse(moved, ["x_S"])
        at = response.at(np.array([length * 1e-3]))
        return float(
            np.ptp(
                1e3
                * response.values(at, machine.turn * np.arange(machine.samples) / machine.samples)
            )
        )

    stated = Settings(1.0, 8, 1, sum_text="range x_S", ranges=VARIED)
    free = find(resolved, stated, spreads)
    ends = [find_range(length) for length in VARIED["bars.L1_mm"]]
    best = 90.0 if ends[0] < ends[1] else 97.0
    assert free.design == pytest.approx({"L1_mm": best})
    assert free.objective <= free.own_objective
    limit = (min(ends) + max(ends)) / 2
    upward = replace(stated, sum_text="-mean x_S", holds=(f"range x_S <= {limit!r}",))
    bound = find(resolved, upward, spreads)
    assert find_range(bound.design["L1_mm"]) <= limit * (1 + 1e-7)


@pytest.mark.parametrize(
    ("stated", "part"),
    [
        (Settings(sum_text="range x_S"), "no values to search in: give --vary"),
        (Settings(ranges=VARIED), "no sum to minimise: give --least"),
        (
            Settings(sum_text="range x_S", ranges={"bars.L1_mm": (97.0, 90.0)}),
            "LOW must be below HIGH",
        ),
        (Settings(sum_text="range x_Q", ranges=VARIED), "no quantity x_Q"),
    ],
)
def test_incomplete_robust_request_is_rejected(stated: Settings, part: str) -> None:
    resolved = ResolvedMachine("yu2023")
    with pytest.raises(InputError, match=part):
        resolved.adapter.build_robust(resolved.machine, {}, {}, stated)
    assert resolved.adapter.build_robust(resolved.machine, {}, {}, Settings()) is None
