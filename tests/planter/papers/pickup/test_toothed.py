"""`planter gears` with a pick-up: keys, files, whole teeth, one sentence for what cannot be."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema


def test_the_built_in_pick_up(tmp_path: Path) -> None:
    result = answer("gears", "yu2023", "--backlash-mm", "0.05", "--stl", "--out", str(tmp_path))
    jsonschema.validate(result, load_schema("gears"))
    pair = result["intermittent"]
    assert result["stages"] == []
    assert (result["addendum"], result["pressure_angle_deg"], pair["module_mm"]) == (1.2, 20, 2)
    assert np.pi * pair["module_mm"] * pair["pitches"] == pytest.approx(
        pair["toothed_arc_mm"], rel=1e-14
    )
    design = answer("pickup", "yu2023")
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
    result = answer(
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
    assert message in refusal("gears", "yu2023", *options)


def test_smoothly_resting_law_is_refused(tmp_path: Path) -> None:
    from planter.files import examples

    text = examples.example("yu2023", "pickup").replace("# ends = ", "ends = ").replace("# "
                                                                                        "transition_deg", "transition_deg")  # fmt: skip # noqa: E501
    file = tmp_path / "own.toml"
    file.write_text(text)
    assert "other means than teeth" in refusal("gears", str(file))
