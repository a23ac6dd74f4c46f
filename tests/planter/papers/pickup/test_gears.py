"""Paths of one's own as gears: what cannot be gears is refused with angle and place; what can be is
cut by planter gears."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from numpy.typing import NDArray

from planter.errors import GeometryError
from planter.papers.pickup import gears, model
from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.model import build_train
from tests.planter.papers.pickup.pickups import L2, built_in, steps
from tests.support import cli
from tests.support.cli import below
from tests.support.schemas import load_schema

run, answer, refusal = below("pickup")

T = steps(36)
BEAN = 140 + 0.6 * (120 + 50 * np.cos(T) - 20 * np.cos(2 * T)) * np.cos(T)
BEAN_Y = 90 + 0.5 * (120 + 50 * np.cos(T) - 20 * np.cos(2 * T)) * np.sin(T)
ELLIPSE = (150 + 60 * np.cos(T), 80 + 40 * np.sin(T))
EIGHT = (150 + 60 * np.sin(T), 80 + 40 * np.sin(2 * T))


def points(folder: Path, x: NDArray, y: NDArray, name: str = "mine.csv") -> str:
    lines = [f"{a:.6f},{b:.6f}" for a, b in zip(x, y, strict=True)]
    (folder / name).write_text("\n".join(["x_mm,y_mm", *lines]) + "\n")
    return str(folder / name)


def test_bean_shape_is_refused(tmp_path: Path) -> None:
    path = points(tmp_path, BEAN, BEAN_Y)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        message = refusal(path, "--out", str(tmp_path / "out"))
    assert "mine.csv: this cannot be a pair of gears: at t = 136.5°" in message
    assert "the arm turns back (slope -0.57" in message
    assert "(107.76, 79.626) mm, by point 21" in message
    assert "the arm must turn 4.99 times as fast" in message
    assert not (tmp_path / "out").exists()


def test_small_sun_is_refused_with_radius_and_ratio(tmp_path: Path) -> None:
    message = refusal(points(tmp_path, *EIGHT))
    assert "the pitch radius of the sun is 2.288 mm (total ratio 7.59" in message
    assert "by point 21" in message


@pytest.mark.long
def test_an_ellipse_either_way_round_gives_gears_and_no_noise(tmp_path: Path) -> None:
    for turn in (1, -1):
        path = points(tmp_path, *(part[::turn] for part in ELLIPSE))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = answer(path, "--out", str(tmp_path / "out"))
        assert result["machine"] == "mine"
        assert result["sun_radius_mm"]["min"] > 2.4
        straight = next(
            requirement
            for requirement in result["requirements"]
            if requirement["name"] == "straight entry"
        )
        assert 10 < straight["value"] < 25
        assert (tmp_path / "out" / "pitch.csv").exists()


def test_lengths_in_other_units_are_suspected(tmp_path: Path) -> None:
    x, y = ELLIPSE
    message = refusal(points(tmp_path, x / 1000, y / 1000))
    assert "less than L1 = 0.056" in message
    assert "are they in mm" in message


def test_a_path_round_the_origin_is_no_traceback(tmp_path: Path) -> None:
    r = 100 + 40 * np.cos(T)
    assert "goes round the origin" in refusal(points(tmp_path, r * np.cos(T) + 30, r * np.sin(T)))


def test_velocity_jumps_at_dwell_are_reported_with_size() -> None:
    train = built_in()
    warnings = {
        warning["name"]: warning
        for warning in answer("yu2023")["warnings"]
        if "velocity" in warning["name"]
    }
    assert {name: warning["t_deg"] for name, warning in warnings.items()} == pytest.approx(
        {"velocity jumps at the dwell's start": 210, "velocity jumps at the dwell's end": 270}
    )
    for warning, t in zip(warnings.values(), (train.driven[1], train.driven[0]), strict=True):
        jump = 1000 * L2 * train.omega * train.law.slopes(np.array([t]))[0, 0]
        assert f"jumps by {jump:.5g} mm/s" in warning["message"]
        eps = 1e-7
        moments = train.motion(np.array([t - eps, t + eps]))
        measured = np.hypot(np.diff(moments["vx_S"]), np.diff(moments["vy_S"]))[0] * 1000
        assert measured == pytest.approx(jump, rel=1e-5)
    assert 'ends = "smooth"' in warnings["velocity jumps at the dwell's start"]["message"]


TEETH = np.array([0.002, 1.2, 1.3, np.radians(20)])


def test_each_limit_is_violated_alone() -> None:
    good = {"R1": 0.02, "R2": 0.03, "kappa1": 50.0, "kappa2": 30.0}
    cases = {
        ("sun", "radius"): {"R1": 0.0026},
        ("intermediate gear", "radius"): {"R2": 0.0024},
        ("sun", "sharp"): {"kappa1": 1 / 0.0026},
        ("intermediate gear", "sharp"): {"kappa2": 1 / 0.0024},
        ("sun", "hollow"): {"kappa1": -1 / 0.0024},
        ("intermediate gear", "hollow"): {"kappa2": -1 / 0.0026},
    }
    for kind, change in cases.items():
        violations = model.limit_excesses(
            {k: np.array([v]) for k, v in {**good, **change}.items()}, TEETH
        )
        assert [name for name, excess in violations.items() if excess[0] >= -1e-9] == [kind]
    assert not model.violates_limits({k: np.array([v]) for k, v in good.items()}, TEETH)


def test_gear_check_refuses_too_large_teeth() -> None:
    machine = load_pickup("yu2023")
    gears.check_gears(machine, build_train(machine))
    huge = load_pickup("yu2023", {"noncircular_stage.m_mm": 25})
    with pytest.raises(
        GeometryError, match=r"the pitch radius of the sun is 22.27 mm .* reach 30 mm into it"
    ):
        gears.check_gears(huge, build_train(huge))


@pytest.mark.usefixtures("blank_figures")
def test_missing_contact_ratio_is_reported(tmp_path: Path) -> None:
    """Points rounded to whole mm make pitch curves hollow here and there."""
    rounded = np.round(
        [[float(c) for c in line.split(",")] for line in _path_csv().splitlines()[3:]]
    )
    (tmp_path / "coarse.csv").write_text(
        "x_mm,y_mm\n" + "".join(f"{x:.0f},{y:.0f}\n" for x, y in rounded)
    )
    result = answer(str(tmp_path / "coarse.csv"), "--out", str(tmp_path / "out"))
    messages = [
        warning["message"] for warning in result["warnings"] if warning["name"] == "contact ratio"
    ]
    header = next(
        line for line in (tmp_path / "out" / "pitch.csv").read_text().splitlines() if line[0] != "#"
    )
    assert len(messages) == 1
    assert "contact_ratio" not in header


def _path_csv() -> str:
    from planter.files import examples

    return examples.example("yu2023-path", "pickup", ".csv")


@pytest.mark.usefixtures("blank_figures")
def test_teeth_end_where_a_gentle_path_leaves_them_no_room(tmp_path: Path) -> None:
    from tests.planter.papers.pickup.test_laws import smooth_file

    answer(smooth_file(tmp_path, 20), "--out", str(tmp_path / "smooth"))
    result = answer(str(tmp_path / "smooth" / "path.csv"))
    names = {warning["name"]: warning["t_deg"] for warning in result["warnings"]}
    assert names["no teeth at the dwell's start"] == pytest.approx(210, abs=0.1)
    assert names["no teeth at the dwell's end"] == pytest.approx(270, abs=0.1)
    assert result["round_trip_error_rad"] < 1e-5


@pytest.mark.usefixtures("blank_figures")
def test_the_built_in_pick_up(tmp_path: Path) -> None:
    result = cli.answer("gears", "yu2023", "--backlash-mm", "0.05", "--stl", "--out", str(tmp_path))
    jsonschema.validate(result, load_schema("gears"))
    pair = result["intermittent"]
    assert result["stages"] == []
    assert (result["addendum"], result["pressure_angle_deg"], pair["module_mm"]) == (1.2, 20, 2)
    assert np.pi * pair["module_mm"] * pair["pitches"] == pytest.approx(
        pair["toothed_arc_mm"], rel=1e-14
    )
    design = cli.answer("pickup", "yu2023")
    assert pair["toothed_arc_mm"] == pytest.approx(design["sun_toothed_arc_mm"], rel=1e-12)
    assert pair["locking_radius_mm"] == pytest.approx(design["locking_arcs"]["radius_mm"], rel=1e-8)
    assert pair["overlap_mm2"] == pair["dwell_overlap_mm2"] == 0
    assert pair["positions"] >= 720
    for undriven, smallest in zip(pair["undriven_deg"], pair["undriven_least_deg"], strict=True):
        assert smallest - 1 < undriven < 12
    assert pair["loose"]["after_dwell"]["behind_deg"] < 2
    assert pair["loose"]["before_dwell"]["behind_deg"] < 3
    assert {gear["joins_mm"] < 1e-9 for gear in pair["gears"]} == {True}
    names = {Path(name).name for name in result["files"]}
    assert {"sun.dxf", "intermediate_gear.stl", "sun_flanks.csv", "assembly.dxf"} <= names
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["intermittent"] == pair
    assert pair["transmission_error_rad"] < 1e-11
    page = (tmp_path / "report.html").read_text()
    assert "ahead of it / °" in page
    assert "planter-view" in page
    assert {path.stem for path in (tmp_path / "figures").glob("*.png")} == {
        "assembly",
        "dwell",
        "loose",
        "lands",
    }


def test_tooth_count_determines_module_and_spacing() -> None:
    result = cli.answer(
        "gears", "yu2023", "--teeth", "24", "--addendum", "1", "--centre-error-mm", "0.1"
    )["intermittent"]
    assert result["pitches"] == pytest.approx(24, rel=1e-14)
    assert max(result["slack_deg"]) < 0.05
    assert max(result["loose"]["driven"].values()) < 0.01
    assert 0.1 < max(result["farther_loose"]["driven"].values()) < 0.3


REFUSED = {
    "two pairs": (("--module1", "2"), "one non-circular pair"),
    "speed": (("--speed-rpm", "30"), "depend on its speed"),
    "scaled": (("--keep", "module", "--teeth", "23"), "follows from the bars"),
    "disagree": (("--teeth", "30", "--module", "2"), "which makes 23 teeth"),
    "few teeth": (("--teeth", "5"), "there must be 6 to 1000"),
    "small module": (("--module", "0.2"), "a horn of the locking arcs takes"),
    "undercut": (("--teeth", "10"), "undercut"),
    "play": (("--backlash-mm", "1"), "at most 0.2 modules"),
    "bore": (("--bore-mm", "60"), "60"),
}


@pytest.mark.parametrize(("options", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_impossible_gears_are_refused_in_a_sentence(options: tuple[str, ...], message: str) -> None:
    assert message in cli.refusal("gears", "yu2023", *options)


def test_smoothly_resting_law_is_refused(tmp_path: Path) -> None:
    from planter.files import examples

    text = examples.example("yu2023", "pickup").replace("# ends = ", "ends = ").replace("# "
                                                                                        "transition_deg", "transition_deg")  # fmt: skip # noqa: E501
    file = tmp_path / "own.toml"
    file.write_text(text)
    assert "other means than teeth" in cli.refusal("gears", str(file))
