"""The page: well formed, complete, closed in itself, and safe whatever the texts are."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pytest

from planter.kernels import generated
from planter.planting.file import Machine, load
from planter.planting.report import figures
from planter.planting.report import page as planting
from planter.report import files, html

EVIL = "<script>alert('x')</script> & \"more\""
SUMMARY: dict[str, Any] = {
    "machine": "wang2017",
    "model": "exact",
    "samples": 360,
    "design": {},
    "weight_N": 97.85475,
    "centre_distance_mm": {"a1": 62.33105858627, "a2": 61.388},
    "support_force": {"max_N": 99.6302, "variance_N2": 0.27443},
    "objective": 1.98507,
    "warnings": [{"name": "tooth_contact_P", "phi_deg": 33.25, "message": "the teeth would <have> to pull"}],
    "at": [{"phi_deg": 100.0, "F_E_N": 56.676193, "omega_dot_rad_s2": 0.269574}],
    "evaluations": {"objective": 8123, "gradient": 456, "hessian": 78},
    "certificate": {
        "kkt_residual": 1.25e-11,
        "active_bounds": [{"name": "m31", "side": "upper", "multiplier": -0.3125}],
        "starts": 8,
        "agreeing_starts": 7,
        "spread": None,
    },
    "cross": {"exact": {"start": 1.985, "optimum": 1.902}, "printed": {"start": 211.25, "optimum": 209.5}},
}


@pytest.fixture(scope="module")
def drawings() -> dict[str, str]:
    history = figures.convergence({"ga": [(1, 2.0), (9, 1.0)]})
    front = figures.pareto(np.array([[1.0, 2.0], [2.0, 1.0]]), {"optimum": (1.0, 2.0)})
    return {"convergence": figures.svg(history), "pareto": figures.svg(front)}


def page_of(machine: Machine, drawings: dict[str, str], **changes: Any) -> str:
    summary = {**SUMMARY, "design": dict(machine.design), **changes}
    return planting.render_device_page(
        machine, generated.sidecar("planting_exact"), summary, drawings, files.provenance(machine, 5)
    )


def tree(page: str) -> ET.Element:
    """The page, read as XML: every element closed, every text escaped."""
    return ET.fromstring(page.removeprefix("<!DOCTYPE html>\n"))


def words(page: str) -> str:
    return " ".join(" ".join(tree(page).itertext()).split())


def test_page_is_well_formed_and_says_what_it_is(drawings: dict[str, str]) -> None:
    root = tree(page_of(load("wang2017"), drawings))
    assert root.tag == "html"
    assert root.get("lang") == "en"
    assert [e.text for e in root.iter("h1")] == ["Optimisation of the planting device wang2017"]
    headings = [e.text for e in root.iter("h2")]
    assert headings == [
        *(
            "Warnings",
            "Results",
            "Certificate",
            "Design",
            "Figures",
            "At single angles",
            "Model",
            "Inputs",
            "Names",
            "Provenance",
        )
    ]
    assert [a.get("href") for a in root.iter("a")] == [f"#{s.get('id')}" for s in root.iter("section")]


def test_ids_are_unique_and_every_reference_is_met(drawings: dict[str, str]) -> None:
    page = page_of(load("wang2017"), {**drawings, "again": drawings["pareto"]})
    ids = [e.get("id") for e in tree(page).iter() if e.get("id")]
    assert len(ids) == len(set(ids)) > 100
    wanted = re.findall(r'href="#([^"]+)"', page) + re.findall(r"url\(#([^)]+)\)", page)
    assert wanted
    assert set(wanted) <= set(ids)


def test_nothing_is_fetched_and_nothing_runs(drawings: dict[str, str]) -> None:
    page = page_of(load("wang2017"), drawings)
    assert re.findall(r"""(?:src|href)=["'](?!#)[^"']*|url\((?!#)[^)]*|@import""", page) == []
    elements = {e.tag.rpartition("}")[2] for e in tree(page).iter()}
    assert "svg" in elements
    assert not elements & {"script", "link", "iframe", "img", "object"}


def test_texts_are_escaped_wherever_they_stand(drawings: dict[str, str]) -> None:
    machine = load("wang2017").model_copy(update={"name": EVIL, "description": EVIL})
    page = page_of(machine, {EVIL: drawings["pareto"]}, model=EVIL, method=EVIL)
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
    page = html.page(EVIL, [html.Section(EVIL, [block])], EVIL)
    assert "<script" not in page
    assert EVIL in words(page)


def test_every_input_is_there_with_its_origin(drawings: dict[str, str]) -> None:
    machine = load("wang2017", {"sun_kg": 0.45})
    inputs = next(s for s in tree(page_of(machine, drawings)).iter("section") if s.findtext("h2") == "Inputs")
    rows = [[" ".join(cell.itertext()) for cell in row] for row in inputs.iter("tr")]
    by_key = {row[0]: row for row in rows}
    for path, value in machine.numbers().items():
        section, _, key = path.partition(".")
        if section in ("bounds", "design"):
            continue
        row = by_key[key]
        assert float(row[1].replace("\N{MINUS SIGN}", "-")) == value
        assert row[-1] == machine.origin(path)
    assert by_key["sun_kg"][-1] == machine.origin("sun_kg") != load("wang2017").origin("sun_kg")
    assert by_key["sun_kg"][2:4] == ["kg", "mass of the sun"]


def test_design_has_bounds_and_both_designs_where_they_differ(drawings: dict[str, str]) -> None:
    machine = load("wang2017")
    found = dict(machine.design) | {"k6": 0.0375}
    same, other = (words(page_of(machine, drawings, design=design)) for design in (dict(machine.design), found))
    assert "k6 0.031 0.03 0.04 paper" in same
    assert "k6 0.031 0.0375 0.03 0.04 paper" in other


def test_results_certificate_and_warnings_are_shown(drawings: dict[str, str]) -> None:
    text = words(page_of(load("wang2017"), drawings))
    for part in (
        "At 33.25 deg: the teeth would <have> to pull (tooth_contact_P)",
        "weight / N 97.8547",
        "centre distance quantity value unit a1 62.3311 mm",
        "variance 0.27443 N2",
        "gradient 456",
        "kkt residual 1.25e\N{MINUS SIGN}11",
        "spread \N{EN DASH}",
        "m31 upper \N{MINUS SIGN}0.3125",
        "printed model 211.25 209.5",
        "F_E N 56.6762",
        "omega dot rad/s2 0.269574",
        "seed 5",
    ):
        assert part in text
    for assumption in generated.sidecar("planting_exact")["assumptions"]:
        assert assumption in text


def test_a_simulation_has_no_certificate() -> None:
    machine = load("wang2017")
    summary = {key: value for key, value in SUMMARY.items() if key not in ("certificate", "cross", "warnings")}
    text = words(planting.render_device_page(machine, generated.sidecar("planting_exact"), summary, {}))
    assert text.count("Simulation of the planting device wang2017") == 2
    assert "Certificate" not in text
    assert "Warnings" not in text


def test_the_second_machine_has_its_page(drawings: dict[str, str]) -> None:
    assert "forward_speed_m_s \N{MINUS SIGN}0.5 m/s" in words(page_of(load("compact"), drawings))
