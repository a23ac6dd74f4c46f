"""`planter diff`: laws of the differences, results held against other commands, kinds,
requirements, the page.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from planter.cli.comparison_page import draw_comparison
from planter.cli.machine_comparison import ComparedDesign, ComparisonOptions, compare_machines
from planter.cli.results import ComparedCurve
from planter.engine.machine import load_machine
from planter.engine.measures import parse_limit
from planter.files import examples
from planter.mechanism import optimisation
from planter.papers.planting.file import load
from tests.support import own
from tests.support.cli import answer, refusal, run

HEAVIER_KG = 0.1
HOLDS = ("abs F_Ax <= 60 N", "max M_in >= 3 N m", "jump F_Ox <= 2 N")


@pytest.fixture(scope="module")
def heavier(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The built-in device with a heavier planet on either side."""
    path = tmp_path_factory.mktemp("diff") / "heavier.toml"
    text = examples.example("wang2017")
    assert "planet_kg = 1.2" in text
    path.write_text(
        text.replace("planet_kg = 1.2", f"planet_kg = {1.2 + HEAVIER_KG}"), encoding="utf-8"
    )
    return str(path)


@pytest.fixture(scope="module")
def cranks() -> tuple[str, str]:
    """Two slider cranks: the second has a stiffer spring, an objective and limits of its own."""
    path = own.generated("slider_crank") / "slider_crank.toml"
    stiffer = path.with_name("stiffer.toml")
    text = path.read_text(encoding="utf-8").replace("k_N_m = 900", "k_N_m = 1200")
    goal = '[objective]\nleast = "range F_Ox"\n\n[requirements]\nhold = ["abs F_Ax <= 300 N"]\n'
    stiffer.write_text(f"{text}\n{goal}", encoding="utf-8")
    return str(path), str(stiffer)


@pytest.fixture(scope="module")
def compared(heavier: str) -> Any:
    """The comparison of the built-in device with the heavier one, and with itself."""
    return answer("diff", "wang2017", heavier, "wang2017", "--quantity", "F_Ox")


def rows(result: Any, part: str = "results") -> dict[str, Any]:
    return {row["name"]: row for row in result[part]}


def test_equal_designs_have_zero_differences() -> None:
    result = answer("diff", "wang2017", "wang2017")
    assert result["values"] == []
    assert all(row["difference"] == [0.0] and row["better"] is None for row in result["results"])
    assert {machine["kind"] for machine in result["machines"]} == {"planting"}


def test_mean_force_changes_by_the_weight(compared: Any) -> None:
    assert [row["name"] for row in compared["values"]] == ["mass.planet_kg"]
    assert compared["values"][0]["values"] == [1.2, 1.2 + HEAVIER_KG, 1.2]
    mean = rows(compared)["mean F_support"]
    assert mean["difference"][1] == 0.0
    assert mean["difference"][0] == pytest.approx(
        2 * HEAVIER_KG * load("wang2017").si("gravity_m_s2"), rel=1e-9
    )
    assert mean["better"] is None


def test_objective_equals_the_refined_one_of_simulate(compared: Any, heavier: str) -> None:
    simulated, objective = answer("simulate", heavier)["refined"], rows(compared)["objective"]
    assert objective["values"][1] == pytest.approx(simulated["objective"], rel=1e-8)
    assert rows(compared)["range F_support"]["values"][1] == pytest.approx(
        simulated["range_N"], rel=1e-9
    )
    assert objective["better"] == (1 if objective["difference"][0] < 0 else None)


def test_exchanged_machines_change_signs(compared: Any, heavier: str) -> None:
    back = rows(answer("diff", heavier, "wang2017"))
    for name, row in rows(compared).items():
        assert row["difference"][0] == pytest.approx(-back[name]["difference"][0], abs=1e-12)
    assert back["objective"]["better"] == int(back["objective"]["difference"][0] < 0)


def test_curves_are_those_of_the_machines(compared: Any, heavier: str) -> None:
    curves = rows(compared, "curves")
    assert {"F_Ox", "F_support", "M_L"} <= curves.keys()
    force = curves["F_support"]
    assert len(force["values"]) == 3
    assert force["values"][0] == force["values"][2] != force["values"][1]
    at = answer("simulate", heavier, "--at", str(force["phi_deg"][100]))["at"][0]
    assert force["values"][1][100] == pytest.approx(at["support_N"], rel=1e-12)


