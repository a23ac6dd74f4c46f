"""The page: well formed, complete, closed in itself, and safe whatever the texts are."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planter import simulate
from planter.kernels import generated
from planter.mechanism.presentation import present_cycle
from planter.mechanism.results import MechanismWarning
from planter.papers.planting.design_presentation import present_optimum
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.optimisation import Optimisation, optimise
from planter.papers.planting.report.forces import draw_support_force
from planter.report import html, style

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
    assert [e.text for e in root.iter("h2")] == [
        "Design",
        "Vertical support force",
        "Designer's summary",
        "Objective of both designs in both models",
        "Insensitive directions",
        "Certificate",
        "Figures",
        "Model",
        "Inputs",
        "Provenance",
    ]
    assert [a.get("href") for a in root.iter("a")] == [
        f"#{s.get('id')}" for s in root.iter("section")
    ]


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
    inputs = next(s for s in tree(page).iter("section") if s.findtext("h2") == "Inputs")
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


def test_page_of_second_machine_has_inputs() -> None:
    simulation = simulate(Device(load("compact")), 24)
    page = replace(present_cycle(simulation), motions=tuple).page({})
    assert re.search(
        "forward speed of the machine \N{MINUS SIGN}0.5 m/s .* forward_speed_m_s", words(page)
    )


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
