"""`planter pickup` against its contract: keys, nulls in the dwell, files, exit codes, one sentence
for bad input.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from planter.files import examples
from tests.support.cli import below

TOML = examples.example("yu2023", "pickup", ".toml")
CSV = examples.example("yu2023-path", "pickup", ".csv")


run, answer, refusal = below("pickup")


def by_path(folder: Path, points: str = CSV, **changes: str) -> str:
    """A file like the built-in one, but driven by points.csv beside it."""
    head, _, rest = TOML.partition("[law]")
    text = head + '[path]\ncsv = "points.csv"\n\n[spline]' + rest.partition("[spline]")[2]
    text = "\n".join(line for line in text.splitlines() if not line.startswith('law = "'))
    for old, new in changes.items():
        text = text.replace(old, new)
    (folder / "points.csv").write_text(points)
    (folder / "mine.toml").write_text(text)
    return str(folder / "mine.toml")


def test_keys_and_values_of_the_built_in_law() -> None:
    result = answer("yu2023", "--at", "0", "--at", "100", "--at", "240")
    assert result["slope"] == pytest.approx(
        {"min": 0, "max": 1.1606603790 * 1.3549389251, "mean": 1}, abs=1e-9
    )
    assert [result[key] for key in ("L1_mm", "L2_mm", "a2_mm")] == pytest.approx(
        [93.3377, 163, 44.6]
    )
    assert result["phi5_far_deg"] == pytest.approx(40)
    assert [result["dwell"]["start_deg"], result["dwell"]["end_deg"]] == pytest.approx([210, 270])
    assert result["round_trip_error_rad"] < 1e-9
    assert result["phi1_monotone"] is True
    at = result["at"]
    assert at[0]["tip_mm"] == pytest.approx([196.366071, 164.770697], abs=1e-6)
    assert at[0]["L3_mm"] == pytest.approx(256.3377)
    assert [at[2][key] for key in ("rho1_mm", "rho2_mm", "contact_ratio")] == [None] * 3
    assert at[2]["L3_mm"] == pytest.approx(result["dwell"]["tip_radius_mm"])
    assert at[2]["tip_speed_mm_s"] == pytest.approx(at[2]["L3_mm"] * 2 * np.pi)
    ratio = 1.1606603790 * (1 + 0.3549389251 * np.cos(np.radians(210)))
    radius = result["a1_mm"] * ratio / (1 + ratio)
    assert result["locking_arcs"]["end_radii_mm"][0] == pytest.approx(radius)


def test_path_sources_agree(tmp_path: Path) -> None:
    files = [answer(by_path(tmp_path)), answer(str(tmp_path / "points.csv")), answer("yu2023-path")]
    for other in files[1:]:
        assert {**other, "machine": files[0]["machine"]} == files[0]
    law = answer("yu2023")
    assert files[0]["L1_mm"] == pytest.approx(law["L1_mm"], abs=1e-3)
    assert files[0]["phi5_near_deg"] == pytest.approx(law["phi5_near_deg"], abs=0.01)
    assert files[0]["dwell"]["start_deg"] == pytest.approx(210, abs=0.05)


@pytest.mark.usefixtures("blank_figures")
def test_optimised_files_can_be_run_again(tmp_path: Path) -> None:
    result = answer("yu2023", "--optimise", "--out", str(tmp_path))
    assert result["optimised"]["holds"] is True
    assert all(requirement["holds"] for requirement in result["requirements"])
    assert "before the redesign" in (tmp_path / "report.html").read_text()
    again = answer(str(tmp_path / "path.csv"))
    missed = [
        requirement["name"]
        for requirement in again["requirements"]
        if requirement["margin"] < -1e-3
    ]
    assert missed == []
    assert again["dwell"]["start_deg"] == pytest.approx(result["dwell"]["start_deg"], abs=1e-4)
    coarse = answer(str(tmp_path / "value_points.csv"))
    assert coarse["push"]["swing_deg"] == pytest.approx(result["push"]["swing_deg"], abs=0.1)


@pytest.mark.usefixtures("blank_figures")
def test_the_pitch_file_leaves_out_the_dwell(tmp_path: Path) -> None:
    answer("yu2023", "--out", str(tmp_path))
    rows = [
        line
        for line in (tmp_path / "pitch.csv").read_text().splitlines()
        if not line.startswith("#")
    ]
    angles = [float(row["t_deg"]) for row in csv.DictReader(rows)]
    assert [angles[0], angles[-1]] == pytest.approx([-90, 210])


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("gamma_deg = 150", "gamma_deg = 80", ["carrier.gamma_deg = 80", "greater than 90"]),
        ("a2_mm = 44.6", "a2_mm = 40", ["carrier.a2_mm = 40", "at least mn"]),
        ("a2_mm = 44.6", "a2_mm = 120", ["a2_mm = 120", "less than L1"]),
        ("L2_mm = 163.0", "L2_mm = 90", ["bars.L2_mm = 90", "greater than L1_mm"]),
        ("[210, 270]", "[270, 210]", ["law.dwell_t_deg", "0 < start < end"]),
        ("p = 0.35", "p = 5.35", ["law", "must stay positive"]),
        (
            "p = 0.35",
            "transition_deg = 10\np = 0.35",
            ["law.transition_deg = 10", 'ends = "smooth"'],
        ),
        (
            "p = 0.35",
            'ends = "smooth"\ntransition_deg = 80\np = 0.35',
            ["law.transition_deg = 80", "at most 75"],
        ),
        ("p = 0.35", 'ends = "smooth"\np = 1.35', ["law.p = 1.35", "must rise from zero"]),
        ("p = 0.35", "p = -99.35", ["law.p", "gain over the turn"]),
        ("z2 = 21", "z2 = 22", ["helical_stage.z2 = 22", "z1 = 21"]),
        ("phi1_far_deg = 180", "phi1_far_deg = 90", ["law.phi1_far_deg", "180"]),
        ("[needle]", "[path]\ncsv = 'a.csv'\n[needle]", ["path", "not both"]),
    ],
)
def test_bad_files(old: str, new: str, parts: list[str], tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(TOML.replace(old, new))
    message = refusal(str(tmp_path / "bad.toml"))
    assert "bad.toml" in message
    assert all(part in message for part in parts), message


@pytest.mark.parametrize(
    ("points", "part"),
    [
        ("\n".join(CSV.splitlines()[:9]), "at least 12"),
        (CSV.replace("192.841830,161.826570", "196.366071,164.770697"), "point 1 is given twice"),
        ("\n".join(CSV.splitlines()[:18]), "points 15 and 1 are 218.1 mm apart"),
        ("\n".join([*CSV.splitlines()[:3], *CSV.splitlines()[:2:-1]]), "counter-clockwise"),
        ("", "the header"),
    ],
)
def test_bad_points(points: str, part: str, tmp_path: Path) -> None:
    message = refusal(by_path(tmp_path, points))
    assert "points.csv" in message
    assert part in message


def test_missing_files_and_angles(tmp_path: Path) -> None:
    assert "built-in TOML file for planter" in refusal("wang2017")
    config = by_path(tmp_path)
    (tmp_path / "points.csv").unlink()
    assert "points.csv: there is no such file" in refusal(config)
    assert "--at = nan" in refusal("yu2023", "--at", "nan")


@pytest.mark.parametrize(("decimals", "allowed"), [(3, 1e-3), (1, 0.7)])
def test_rounded_points_still_show_the_dwell(decimals: int, allowed: float, tmp_path: Path) -> None:
    """Distances are held to be equal as far as the decimals of the file go."""
    rounded = np.round(
        [[float(cell) for cell in line.split(",")] for line in CSV.splitlines()[3:]], decimals
    )
    lines = [f"{x:.{decimals}f},{y:.{decimals}f}" for x, y in rounded]
    (tmp_path / "points.csv").write_text("\n".join(["x_mm,y_mm", *lines]))
    result = answer(str(tmp_path / "points.csv"))
    exact = answer("yu2023-path")
    for key in ("start_deg", "end_deg"):
        assert result["dwell"][key] == pytest.approx(exact["dwell"][key], abs=allowed)


def test_tolerance_hiding_the_dwell_is_named(tmp_path: Path) -> None:
    message = refusal(by_path(tmp_path, **{"[path]\ncsv": "[path]\ntolerance_mm = 1e-9\ncsv"}))
    assert "tolerance_mm = 1e-09 is too small" in message


def test_reversing_arm_is_refused_with_angle(tmp_path: Path) -> None:
    message = refusal("yu2023", "--set", "p=1.2", "--out", str(tmp_path / "out"))
    assert "yu2023: law: this cannot be a pair of gears: at t = 180°" in message
    assert "slope -0.2" in message
    assert not (tmp_path / "out").exists()
