"""One presentation of a result gives the terminal, the page and the folder."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter import simulate
from planter.files.record import Record
from planter.kernels import generated
from planter.mechanism.presentation import present_cycle
from planter.mechanism.results import MechanismWarning
from planter.papers.clutch.file import load_clutch
from planter.papers.planting.design_presentation import present_optimum
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.optimisation import Optimisation, optimise
from planter.papers.planting.report.forces import draw_support_force
from planter.report import html, process, style
from planter.report.console import Console
from planter.report.html import Folded, Items, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import list_values, tabulate_angles, tabulate_named
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


def test_named_values_have_units_and_keys() -> None:
    names = {"t_max_s": "Time of the largest load", "x_s": "Split /", "error_per_s": "Error / 1/s"}
    table = tabulate_named({"t_max_s": 1.5, "x_s": 0.9, "error_per_s": 2.0, "mass_kg": 3.0}, names)
    assert table.rows == [
        ("Time of the largest load", 1.5, "s", "t_max_s"),
        ("Split", 0.9, "", "x_s"),
        ("Error", 2.0, "1/s", "error_per_s"),
        ("mass", 3.0, "kg", "mass_kg"),
    ]


EVIL = "<script>alert('x')</script> & \"more\""


@pytest.fixture(scope="module")
def drawings() -> dict[str, str]:
    curves = {"exact": (np.array([0.0, 360.0]), np.array([1.0, 2.0]))}
    drawing = style.render_svg(draw_support_force(curves, 1.0))
    return {"first": drawing, "second": drawing}


@pytest.fixture(scope="module")
def optimisation() -> Optimisation:
    return optimise(Device(load("wang2017")), "ipopt", "60", starts=1)


@pytest.fixture(scope="module")
def page(optimisation: Optimisation, drawings: dict[str, str]) -> str:
    return render(optimisation, optimisation.devices["exact"], drawings)


def render(
    optimisation: Optimisation, device: Device, drawings: dict[str, str], **changes: Any
) -> str:
    """The page of an optimum whose record has some `changes`, without the moving drawing, which has
    a script.
    """
    changed = replace(optimisation, result=replace(optimisation.result, **changes))
    return replace(present_optimum(changed, device), motions=tuple).page(drawings)


def tree(page: str) -> ET.Element:
    """The page, read as XML: every element closed, every text escaped."""
    return ET.fromstring(page.removeprefix("<!DOCTYPE html>\n"))


def words(page: str) -> str:
    return " ".join(" ".join(tree(page).itertext()).split())


def test_page_is_well_formed_with_all_sections(page: str) -> None:
    root = tree(page)
    assert root.tag == "html"
    assert root.get("lang") == "en"
    (title,) = root.iter("h1")
    assert title.text.startswith("Optimisation of the planting device wang2017")
    assert [e.findtext("h2") for e in root.iter("section")] == [
        "Vertical support force",
        "Design",
    ]
    assert [e.text for e in root.iter("h2")][2:] == [
        "Designer's summary",
        "Objective of both designs in both models",
        "Insensitive directions",
        "Certificate",
        "Figures",
        "Model",
        "Inputs",
        "Provenance",
    ]
    parts = [e.get("id") for e in root.iter() if re.fullmatch(r"s\d+", e.get("id") or "")]
    assert [a.get("href") for a in root.iter("a")] == [f"#{part}" for part in parts]
    assert len(parts) == len(list(root.iter("h2")))


def test_ids_are_unique_and_references_resolve(
    optimisation: Optimisation, drawings: dict[str, str]
) -> None:
    page = render(
        optimisation, optimisation.devices["exact"], {**drawings, "again": drawings["second"]}
    )
    ids = [e.get("id") for e in tree(page).iter() if e.get("id")]
    assert len(ids) == len(set(ids)) > 100
    references = re.findall(r'href="#([^"]+)"', page) + re.findall(r"url\(#([^)]+)\)", page)
    assert references
    assert set(references) <= set(ids)


def test_page_loads_and_runs_no_resources(page: str) -> None:
    assert re.findall(r"""(?:src|href)=["'](?!#)[^"']*|url\((?!#)[^)]*|@import""", page) == []
    elements = {e.tag.rpartition("}")[2] for e in tree(page).iter()}
    assert "svg" in elements
    assert not elements & {"script", "link", "iframe", "img", "object"}


def test_texts_are_escaped(optimisation: Optimisation, drawings: dict[str, str]) -> None:
    device = Device(load("wang2017").model_copy(update={"name": EVIL, "description": EVIL}))
    page = render(
        optimisation, device, {EVIL: drawings["second"]}, machine=EVIL, model=EVIL, method=EVIL
    )
    assert "<script" not in page
    assert words(page).count(EVIL) >= 5


@pytest.mark.parametrize(
    "block",
    [
        html.Text(EVIL),
        html.Text("a", EVIL),
        html.Items([EVIL]),
        html.Keys({EVIL: EVIL}),
        html.Table([EVIL], [[EVIL, EVIL]], EVIL),
        html.FigureSvg("<svg></svg>", EVIL),
        html.Folded(EVIL, [html.Text(EVIL)]),
    ],
)
def test_every_block_escapes(block: html.Block) -> None:
    page = html.render_page(EVIL, [html.Section(EVIL, [block])], EVIL)
    assert "<script" not in page
    assert EVIL in words(page)


def test_inputs_have_their_origins(optimisation: Optimisation, drawings: dict[str, str]) -> None:
    machine = load("wang2017", {"sun_kg": 0.45})
    page = render(optimisation, Device(machine), drawings)
    folded = tree(page).iter("details")
    inputs = next(part for part in folded if part.findtext("summary/h2") == "Inputs")
    rows = [[" ".join(cell.itertext()) for cell in row] for row in inputs.iter("tr")]
    by_key = {row[-1]: row for row in rows}
    for path, value in machine.numbers().items():
        section, _, key = path.partition(".")
        if section in ("bounds", "design"):
            continue
        row = by_key[key]
        assert float(row[1].replace("\N{MINUS SIGN}", "-")) == value
        assert row[3] == machine.origin(path)
    assert by_key["sun_kg"][3] == machine.origin("sun_kg") != load("wang2017").origin("sun_kg")
    assert by_key["sun_kg"][:3] == ["mass of the sun", "0.45", "kg"]


def test_simulation_shows_warnings_forces_and_assumptions() -> None:
    simulation = simulate(Device(load("wang2017")), 24, [100.0])
    warning = MechanismWarning(
        name="tooth_contact_P", phi_deg=33.25, message="the teeth would <have> to pull"
    )
    warned = replace(simulation, result=replace(simulation.result, warnings=[warning]))
    text = words(replace(present_cycle(warned), motions=tuple).page({}))
    parts = (
        "the teeth would <have> to pull (tooth_contact_P)",
        "weight 97.8547",
        "F_E / N 56.6762",
        "omega dot / rad/s2 0.269574",
        *generated.sidecar("planting_exact")["assumptions"],
    )
    for part in parts:
        assert part in text
    clean = words(replace(present_cycle(simulation), motions=tuple).page({}))
    assert "Certificate" not in clean
    assert "Warnings" not in clean


def test_units_of_tables_and_figures_are_typeset() -> None:
    table = html.Table(
        ("quantity", "unit", "area / mm2"), [("variance", "N2", 1.0), ("ratio", "1", 2.0)]
    ).html("")
    assert "N\N{SUPERSCRIPT TWO}" in table
    assert "mm\N{SUPERSCRIPT TWO}" in table
    assert '<td class="short">1</td>' not in table
    assert "rad/s\N{SUPERSCRIPT TWO}" in html.KeyFigures(
        [html.KeyFigure("2", "rad/s2", "acceleration")]
    ).html("")
    assert "2 a2" in html.Table(("quantity",), [("2 a2",)]).html("")


@pytest.mark.parametrize(
    ("cell", "kind"),
    [
        ("pass", "short"),
        ("x" * html.LONG, "long"),
        (html.MarkupCell("key", "a" * html.LONG), "long"),
        (html.MarkupCell("key", f"<b title='{'a' * html.LONG}'>name</b>"), "short"),
    ],
)
def test_cells_are_classed_by_what_a_page_shows(cell: str, kind: str) -> None:
    assert f'<td class="{kind}">' in html.Table(("", ""), [("row", cell)]).html("")


def _luminance(colour: str) -> float:
    parts = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    linear = (
        part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
    )
    return sum(
        weight * value for weight, value in zip((0.2126, 0.7152, 0.0722), linear, strict=True)
    )


def _contrast(first: str, second: str) -> float:
    dark, light = sorted((_luminance(first), _luminance(second)))
    return (light + 0.05) / (dark + 0.05)


DARK_PAPER = "#151b22"
"""The paper of a page in dark colours."""


@pytest.mark.parametrize("shade", style.PALETTE)
def test_labels_of_curves_are_legible_on_both_papers(shade: str) -> None:
    label = style.TEXT_SHADES.get(shade, shade)
    assert _contrast(label, style.PAPER) >= 4.5
    assert _contrast(style.DARK_SHADES.get(label, label), DARK_PAPER) >= 4.5
    assert _contrast(style.DARK_SHADES.get(shade, shade), DARK_PAPER) >= 3
    assert f"--paper: {DARK_PAPER}" in html.render_page("", [])
