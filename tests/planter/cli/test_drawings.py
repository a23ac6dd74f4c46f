"""Drawings of machines: names stand inside, and marks measure the values that they name."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text

from planter.cli.explanation import draw_sheets, explain_machine
from planter.engine.machine import load_machine
from planter.report.sheet import Angle, Length, Sheet, Spot, draw_figure
from tests.support import own
from tests.support.cli import answer, refusal

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
    drawn = sheets("wang2017")
    sizes = measured(drawn[:2])
    for name, column in (
        ("phi52", "phi52_deg"),
        ("phi72", "phi72_deg"),
        ("alpha", "alpha_deg"),
        ("phi_deg", "phi_deg"),
    ):
        assert sizes[name] == pytest.approx(abs(at[column]), rel=1e-9)
    spots = {mark.names[0]: mark.at for mark in drawn[1].marks if isinstance(mark, Spot)}
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
