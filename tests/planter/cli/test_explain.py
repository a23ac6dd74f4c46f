"""Every symbol, key and column can be explained, and a machine is what its statement says."""

from __future__ import annotations

import csv
import json
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

from planter.cli import dictionary
from planter.cli.explanation import draw_sheets, explain_machine, find_meanings
from planter.engine.machine import load_machine
from planter.errors import InputError
from planter.files import schema, units
from planter.kernels import generated
from planter.report.sheet import Angle, Length, Sheet, Spot, draw_figure
from tests.support import machines, own
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema


@cache
def named() -> set[str]:
    return {
        name
        for meaning in dictionary.collect_meanings()
        for name in (meaning.name, meaning.key)
        if name
    }


def numeric_keys(node: Any) -> Iterator[str]:
    """Keys of a schema, at any depth, below which a number may stand."""
    if isinstance(node, Mapping):
        for key, value in node.get("properties", {}).items():
            if dictionary.carries_number(value):
                yield key
        for value in node.values():
            yield from numeric_keys(value)


def test_every_numeric_schema_key_is_explained() -> None:
    keys = {
        key for command in schema.load_result_types() for key in numeric_keys(load_schema(command))
    }
    assert len(keys) > 200
    assert keys <= named()
    assert "made_up_N" not in named()


def test_every_model_symbol_is_explained() -> None:
    meanings = {(meaning.name, meaning.meaning) for meaning in dictionary.collect_meanings()}
    for name in generated.names():
        if "loads" in generated.sidecar(name):  # loads are drawn, and have no names of their own
            continue
        for vector in generated.sidecar(name).get("vectors", {}).values():
            for entry in vector if isinstance(vector, list) else ():
                assert (entry["name"], entry["meaning"]) in meanings


@pytest.mark.parametrize("name", ["wang2017-wide", "compact"])
def test_every_number_of_a_machine_file_is_explained(name: str) -> None:
    for path in machines.machine(name).numbers():
        key = path.partition("[")[0]
        assert {key, key.rpartition(".")[2]} & named(), path


def test_every_key_of_a_file_has_a_meaning_of_its_own() -> None:
    keys = [meaning for meaning in dictionary.collect_meanings() if meaning.kind == "file key"]
    shared = Counter((meaning.machine, meaning.source, meaning.meaning) for meaning in keys)
    assert len(keys) > 200
    assert [
        meaning.key
        for meaning in keys
        if shared[meaning.machine, meaning.source, meaning.meaning] > 1
    ] == []


def test_keys_of_a_machine_are_explained() -> None:
    described = explain_machine(own.file("transplanting_arm").source, {})

    def list_keys(key: str) -> list[str | None]:
        return [meaning.key for meaning in find_meanings(described, key).meanings]

    assert list_keys("objective") == ["objective.least", "objective.samples"]
    assert list_keys("hold") == list_keys("requirements.hold") == ["requirements.hold"]
    assert list_keys("a_mm") == ["values.a_mm"]
    assert len(list_keys("genetic_algorithm")) == 7
    with pytest.raises(InputError, match="did you mean hold"):
        list_keys("holdd")


CALLS = (
    ("train", "sun2019-curve"),
    ("synthesise", "sun2019-corrected"),
    ("pickup", "yu2023"),
    ("clutch", "field"),
    ("clutch", "geometry", "shi2021"),
    ("clutch", "engage", "shi2021", "--mode", "contact"),
)


@pytest.mark.parametrize(
    "call",
    [pytest.param(call, marks=[] if i == 0 else pytest.mark.long) for i, call in enumerate(CALLS)],
)
def test_every_written_column_is_explained(call: tuple[str, ...], tmp_path: Path) -> None:
    code, _, err = run(*call, "--out", str(tmp_path))
    assert code == 0, err
    written = list(tmp_path.rglob("*.csv"))
    assert written
    for path in written:
        head, *rows = (
            row for row in csv.reader(path.open(encoding="utf-8")) if not row[0].startswith("#")
        )
        numeric = [name for name, cell in zip(head, rows[0], strict=True) if _is_number(cell)]
        assert set(numeric) <= named(), path.name


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def test_a_name_has_unit_key_and_verdict() -> None:
    (force,) = (
        meaning
        for meaning in dictionary.explain_name("F_B1x").meanings
        if meaning.machine == "planting"
    )
    assert (force.unit, force.key) == ("N", "F_B1x_N")
    (angle,) = (
        meaning
        for meaning in dictionary.explain_name("mu").meanings
        if meaning.machine == "planting"
    )
    assert angle.equations is not None
    assert (angle.equations[0].equation, angle.equations[0].verdict) == ("1", "confirmed")
    (ratio,) = (meaning for meaning in dictionary.explain_name("gears.poisson_ratio").meanings)
    assert ratio.allowed == "at least 0, less than 0.5, may be left out"
    (curve,) = (meaning for meaning in dictionary.explain_name("R3_mm").meanings)
    assert curve.meaning.startswith("radius of the eccentric circle")


