"""`planter clutch geometry`, `design`, `optimise` and `rotor` from outside: keys, files, exit
codes, one sentence.
"""

import json
import math
import re
from pathlib import Path

import pytest

from planter.files import examples
from planter.papers.clutch import file
from tests.support.cli import below
from tests.support.tables import read_cycle_csv

run, answer, refusal = below("clutch")


def tampered(folder: Path, old: str, new: str) -> str:
    text = examples.example("shi2021")
    assert text.count(old) == 1
    path = folder / "my.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return str(path)


def test_geometry_follows_a_changed_value():
    result, other = (
        answer("geometry", "shi2021"),
        answer("geometry", "shi2021", "--set", "hexagon_side_mm=18"),
    )
    assert other["R_mm"] / result["R_mm"] == pytest.approx(18 / 17, rel=1e-14)
    assert (
        run("geometry", "shi2021", "--set", "hexagon_side_mm=60")[1].count(
            "- shi2021: levels.rods_mm["
        )
        == 2
    )


def test_geometry_files_are_consistent(tmp_path):
    assert run("geometry", "shi2021", "--out", str(tmp_path))[0] == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["input"]["sleeve"]["hexagon_side_mm"] == 17
    assert len(summary["provenance"]["machine_sha256"]) == 64
    _, columns = read_cycle_csv(tmp_path / "poses.csv")
    assert abs(columns["y_A_mm"] - summary["R_mm"] / 2).max() < 1e-12
    assert abs(columns["overlap_mm"]).max() / summary["R_mm"] == pytest.approx(
        summary["rotor"]["mismatch_over_R"], rel=1e-3
    )
    page = (tmp_path / "report.html").read_text()
    assert page.count("<figure>") == 4
    assert "no clearance" in page
    assert "assumed" in page
    assert {p.name for p in (tmp_path / "figures").iterdir()} >= {
        "turning.png",
        "vertex_path.svg",
        "linkage.svg",
        "travel.svg",
    }


def test_optimisation_is_reproducible_and_within_limits(tmp_path):
    for name in ("one", "two"):
        assert run("optimise", "shi2021", "--out", str(tmp_path / name))[0] == 0
    first, second = (
        {p.name: p.read_bytes() for p in (tmp_path / n).rglob("*") if p.is_file()}
        for n in ("one", "two")
    )
    assert first == second
    _, columns = read_cycle_csv(tmp_path / "one" / "way.csv")
    assert (
        "no friction in crank, rod and gears"
        in json.loads((tmp_path / "one" / "summary.json").read_text())["assumptions"]
    )
    limits = file.load_clutch("shi2021").limits
    assert columns["tooth_force_N"].max() <= limits.tooth_force_N * (1 + 2e-6)
    assert columns["rod_angle_deg"].max() <= limits.rod_angle_deg


@pytest.mark.usefixtures("blank_figures")
def test_infeasible_design_exits_1_and_writes_result(tmp_path):
    code, out, err = run("design", "shi2021", "--radius-mm", "12", "--json", "--out", str(tmp_path))
    assert code == 1
    assert json.loads(out)["error"]["name"] == "ComputationError"
    assert "no clutch fits: corners of the hexagonal hole within the space fails by" in err
    assert json.loads((tmp_path / "summary.json").read_text())["feasible"] is False


def test_design_options_replace_file_values():
    result = answer(
        "design",
        "shi2021",
        "--shaft-mm",
        "26",
        "--travel-mm",
        "4",
        "--radius-mm",
        "30",
        "--length-mm",
        "17",
    )
    assert result["sizes"]["tip_mm"] == pytest.approx(13 / math.sin(math.radians(72)), rel=1e-13)
    assert result["sizes"]["travel_mm"] == 4


@pytest.mark.usefixtures("blank_figures")
def test_rotors_in_general(tmp_path):
    result = answer("rotor", "--vertices", "3", "--sides", "4")
    assert result["exact"] is True
    assert result["smallest_over_R"] == pytest.approx(1, abs=1e-12)
    pentagon, geometry = answer("rotor"), answer("geometry", "shi2021")
    for key in ("centre_over_R", "semi_axes_over_R", "axis_deg", "tangency_radius_over_R"):
        assert pentagon["ellipse"][key] == pytest.approx(geometry["ellipse"][key], rel=1e-12)
    assert (
        answer("rotor", "--vertices", "5", "--sides", "3", "--out", str(tmp_path))["ellipse"]
        is None
    )
    assert "vertices_apart" in (tmp_path / "report.html").read_text()
    assert "vertices = 4: must be odd" in refusal("rotor", "--vertices", "4")


REFUSED = [
    ("fillet_mm = 4.8\n", "fillet_mm = 12\n", "shaft.fillet_mm = 12.0: it must be less than half"),
    ("[42.0, 44.8, 47.1]", "[42.0]", "levels.rods_mm = [42.0]: it must have a rod"),
    ("lift_limit_deg = 10 ", "lift_limit_deg = 5 ", "wanted.lift_limit_deg = 5.0: it must be gr"),
    ("[0.25, 0.55]", "[0.6, 0.5]", "search.ratio_bounds = [0.6, 0.5]: it"),
    ('\ntravel_mm = "paper', '\ntravel_mm = "guess', 'origin.travel_mm = "guess (4.2)": it must s'),
]


@pytest.mark.parametrize(("old", "new", "sentence"), REFUSED)
def test_invalid_clutch_files_exit_with_single_line(tmp_path, old, new, sentence):
    path = tampered(tmp_path, old, new)
    for command in ("geometry", "design", "optimise"):
        assert refusal(command, path).startswith(f"planter: {path}: {sentence}")


def test_every_number_has_an_origin_and_the_paper_s_are_marked():
    clutch = file.load_clutch("shi2021", {"tip_mm": 10.6})
    origins = {path: clutch.origin(path) for path in clutch.numbers()}
    assert clutch.number_origins() == origins
    assert all(
        re.match("paper|assumed|set on the command line", origin) for origin in origins.values()
    )
    assert origins["tooth.tip_mm"] == "set on the command line"
    assert origins["levels.rods_mm[1]"].startswith("paper")
    assert origins["linkage.crank_mm"] == origins["sleeve.hexagon_side_mm"] == "assumed"
