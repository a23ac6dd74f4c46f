"""The audit's page and its typesetting: all that was found stands on it, well formed, escaped and
readable.
"""

from __future__ import annotations

import copy
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from planter.audit import verdicts
from planter.audit.equation_page import CLASS, EquationArticle, describe_fault, mark_changes
from planter.audit.presentation import present_audit
from planter.kernels import generated
from planter.report.html import typeset_numbers
from tests.support.cli import below

run, answer, _ = below("audit")


@pytest.fixture(scope="module")
def audit() -> dict[str, Any]:
    return answer()


def tree(text: str) -> ET.Element:
    return ET.fromstring(text.removeprefix("<!DOCTYPE html>\n"))


def typeset_text(text: str) -> str:
    """Return a text as pages show it."""
    return unescape(typeset_numbers(text))


def test_the_folder_holds_summary_and_page(tmp_path: Path, audit: dict[str, Any]) -> None:
    code, _, err = run("--out", str(tmp_path / "there"))
    assert code == 0, err
    summary = json.loads((tmp_path / "there" / "summary.json").read_text(encoding="utf-8"))
    assert {key: summary[key] for key in audit} == audit
    text = (tmp_path / "there" / "report.html").read_text(encoding="utf-8")
    root = tree(text)
    assert not re.search(r"<script|<link|src=|url\(|http://", text)
    assert len(list(root.iter("math"))) > len(audit["equations"])
    page_text = " ".join(" ".join(root.itertext()).split())
    for entry in audit["equations"]:
        for part in ("terms", "unexplained", "vanishing"):
            assert all(term["term"] in page_text for term in entry[part])
        assert not entry["printed"] or entry["printed"] in page_text
        assert not entry["derived"] or entry["derived"] in page_text
    assert all(typeset_text(entry["claim"]) in page_text for entry in audit["claims"])
    for entry in (*audit["consequences"], *audit["numbers"]):
        assert typeset_text(entry["quantity"]) in page_text


def test_texts_on_the_page_are_escaped() -> None:
    result = copy.deepcopy(verdicts.audit("yu2023"))
    result["equations"][0] |= {
        "printed": "</p><script>x</script> = 0",
        "verdict": "misprint",
        "finding": "a < b & c",
    }
    text = present_audit(result, generated.sidecar("audit_mathml")).page({})
    tree(text)
    assert "<script" not in text


def test_conclusion_counts_faults_among_the_judged() -> None:
    """An equation that nobody judged is not one without a fault."""
    result = copy.deepcopy(verdicts.audit("yu2023"))
    (counts,) = result["summary"].values()
    total = sum(counts["equations"].values())
    counts["equations"] = {"not judged": 5, "confirmed": total - 5}
    page = present_audit(result, generated.sidecar("audit_mathml"))
    assert f"{counts['at_fault']} of {total - 5} printed equations are at fault" in page.conclusion
    assert f"5 of {total} are not judged" in page.conclusion
    counts["equations"] = {"not judged": total}
    page = present_audit(result, generated.sidecar("audit_mathml"))
    assert "at fault" not in page.conclusion


def test_equation_article_shows_all_findings() -> None:
    term = {"term": "m*g", "max_abs": 2.5, "unit": "N", "share_of_largest": 0.25}
    entry = {
        "paper": "p",
        "equation": "1'",
        "claims": "x < y",
        "legibility": "printed",
        "verdict": "contradicted",
        "grade": "at fault",
        "finding": "printed, but not derived: q",
        "correction": ["sign of F_A", "b for a"],
        "reading": "psi read as phi",
        "terms": [term, {**term, "term": "k*x", "share_of_largest": None, "max_abs": None}],
        "unexplained": [{**term, "term": "q"}],
        "printed": "F_A + q = 0",
        "derived": "F_A - m*g = 0",
        "defines": "F_A",
        "vanishing": [
            {"term": "m*phi_ddot", "because": "phi_ddot = 0: constant speed", "printed": False}
        ],
    }
    math = {
        "printed": "<math>p</math>",
        "derived": "<math>d</math>",
        "finding": "printed: <math>q</math>",
        "correction": ["sign of F", "b for a"],
        "reading": "psi read as phi",
        "terms": ["<math>mg</math>", "<math>kx</math>"],
        "unexplained": ["<math>q</math>"],
        "vanishing": [{"term": "<math>mf</math>", "because": "f = 0: constant speed"}],
    }
    root = ET.fromstring(EquationArticle(entry, math).html("s1"))
    assert ["".join(node.itertext()) for node in root.iter("math")] == [
        "p",
        "d",
        "q",
        "mg",
        "kx",
        "q",
        "mf",
    ]
    page_text = " ".join(" ".join(root.itertext()).split())
    for text in ("x < y", "no real value", "25 %", "; or ", "constant speed", "Read so:"):
        assert text in page_text
    assert root.get("class") == "contradicted"
    assert " " not in root.get("id", " ")


def test_a_remark_names_correction_and_largest_term() -> None:
    entry = {
        "verdict": "incomplete",
        "finding": "f",
        "correction": ["c"],
        "terms": [
            {"term": "small", "share_of_largest": 0.1},
            {"term": "big", "share_of_largest": 0.4},
        ],
    }
    assert (
        describe_fault(entry) == "correct c; 2 terms missing, such as big, 40 % of the largest term"
    )


CORRECTED = [
    (paper, number, entry["printed"], entry["corrected"])
    for paper, entries in generated.sidecar("audit_mathml").items()
    for number, entry in entries.items()
    if entry.get("corrected")
]


def list_unmarked(tree: ET.Element) -> Iterator[str]:
    if tree.get("class") == CLASS or tree.tag == "annotation":
        return
    if not len(tree):
        yield tree.text or ""
    for child in tree:
        yield from list_unmarked(child)


@pytest.mark.parametrize(("paper", "number", "printed", "corrected"), CORRECTED)
def test_marked_is_what_differs(paper: str, number: str, printed: str, corrected: str) -> None:
    marked = mark_changes(printed, corrected)
    for before, after in zip((printed, corrected), marked, strict=True):
        assert ET.canonicalize(re.sub(f' class="{CLASS}"', "", after)) == ET.canonicalize(before)
    first, second = (list(list_unmarked(ET.fromstring(text))) for text in marked)
    assert first == second
    assert any(CLASS in text for text in marked), f"{paper} ({number}) has nothing to correct"


def test_marks_are_small() -> None:
    """Of most prints a part stands."""
    left = [
        list(list_unmarked(ET.fromstring(mark_changes(*formulas)[0])))
        for _, _, *formulas in CORRECTED
    ]
    assert sum(map(bool, left)) >= len(left) - 2


def test_corrections_of_most_misprints_are_typeset() -> None:
    typeset = generated.sidecar("audit_mathml")
    misprints = [e for e in generated.sidecar("audit")["equations"] if e["verdict"] == "misprint"]
    without = [
        e["equation"] for e in misprints if not typeset[e["paper"]][e["equation"]]["corrected"]
    ]
    assert len(without) <= 1, without
