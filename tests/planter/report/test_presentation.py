"""One presentation of a result gives the terminal, the page and the folder."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from planter.files.record import Record
from planter.papers.clutch.file import load_clutch
from planter.report import process, style
from planter.report.console import Console
from planter.report.html import Folded, Items, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import list_values, tabulate_angles
from planter.report.presentation import (
    ModelAssumptions,
    PlacedFigure,
    ResultPresentation,
    find_key_figures,
    tabulate_inputs,
)


@dataclass(frozen=True)
class StrokeResult(Record):
    """A stroke."""

    stroke_mm: float


SECTIONS = [
    Section(
        "Stroke",
        [
            Text("It is measured between the dead centres."),
            Items(["one jump"], "warning"),
            Keys({"stroke / mm": 12.5}),
            Table(
                ("point", "x / mm", "origin"),
                [("A", 1.5, "assumed")],
                "Points",
                page_columns=("origin",),
            ),
        ],
    )
]


@pytest.fixture
def presentation() -> ResultPresentation:
    return ResultPresentation(
        "A slider",
        StrokeResult(12.5),
        SECTIONS,
        conclusion="The stroke is sufficient.",
        model=ModelAssumptions("Slider (textbook)", ["rigid bodies"], {}),
        details=lambda: [Section("Symbols", [Text("x is the position.")])],
        tables=lambda: {"cycle.csv": {"x_mm": np.array([0.0, 12.5])}},
    )


def test_terminal_shows_sections(
    presentation: ResultPresentation, capsys: pytest.CaptureFixture[str]
) -> None:
    presentation.show(Console(as_json=False))
    out = capsys.readouterr().out
    for part in (
        "A slider",
        "The stroke is sufficient.",
        "Stroke:",
        "- one jump",
        "stroke / mm",
        "Points",
        "x / mm",
    ):
        assert part in out
    assert "assumed" not in out
    assert "x is the position" not in out


def test_json_is_the_record(
    presentation: ResultPresentation, capsys: pytest.CaptureFixture[str]
) -> None:
    presentation.show(Console(as_json=True))
    assert json.loads(capsys.readouterr().out) == {"stroke_mm": 12.5}


def test_folder_has_summary_tables_and_page(
    presentation: ResultPresentation, tmp_path: Path
) -> None:
    presentation.write(tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary == {"stroke_mm": 12.5, "assumptions": ["rigid bodies"]}
    assert (tmp_path / "cycle.csv").read_text().split() == ["x_mm", "0.0", "12.5"]
    page = (tmp_path / "report.html").read_text()
    for part in (
        "The stroke is sufficient.",
        "assumed",
        "x is the position.",
        "rigid bodies",
        "one jump",
    ):
        assert part in page


def test_placed_figures_precede_figures_of_no_section() -> None:
    sections = [Section("Stroke", [PlacedFigure("stroke")]), Section("Speed", [])]
    page = ResultPresentation("A slider", StrokeResult(12.5), sections).page(
        {"torque": "<svg>torque</svg>", "force": "<svg>force</svg>", "stroke": "<svg>stroke</svg>"}
    )
    assert page.index(">stroke</svg>") < page.index("<h2>Speed") < page.index(">force</svg>")
    assert page.index(">torque</svg>") < page.index("<nav"), (
        "the first figure of no section is that of the lead"
    )


def test_page_opens_with_conclusion_and_three_numbers() -> None:
    table = Table(
        ("", "value", "unit"),
        [("stroke", -12.3456, "mm"), ("speed", True, ""), ("mass", 2.0, "kg")],
    )
    sections = [
        Section("Sizes", [Text("words"), table, Keys({"force / N": 4.0, "name": "x", "rank": 5})])
    ]
    page = ResultPresentation("A slider", StrokeResult(12.5), sections, "It strokes 12.5 mm.").page(
        {}
    )
    lead = page[page.index("</h1>") : page.index("<nav")]
    assert lead.index("It strokes 12.5 mm.") < lead.index("key-figures")
    figures = find_key_figures(sections)
    assert [(figure.value, figure.unit) for figure in figures] == [
        ("\N{MINUS SIGN}12.35", "mm"),
        ("2", "kg"),
        ("4", "N"),
    ]
    assert figures[0].meaning == "Sizes, stroke"
    assert all(figure.value in lead for figure in figures)
    stated = [KeyFigure("7", "N", "largest force")]
    page = ResultPresentation("A slider", StrokeResult(12.5), sections, key_figures=stated).page({})
    assert "largest force" in page
    assert "Sizes, stroke" not in page


def test_key_figures_have_the_unit_of_their_row_and_skip_counts() -> None:
    rows = Table(("pose", "angle / deg"), [(1, 45.0)])
    table = Table(("quantity", "value", "least"), [("radius / mm", 5.0, 1.0)])
    (figure,) = find_key_figures([Section("Results", [rows, Keys({"seed": 3}), table])])
    assert figure == KeyFigure("5", "mm", "Results, radius")


def test_pictures_without_caption_have_a_name() -> None:
    page = ResultPresentation("A slider", StrokeResult(12.5), []).page(
        {"bearing_forces": "<svg></svg>"}
    )
    assert 'aria-label="bearing forces"' in page


def test_page_says_how_to_repeat_a_command() -> None:
    presentation = ResultPresentation("A slider", StrokeResult(12.5), [])
    assert "Reproduce" not in presentation.page({})
    process.record_command(
        ["simulate", "/home/me/slider.toml", "--out", "there", "--samples", "72"]
    )
    try:
        assert "planter simulate slider.toml --samples 72</pre>" in presentation.page({})
    finally:
        process.record_command([])


def test_groups_of_values_have_their_unit() -> None:
    values = {
        "a_mm": 1.0,
        "radius_mm": {"min": 2.0, "max": 3.0},
        "dwell": {"start_deg": 4.0},
        "points": [1, 2],
    }
    assert list_values(values).pairs == {
        "a / mm": 1.0,
        "radius: min / mm": 2.0,
        "radius: max / mm": 3.0,
        "dwell: start / deg": 4.0,
    }


def test_angles_are_columns() -> None:
    table = tabulate_angles(
        [{"t_deg": 0.0, "x_mm": 1.0}, {"t_deg": 90.0, "x_mm": [2.0, 3.0]}], "t_deg"
    )
    assert table.head == ("quantity", "at 0 deg", "at 90 deg")
    assert table.rows == [("x / mm", 1.0, "2, 3")]


def test_figures_and_pages_typeset_units_alike() -> None:
    figure = style.new_figure(2)
    axes = figure.subplots()
    axes.set_xlabel("angle / deg")
    axes.set_ylabel("variance / N2\nof the force")
    style.fix_layout(figure)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("angle / °", "variance / N²\nof the force")
    page = Table(("pose", "angle / deg"), [("at 45 deg", 45.0)], "up to 30 deg").html("t")
    assert all(text in page for text in ("angle / °", "at 45°", "up to 30°"))
    assert "deg" not in page


def test_rows_without_a_name_are_no_key_figures() -> None:
    table = Table(
        ("rank", "pair", "objective"), [(None, "ellipse, ellipse", 1.2), ("A", "sine, sine", 1.3)]
    )
    (figure,) = find_key_figures([Section("Pairs", [table])])
    assert figure.meaning == "Pairs, A, objective"


def test_inputs_are_named_by_meaning_and_keep_their_keys() -> None:
    machine = load_clutch("shi2021")
    blocks = list(tabulate_inputs(machine, {"sleeve.travel_mm": "Travel of the sleeve"}))
    rows = {
        row[-1]: row[0]
        for block in blocks
        if isinstance(block, Folded)
        for row in block.blocks[0].rows
    }
    assert rows["travel_mm"] == "Travel of the sleeve"
    assert rows["axial_angle_deg"] == "axial angle"
