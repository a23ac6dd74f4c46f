"""Tolerances of planting devices: slopes are slopes, bands agree where they must, the robust design
is one.
"""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter import simulate
from planter.errors import InputError
from planter.papers.planting.model import Device
from planter.papers.planting.swept import ADAPTER
from planter.rows.adapter import ResolvedMachine
from planter.rows.points import Spread
from planter.rows.robust import RobustGoal, Settings
from planter.rows.tolerance_analysis import (
    Tolerances,
    default_tolerances,
)
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema

EXAMPLE = Path(__file__).parents[4] / "docs" / "examples" / "tolerances.toml"


@pytest.fixture(scope="module")
def resolved(kernel_cache: None) -> ResolvedMachine:
    return ResolvedMachine("wang2017", {"objective.samples": 60})


@pytest.fixture(scope="module")
def spreads(resolved: ResolvedMachine) -> dict[str, Spread]:
    return default_tolerances(resolved).spreads(resolved, "usual")


def test_default_tolerances_cover_workshop_and_speed(spreads: dict[str, Spread]) -> None:
    groups = (
        "mass.",
        "centroid.",
        "nozzle.C",
        "design.theta",
        "design.m",
        "deviation.a1",
        "deviation.a2",
        "contact.cam",
    )
    assert not [group for group in groups if not any(name.startswith(group) for name in spreads)]
    assert spreads["operation.speed_rpm"] == Spread("uniform", 35, 45)


@pytest.fixture(scope="module")
def robust(resolved: ResolvedMachine, spreads: dict[str, Spread]) -> RobustGoal:
    return ADAPTER.build_robust(resolved.machine, {}, spreads, Settings(machines=16))


def test_robust_machines_agree_with_simulation(
    robust: RobustGoal, resolved: ResolvedMachine, spreads: dict[str, Spread]
) -> None:
    """The objective's mean is that of machines written down one by one, centre distances as they
    should be.
    """
    few_spreads = {
        name: spread for name, spread in spreads.items() if not name.startswith("deviation.")
    }
    few = ADAPTER.build_robust(resolved.machine, {}, few_spreads, Settings(machines=4))
    size, machine, differences = len(few.design), few.outputs.machine, []
    for deviations in few.deviations:
        values = (
            deviations + np.concatenate([few.design, np.zeros(len(deviations) - size)])
        ) / machine.scale
        paths = [machine.values[index].path for index in machine.moved]
        changes = {path: float(value) for path, value in zip(paths, values, strict=True)}
        differences.append(
            simulate(Device(resolved.machine.with_numbers(changes))).result.objective
        )
    at = few.at(few.design)
    np.testing.assert_allclose(
        [at.mean, at.std], [np.mean(differences), np.std(differences)], rtol=1e-9
    )


INVALID_TOLERANCES = {
    "both ways": (
        {"mass.sun_kg": {"percent": 2, "plus_minus": 0.1}},
        "it must have either plus_minus, or percent, or",
    ),
    "no way": ({"mass.sun_kg": {}}, "it must have either plus_minus"),
    "upside down": ({"speed_rpm": {"from": 45, "to": 35}}, "it must have from less than to"),
    "an unknown law": (
        {"m31": {"percent": 1, "distribution": "cauchy"}},
        "'normal', 'uniform' or 'triangular'",
    ),
    "an unknown input": ({"planet_gk": {"percent": 1}}, "did you mean mass.planet_kg"),
    "a pattern that fits nothing": ({"masses.*": {"percent": 1}}, "tolerances.masses.*:"),
    "per cent of nothing": ({"deviation.a1_mm": {"percent": 1}}, "deviation.a1_mm is 0"),
    "negative": ({"m31": {"plus_minus": -1}}, "greater than 0"),
}


@pytest.mark.parametrize(
    ("table", "hint"), INVALID_TOLERANCES.values(), ids=INVALID_TOLERANCES.keys()
)
def test_invalid_tolerances_are_rejected(resolved: ResolvedMachine, table: dict, hint: str) -> None:
    with pytest.raises(InputError) as refused:
        Tolerances.read({"tolerances": table}, "mine.toml").spreads(resolved, "mine.toml")
    assert hint in refused.value.message
    assert refused.value.message.startswith("mine.toml: ")


def test_last_matching_tolerance_counts(resolved: ResolvedMachine) -> None:
    table = {"mass.*": {"percent": 1}, "mass.planet_kg": {"plus_minus": 0.3}}
    spreads = Tolerances.read({"tolerances": table}, "mine").spreads(resolved, "mine")
    assert len(spreads) == 6
    assert np.allclose([spreads["mass.planet_kg"].low, spreads["mass.planet_kg"].high], [0.9, 1.5])


@pytest.mark.long
def test_tolerance_command_runs_documented_example(
    resolved: ResolvedMachine, tmp_path: Path
) -> None:
    common = (
        "tolerance",
        "wang2017",
        "--samples",
        "500",
        "--indices",
        "16",
        "--set",
        "objective.samples=60",
    )
    result = answer(*common, "--tolerances", str(EXAMPLE), "--out", str(tmp_path))
    jsonschema.validate(result, load_schema("tolerance"))
    assert (result["rows"], result["index_rows"]) == (500, 16 * (len(result["inputs"]) + 2))
    assert {"support_N", "M_L_Nm"} <= {
        path.stem.removeprefix("turn-") for path in (tmp_path / "figures").glob("*.svg")
    }
    assert json.loads((tmp_path / "summary.json").read_text())["hash"] == result["hash"]
    again = answer(*common, "--tolerances", str(tmp_path / "tolerances.toml"), "--no-robust")
    for name, band in result["outputs"].items():
        assert np.isclose(again["outputs"][name]["std"], band["std"], rtol=1e-6)
    code, out, _ = run(*common, "--no-robust")
    assert code == 0
    assert max(map(len, map(str.rstrip, out.splitlines()))) <= 80


def test_invalid_tolerance_options_exit_with_a_line() -> None:
    assert "--indices = 100" in refusal("tolerance", "wang2017", "--indices", "100")
    assert "--choose model=correct:" in refusal(
        "tolerance", "wang2017", "--choose", "model=correct"
    )
    assert "--no-robust" in refusal("tolerance", "wang2017", "--least", "rms M_L", "--no-robust")
    assert "did you mean support_range_N" in refusal(
        "tolerance", "wang2017", "--output", "support_rnage_N"
    )
    assert "nowhere: no such machine" in refusal("tolerance", "nowhere")
    assert "yu2023: this machine has no default tolerances" in refusal("tolerance", "yu2023")