def test_limits_of_all_machines_apply_to_each(cranks: tuple[str, str]) -> None:
    options = ComparisonOptions({}, holds=HOLDS)
    result = compare_machines(cranks, options).result
    assert [row.limit for row in result.requirements] == [300.0, 60.0, 3.0, 2.0]
    for row, text in zip(result.requirements[1:], HOLDS, strict=True):
        for source, value, met in zip(cranks, row.values, row.met, strict=True):
            machine = replace(load_machine(source), limits=(parse_limit(text),))
            result_alone = optimisation.evaluate_limits(machine)[0]
            assert (result_alone.value, result_alone.met) == (value, met)
    margins = [row for row in result.results if row.name.startswith("margin of ")]
    assert [row.name.removeprefix("margin of ") for row in margins] == [
        row.limit_on for row in result.requirements
    ]
    force, torque = margins[1:3]
    assert force.better == max((0, 1), key=lambda k: 60 - (result.requirements[1].values[k] or 0))
    assert torque.values[0] == pytest.approx((result.requirements[2].values[0] or 0) - 3.0)
    assert any(row.met != [True, True] for row in result.requirements)


def test_objective_is_that_of_the_first_machine_with_one(cranks: tuple[str, str]) -> None:
    result = compare_machines(cranks, ComparisonOptions({})).result
    objective = next(row for row in result.results if row.name == "objective")
    term = next(row for row in result.results if row.name == "range F_Ox")
    assert objective.values == term.values
    design = ComparedDesign(cranks[0], ComparisonOptions({}))
    peak = design.peaks["F_Ox"]
    assert objective.values[0] == pytest.approx(peak.max - peak.min)


def test_speed_applies_to_all_machines(cranks: tuple[str, str]) -> None:
    result = compare_machines(cranks, ComparisonOptions({}, speed_rpm=120.0)).result
    assert "values.omega_rpm" not in {row.name for row in result.values}
    slow = next(row for row in result.results if row.name == "max P_M_in")
    fast = next(
        row
        for row in compare_machines(cranks, ComparisonOptions({})).result.results
        if row.name == slow.name
    )
    assert (slow.values[0] or 0) < (fast.values[0] or 0)


def test_requirements_of_a_pickup_are_compared(tmp_path: Path) -> None:
    other = tmp_path / "pickup.toml"
    other.write_text(
        examples.example("yu2023").replace("push_deg = 90", "push_deg = 80"), encoding="utf-8"
    )
    result = answer("diff", "yu2023", str(other))
    judged = [row for row in result["requirements"] if row["limit_on"].startswith("push angle >=")]
    assert [row["limit"] for row in judged] == [78.0, 88.0]
    assert [row["met"] for row in judged] == [[True, True], [False, False]]


@pytest.mark.parametrize("sources", [("wang2017", "yu2023"), ("sun2019", "shi2021")])
def test_other_kinds_are_refused(sources: tuple[str, str]) -> None:
    assert "kind" in refusal("diff", *sources)


def test_invalid_calls_are_refused(cranks: tuple[str, str]) -> None:
    assert "MACHINE" in refusal("diff", "wang2017")
    assert "nowhere.toml" in refusal("diff", "wang2017", "nowhere.toml")
    assert "F_Oq" in refusal("diff", *cranks, "--quantity", "F_Oq")
    assert "no quantity zz" in refusal("diff", *cranks, "--hold", "zz <= 3")
    assert "--model" in refusal("diff", *cranks, "--model", "printed")


def test_page_and_files_have_the_comparison(heavier: str, tmp_path: Path) -> None:
    code, out, _ = run("diff", "wang2017", heavier, "--out", str(tmp_path))
    assert code == 0
    assert "mass.planet_kg" in out
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["provenance"]["A sha256"] != summary["provenance"]["B sha256"]
    assert (tmp_path / "figures" / "F_support.svg").is_file()
    lines = (tmp_path / "curves.csv").read_text(encoding="utf-8").splitlines()
    assert sum(not line.startswith("#") for line in lines) == 361
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.index('class="conclusion"') < page.index("mass.planet_kg")


@pytest.mark.parametrize(("difference", "panes"), [(1e-14, 1), (1e-3, 2)])
def test_differences_below_rounding_are_not_drawn(difference: float, panes: int) -> None:
    angles = [float(angle) for angle in range(360)]
    values = [[100.0] * 360, [100.0 + difference * (angle % 2) for angle in angles]]
    figure = draw_comparison(ComparedCurve("F", "N", angles, values), "AB", "force")
    assert len(figure.axes) == panes
    assert figure.axes[0].get_ylabel() == "force / N"
