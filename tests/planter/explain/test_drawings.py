"""Every length, angle and point of a machine stands on its drawings, or it is said why not; marks
measure values.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text

from planter.explain import machine
from planter.explain.machine import LabelledMachine, draw_machine
from planter.files import units
from planter.view.sheet import Angle, Length, Sheet, Spot, draw_figure
from tests.support.cli import answer, refusal

MACHINES = {"wang2017": 4, "shi2021": 4, "yu2023": 3, "sun2019-corrected": 2}
SHEETS = [(source, index) for source, count in MACHINES.items() for index in range(count)]


@cache
def open_machine(source: str) -> LabelledMachine:
    return draw_machine(source, {})


def without_reason(changed_machine: LabelledMachine) -> list[str]:
    """Names of the geometry that are on no sheet and for which nothing says why."""
    return [
        symbol.name
        for symbol in changed_machine.symbols()
        if symbol.left_out == machine.NO_SUCH_PART
    ]


@pytest.mark.parametrize("source", MACHINES)
def test_every_dimension_is_drawn_or_has_a_reason(source: str) -> None:
    changed_machine = open_machine(source)
    assert not without_reason(changed_machine)
    names = {symbol.name for symbol in machine.list_geometry(changed_machine.package)}
    named = set().union(*(sheet.names for sheet in changed_machine.labelled.sheets))
    assert named <= names
    reasons = [
        pattern for patterns in changed_machine.labels.UNDRAWN.values() for pattern in patterns
    ]
    missing = [
        symbol
        for symbol in machine.list_geometry(changed_machine.package)
        if symbol.name not in named
    ]
    assert not [
        pattern
        for pattern in reasons
        if not any(machine.matches_pattern(symbol, pattern) for symbol in missing)
    ]


def test_forgotten_symbol_is_detected() -> None:
    machine = open_machine("wang2017")
    train = machine.labelled.sheets[0]
    fewer = replace(train, marks=[mark for mark in train.marks if "a1" not in mark.names])
    labelled = replace(machine.labelled, sheets=[fewer, *machine.labelled.sheets[1:]])
    assert without_reason(replace(machine, labelled=labelled)) == ["a1"]


@pytest.mark.parametrize(("source", "index"), SHEETS)
def test_names_stand_inside_the_figure_and_on_no_other(source: str, index: int) -> None:
    drawing = draw_figure(open_machine(source).labelled.sheets[index])
    drawing.draw_without_rendering()
    texts = [text for text in drawing.axes[0].texts if isinstance(text, Text) and text.get_text()]
    boxes = [text.get_window_extent() for text in texts]
    assert len(boxes) == len(open_machine(source).labelled.sheets[index].marks)
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


def geometry_values(machine: LabelledMachine) -> dict[str, float]:
    """What the machine's file gives for symbols [mm, deg], by name."""
    numbers = machine.labelled.numbers
    return {
        symbol.name: abs(float(numbers[symbol.key]))
        for symbol in machine.symbols()
        if symbol.key in numbers
    }


@pytest.mark.parametrize("source", MACHINES)
def test_drawn_dimensions_equal_file_values(source: str) -> None:
    machine = open_machine(source)
    sizes, values = measured(list(machine.labelled.sheets)), geometry_values(machine)
    both = sorted(sizes.keys() & values.keys())
    assert len(both) >= (1 if machine.package == "mapping" else 9)
    assert {name: sizes[name] for name in both} == pytest.approx(
        {name: values[name] for name in both}, rel=1e-9
    )


def test_drawn_device_dimensions_equal_simulation() -> None:
    (at,) = answer("simulate", "wang2017", "--samples", "36", "--at", "40")["at"]
    sheets = list(open_machine("wang2017").labelled.sheets)
    sizes = measured(sheets[:2])
    for name, column in (
        ("phi52", "phi52_deg"),
        ("phi72", "phi72_deg"),
        ("alpha", "alpha_deg"),
        ("phi_deg", "phi_deg"),
    ):
        assert sizes[name] == pytest.approx(abs(at[column]), rel=1e-9)
    spots = {mark.names[0]: mark.at for mark in sheets[1].marks if isinstance(mark, Spot)}
    assert spots["x_tip"] == pytest.approx([at["tip_x_mm"], at["tip_y_mm"]], rel=1e-9)


def test_angles_at_a_joint_end_on_the_bars() -> None:
    """The nozzle lies along alpha; what the planet turned by ends there, and began where it is
    mounted.
    """
    marks = {
        mark.names[0]: mark
        for sheet in open_machine("wang2017").labelled.sheets[:2]
        for mark in sheet.marks
    }
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
    marks = {mark.names[0]: mark for mark in open_machine("shi2021").labelled.sheets[0].marks}
    a, b, c, centre = (np.asarray(marks[name].anchor) for name in ("x_A", "X_B", "x_C", "x_E"))
    width = measured([open_machine("shi2021").labelled.sheets[0]])["R"]
    assert np.hypot(*(c - a)) == pytest.approx(width) == np.hypot(*(c - b))
    assert a[1] == pytest.approx(width / 2)
    axis = np.radians(measured([open_machine("shi2021").labelled.sheets[0]])["axis"])
    axes = np.array([[np.cos(axis), -np.sin(axis)], [np.sin(axis), np.cos(axis)]]) @ (c - centre)
    major, minor = (
        measured([open_machine("shi2021").labelled.sheets[0]])[name] for name in ("s_1", "s_2")
    )
    assert (axes[0] / major) ** 2 + (axes[1] / minor) ** 2 == pytest.approx(1)


def test_machine_is_drawn_with_table(tmp_path: Path) -> None:
    result = answer("explain", "shi2021", "--set", "crank_mm=14.5", "--out", str(tmp_path))
    assert {
        path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.name[0] != "."
    } >= set(result["files"])
    crank = next(symbol for symbol in result["symbols"] if symbol["name"] == "l_AB")
    assert (crank["key"], crank["sheet"], crank["unit"]) == ("linkage.crank_mm", "linkage", "m")
    assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8")) == result
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "length of the crank" in page
    assert page.count("<svg") == len(result["sheets"])
    assert "no such machine with a labelled drawing" in refusal(
        "explain", "F_B1x", "--out", str(tmp_path)
    )


def test_units_of_lengths_and_angles_are_known() -> None:
    assert {units.display_unit(key) for key in ("a_mm", "a_deg")} < machine.GEOMETRIC


def test_poses_without_linkage_are_reported(tmp_path: Path) -> None:
    pose = "[[pose]]\nx_mm = {}\ny_mm = {}\nphi_deg = {}\n"
    file = tmp_path / "three.toml"
    text = "".join(pose.format(*row) for row in ((0, 0, 0), (50, 10, 30), (80, 60, 70)))
    file.write_text(
        f'name = "three"\ndescription = "own"\n{text}[origin]\ndefault = "measured"\n',
        encoding="utf-8",
    )
    result = answer("explain", str(file))
    lost = {row["name"]: row.get("left_out") for row in result["symbols"] if "sheet" not in row}
    assert lost["L_f"] == machine.NO_SUCH_PART
    assert lost["Z1"] == "a coordinate of the mapping, not of the plane"
