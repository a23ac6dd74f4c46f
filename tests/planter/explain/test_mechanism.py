"""`planter explain FILE` of a mechanism: everything that its statement says, and nothing that it
does not.
"""

from __future__ import annotations

import csv
import tomllib
from pathlib import Path

import pytest

from planter.explain.mechanism import explain_mechanism
from planter.explain.presentation import present_mechanism
from planter.files import units
from planter.mechanism import sheets
from planter.report.html import Table
from planter.view.sheet import Length
from tests.support import own
from tests.support.cli import answer, refusal


@pytest.fixture(scope="module")
def path() -> str:
    return str(own.generated("cam_follower") / "cam_follower.toml")


def test_explanations_equal_sidecar(path: str, tmp_path: Path) -> None:
    result = answer("explain", path, "--set", "h_mm=15", "--out", str(tmp_path))
    sidecar = own.file("cam_follower").model.sidecar
    assert [value["name"] for value in result["values"]] == [
        entry["name"] for entry in sidecar["vectors"]["data"]
    ]
    single = [value["name"] for value in result["quantities"] if "components" not in value]
    assert single == [entry["name"] for entry in sidecar["vectors"]["outputs"]]
    vectors = {value["name"]: value["components"] for value in result["quantities"][len(single) :]}
    assert vectors["F_O"] == ["F_Ox", "F_Oy"]
    assert [value["name"] for value in result["functions"]] == list(sidecar["functions"])
    lift = next(value for value in result["values"] if value["name"] == "h")
    assert lift["value"] == 15.0
    assert lift["allowed"] == "from 8 to 20 mm"
    push = next(value for value in result["quantities"] if value["name"] == "N_cam")
    assert "only push" in push["meaning"]
    assert {value["kind"] for value in result["quantities"]} == {"quantity", "check"}
    assert all((tmp_path / file).is_file() for file in result["files"])


@pytest.mark.parametrize(
    ("key", "kind"), [("h_mm", "value"), ("values.h_mm", "value"), ("N_cam_N", "quantity")]
)
def test_key_has_a_meaning(path: str, key: str, kind: str) -> None:
    (meaning,) = answer("explain", path, key)["meanings"]
    assert meaning["kind"] == kind


def test_unknown_keys_are_refused_with_close_ones(path: str) -> None:
    assert "did you mean N_cam" in refusal("explain", path, "N_camm")
    assert "F_B1x" in refusal("explain", "wang2017", "F_B1xx")
    assert "nowhere.toml: there is no such file" in refusal("explain", "nowhere.toml", "h_mm")


def test_drawing_names_lengths_with_values() -> None:
    """Of the slider-crank's lengths h is as long as a distance by chance, l_0 and wall are seen
    nowhere.
    """
    place = own.generated("slider_crank") / "slider_crank.toml"
    sheet = sheets.draw(str(place), {})
    assert sheet is not None
    lengths = {mark.names[0]: mark.size for mark in sheet.marks if isinstance(mark, Length)}
    assert lengths == pytest.approx({"r": 50.0, "l": 200.0, "c": 80.0, "e": 10.0}, rel=1e-9)
    assert {"phi", "beta"} <= sheet.names


def test_page_has_values_in_the_unit_beside_them(path: str) -> None:
    mechanism = explain_mechanism(path, {})
    (table,) = (
        block
        for section in present_mechanism(mechanism, None, is_written=False).sections
        if section.title == "Values"
        for block in section.blocks
        if isinstance(block, Table)
    )
    numbers = tomllib.loads(Path(path).read_text(encoding="utf-8"))["values"]
    for row in table.rows:
        cells = dict(zip(table.head, row, strict=True))
        name = str(cells["key"]).removeprefix("values.")
        assert cells["value"] == pytest.approx(numbers[name])
        assert cells["unit"] == units.display_unit(name)


def test_symbols_table_has_values_in_the_unit_beside_them(path: str, tmp_path: Path) -> None:
    answer("explain", path, "--out", str(tmp_path))
    numbers = tomllib.loads(Path(path).read_text(encoding="utf-8"))["values"]
    with (tmp_path / "symbols.csv").open(encoding="utf-8", newline="") as file:
        values = [row for row in csv.DictReader(file) if row["kind"] == "value"]
    assert {row["unit"] for row in values} > {"mm"}
    for row in values:
        name = row["key"].removeprefix("values.")
        assert float(row["value"]) == pytest.approx(numbers[name])
        assert row["unit"] == units.display_unit(name)