def test_an_unknown_name_is_asked_back_and_all_names_are_listed() -> None:
    assert "did you mean F_B1" in refusal("explain", "F_B1z_N")
    names = answer("explain")["names"]
    assert "F_B1x" in names["planting"]
    assert "x_s" in names["mapping"]


@pytest.fixture(scope="module")
def path() -> str:
    return str(own.generated("cam_follower") / "cam_follower.toml")


def test_explanations_equal_sidecar(path: str, tmp_path: Path) -> None:
    result = answer("explain", path, "--set", "h_mm=15", "--out", str(tmp_path))
    sidecar = own.file("cam_follower").model.sidecar
    vectors = sidecar["vectors"]
    assert [v["name"] for v in result["values"]] == [e["name"] for e in vectors["data"]]
    single = [value["name"] for value in result["quantities"] if "components" not in value]
    assert single == [entry["name"] for entry in vectors["outputs"]]
    sizes = {value["name"]: value["components"] for value in result["quantities"][len(single) :]}
    assert sizes["F_O"] == ["F_Ox", "F_Oy"]
    assert [value["name"] for value in result["functions"]] == list(sidecar["functions"])
    lift = next(value for value in result["values"] if value["name"] == "h")
    assert (lift["value"], lift["allowed"]) == (15.0, "from 8 to 20 mm")
    push = next(value for value in result["quantities"] if value["name"] == "N_cam")
    assert "only push" in push["meaning"]
    assert {value["kind"] for value in result["quantities"]} == {"quantity", "check"}
    assert all((tmp_path / file).is_file() for file in result["files"])


def test_unknown_keys_are_refused_with_close_ones(path: str) -> None:
    assert "did you mean N_cam" in refusal("explain", path, "N_camm")
    assert "F_B1x" in refusal("explain", "wang2017", "F_B1xx")
    assert "nowhere.toml" in refusal("explain", "nowhere.toml", "h_mm")


def test_values_are_in_the_unit_beside_them(path: str, tmp_path: Path) -> None:
    answer("explain", path, "--out", str(tmp_path))
    numbers = tomllib.loads(Path(path).read_text(encoding="utf-8"))["values"]
    with (tmp_path / "symbols.csv").open(encoding="utf-8", newline="") as file:
        values = [row for row in csv.DictReader(file) if row["kind"] == "value"]
    assert {row["unit"] for row in values} > {"mm"}
    for row in values:
        name = row["key"].removeprefix("values.")
        assert float(row["value"]) == pytest.approx(numbers[name])
        assert row["unit"] == units.display_unit(name)


MACHINES = {"wang2017": 4, "shi2021": 4, "yu2023": 3, "sun2019-corrected": 2}
SHEETS = [(source, index) for source, count in MACHINES.items() for index in range(count)]


@cache
def sheets(source: str) -> list[Sheet]:
    return draw_sheets(source, {})


@pytest.mark.parametrize(("source", "index"), SHEETS)
def test_names_stand_inside_the_figure_and_on_no_other(source: str, index: int) -> None:
    drawing = draw_figure(sheets(source)[index])
    drawing.draw_without_rendering()
    texts = [text for text in drawing.axes[0].texts if isinstance(text, Text) and text.get_text()]
    boxes = [text.get_window_extent() for text in texts]
    assert len(boxes) == len(sheets(source)[index].marks)
    for box in boxes:
        assert drawing.bbox.x0 <= box.x0
        assert box.x1 <= drawing.bbox.x1
        assert drawing.bbox.y0 - 1 <= box.y0
        assert box.y1 <= drawing.bbox.y1 + 1
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def measured(sheets: list[Sheet]) -> dict[str, float]:
    """What lengths and angles measure [mm, deg], by name."""
    measures = {}
    for sheet in sheets:
        for mark in sheet.marks:
            size = (
                mark.size
                if isinstance(mark, Length)
                else abs(mark.turn)
                if isinstance(mark, Angle)
                else None
            )
            measures |= {} if size is None else dict.fromkeys(mark.names, size)
    return measures


@pytest.mark.parametrize("source", MACHINES)
def test_drawn_dimensions_equal_file_values(source: str) -> None:
    """The symbols on a drawing whose key is a number of the file."""
    described, sizes = explain_machine(source, {}, sheets(source)), measured(sheets(source))
    numbers = load_machine(source).document.numbers()
    keys = {meaning.name: meaning.key for sheet in described.sheets for meaning in sheet.symbols}
    values = {
        name: abs(float(numbers[key]))
        for name, key in keys.items()
        if key in numbers and name in sizes
    }
    assert len(values) >= (1 if described.kind == "mapping" else 5)
    assert {name: sizes[name] for name in values} == pytest.approx(values, rel=1e-9)


