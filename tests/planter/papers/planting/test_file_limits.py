"""Limits on measures in files of machines: values, verdicts, prices, curves of other folders,
refusals.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import planter
from planter.engine.machine import load_machine
from planter.files import examples
from planter.papers.planting.model import Device
from planter.report.subject import open_machine
from tests.support.cli import answer, refusal, run

TORQUE = "max M_L <= 2.85 N m"


def write_machine(path: Path, name: str, *limits: str) -> str:
    """Write a built-in machine with limits in [requirements], and return its path."""
    text = examples.example(name)
    head, table, rest = text.partition("[requirements]")
    first, _, rest = rest.partition("\n")
    path.write_text(
        f"{head}{table or '[requirements]'}{first}\nhold = {list(limits)}\n{rest}", encoding="utf-8"
    )
    return str(path)


def test_simulate_and_validate_judge_the_limits(tmp_path: Path) -> None:
    source = write_machine(tmp_path / "m.toml", "wang2017", TORQUE, "bearing_O1 >= 10 N")
    simulated = answer("simulate", source)
    torque, bearing = simulated["holds"]
    assert torque["value"] == pytest.approx(simulated["designer"]["motor"]["max_Nm"], rel=1e-9)
    forces = {force["name"]: force for force in simulated["designer"]["peaks"]}
    assert bearing["value"] == pytest.approx(forces["bearing_O1"]["min"], rel=1e-6)
    assert ([row["met"] for row in simulated["holds"]], simulated["met"]) == ([False, True], False)
    assert answer("validate", source)["holds"] == simulated["holds"]


def test_limits_stand_beside_requirements(tmp_path: Path) -> None:
    source = write_machine(tmp_path / "m.toml", "wang2017-wide", TORQUE)
    validated = answer("validate", source)
    assert len(validated["holds"]) == 1
    assert {row["name"] for row in validated["requirements"]} >= {"depth", "spacing"}
    view = open_machine(source)
    checks = view.checks({control.path: control.value for control in view.controls}, "exact")
    assert checks[0].name == "max M_L"
    assert len(checks) == 1 + len(validated["requirements"])


def test_infeasible_limit_names_both_numbers(tmp_path: Path) -> None:
    source = write_machine(tmp_path / "m.toml", "wang2017", "max M_L <= 1.6 N m")
    code, out, err = run("optimise", source, "--samples", "24", "--starts", "1")
    assert (code, out) == (1, "")
    assert "max M_L <= 1.6 N m" in err
    reached = re.search(r"\((\S+) for 1.6 N m\)", " ".join(err.split()))
    assert reached is not None
    assert float(reached[1]) > 1.6


def test_written_file_names_curves_in_full(tmp_path: Path) -> None:
    (tmp_path / "soil.csv").write_text("x_mm,y_mm\n-500,-400\n500,-380\n", encoding="utf-8")
    limit = "clearance x_tip y_tip over soil.csv >= 10 mm"
    source = write_machine(tmp_path / "m.toml", "wang2017", limit)
    table = load_machine(source).document.written_table()
    assert str(tmp_path.resolve() / "soil.csv") in table["requirements"]["hold"][0]
    result = answer("simulate", source)["holds"][0]
    phi = np.linspace(0, 360, 720, endpoint=False)
    tip = load_machine(source)
    assert result["value"] == pytest.approx(_least_height(tip, np.radians(phi)), abs=0.05)


def _least_height(machine: planter.Machine, phi: np.ndarray) -> float:
    device = Device(planter.load_machine(machine.source))
    side = device.side(device.design, phi)
    return float(
        (1e3 * side["y_tip"] - np.interp(1e3 * side["x_tip"], (-500, 500), (-400, -380))).min()
    )


def test_device_searches_refuse_limits_that_they_lack(tmp_path: Path) -> None:
    source = write_machine(tmp_path / "m.toml", "wang2017-wide", TORQUE)
    assert "requirements.hold" in refusal("compare", source)
    with pytest.raises(planter.InputError, match=r"requirements\.hold"):
        planter.optimise_device(Device(planter.load_machine(source)))