def test_drawn_device_dimensions_equal_simulation() -> None:
    (at,) = answer("simulate", "wang2017", "--samples", "36", "--at", "40")["at"]
    device_sheets = sheets("wang2017")
    sizes = measured(device_sheets[:2])
    for name, column in (
        ("phi52", "phi52_deg"),
        ("phi72", "phi72_deg"),
        ("alpha", "alpha_deg"),
        ("phi_deg", "phi_deg"),
    ):
        assert sizes[name] == pytest.approx(abs(at[column]), rel=1e-9)
    spots = {mark.names[0]: mark.at for mark in device_sheets[1].marks if isinstance(mark, Spot)}
    assert spots["x_tip"] == pytest.approx([at["tip_x_mm"], at["tip_y_mm"]], rel=1e-9)


def test_angles_at_a_joint_end_on_the_bars() -> None:
    """The nozzle lies along alpha; what the planet turned by ends there, and began where it is
    mounted.
    """
    marks = {mark.names[0]: mark for sheet in sheets("wang2017")[:2] for mark in sheet.marks}
    nozzle, alpha, mounted, turned = (marks[name] for name in ("L_tip", "alpha", "theta", "phi72"))
    assert isinstance(nozzle, Length)
    angle = np.degrees(np.arctan2(*(np.asarray(nozzle.end) - nozzle.start)[::-1]))
    ends = [mark.start + mark.turn for mark in (alpha, turned) if isinstance(mark, Angle)]
    assert [(end - angle + 180) % 360 - 180 for end in ends] == pytest.approx([0, 0], abs=1e-6)
    assert isinstance(mounted, Angle)
    assert isinstance(turned, Angle)
    assert mounted.start + mounted.turn == pytest.approx(turned.start)
    line, ray = marks["a1"], marks["t1"]
    assert isinstance(line, Length)
    assert isinstance(ray, Angle)
    towards = np.degrees(np.arctan2(*np.asarray(line.end)[::-1]))
    assert ray.start + ray.turn == pytest.approx(towards, abs=1e-6)


def test_marks_of_the_polygon_lie_on_it() -> None:
    """C is the width away from A and from B; A and B lie on their sides; the ellipse passes C."""
    marks = {mark.names[0]: mark for mark in sheets("shi2021")[0].marks}
    a, b, c, centre = (np.asarray(marks[name].anchor) for name in ("x_A", "X_B", "x_C", "x_E"))
    width = measured([sheets("shi2021")[0]])["R"]
    assert np.hypot(*(c - a)) == pytest.approx(width) == np.hypot(*(c - b))
    assert a[1] == pytest.approx(width / 2)
    axis = np.radians(measured([sheets("shi2021")[0]])["axis"])
    axes = np.array([[np.cos(axis), -np.sin(axis)], [np.sin(axis), np.cos(axis)]]) @ (c - centre)
    major, minor = (measured([sheets("shi2021")[0]])[name] for name in ("s_1", "s_2"))
    assert (axes[0] / major) ** 2 + (axes[1] / minor) ** 2 == pytest.approx(1)


def test_machine_is_drawn_with_table(tmp_path: Path) -> None:
    result = answer("explain", "shi2021", "--set", "crank_mm=14.5", "--out", str(tmp_path))
    assert {
        path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.name[0] != "."
    } >= set(result["files"])
    (crank,) = (
        symbol
        for sheet in result["sheets"]
        for symbol in sheet["symbols"]
        if symbol["name"] == "l_AB"
    )
    assert (crank["key"], crank["value"], crank["unit"]) == ("linkage.crank_mm", 14.5, "m")
    assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8")) == result
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "length of the crank" in page
    assert page.count("<svg") == len(result["sheets"])
    assert "F_B1x" in refusal("explain", "F_B1x", "--out", str(tmp_path))


def test_drawing_names_lengths_with_values() -> None:
    """Of the slider-crank's lengths h is as long as a distance by chance, l_0 and wall are seen
    nowhere.
    """
    (sheet,) = draw_sheets(str(own.generated("slider_crank") / "slider_crank.toml"), {})
    lengths = {mark.names[0]: mark.size for mark in sheet.marks if isinstance(mark, Length)}
    assert lengths == pytest.approx({"r": 50.0, "l": 200.0, "c": 80.0, "e": 10.0}, rel=1e-9)
    assert {"phi", "beta"} <= sheet.names
