"""The audit's page and its typesetting: all that was found stands on it, well formed, escaped and readable."""

from __future__ import annotations

import copy
import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest

from planter.audit import article, markup, page, tables, typeset, verdicts
from tests.support.cli import below

run, answer, _ = below("audit")


@pytest.fixture(scope="module")
def whole() -> dict[str, Any]:
    return answer()


def tree(text: str) -> ET.Element:
    return ET.fromstring(text.removeprefix("<!DOCTYPE html>\n"))


def test_the_folder_holds_summary_and_page(tmp_path: Path, whole: dict[str, Any]) -> None:
    code, _, err = run("--out", str(tmp_path / "there"))
    assert code == 0, err
    summary = json.loads((tmp_path / "there" / "summary.json").read_text(encoding="utf-8"))
    assert {key: summary[key] for key in whole} == whole
    text = (tmp_path / "there" / "report.html").read_text(encoding="utf-8")
    root = tree(text)
    assert not re.search(r"<script|<link|src=|url\(|http://", text)
    assert len(list(root.iter("math"))) > len(whole["equations"])
    shown = " ".join(" ".join(root.itertext()).split())
    for entry in whole["equations"]:
        for part in ("terms", "unexplained", "vanishing"):
            assert all(term["term"] in shown for term in entry[part])
        assert not entry["printed"] or entry["printed"] in shown
        assert not entry["derived"] or entry["derived"] in shown
    assert all(entry["claim"] in shown for entry in whole["claims"])
    assert all(entry["quantity"] in shown and entry["statement"] in shown for entry in whole["consequences"])
    assert all(entry["quantity"] in shown for entry in whole["numbers"])


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    code, out, err = run("yu2023", "--out", str(tmp_path / "file" / "there"))
    assert (code, out, err.count("\n")) == (2, "", 1)


def test_texts_on_the_page_are_escaped() -> None:
    result = copy.deepcopy(verdicts.audit("yu2023"))
    result["equations"][0] |= {"printed": "</p><script>x</script> = 0", "verdict": "misprint", "finding": "a < b & c"}
    text = page.html(result)
    tree(text)
    assert "<script" not in text


def test_every_committed_equation_and_term_can_be_set(whole: dict[str, Any]) -> None:
    for entry in whole["equations"]:
        for text in (entry["printed"], entry["derived"]):
            if text:
                element = typeset.equation(text, True, entry["defines"])
                assert element is not None, text
                ET.fromstring(element)
        for part in ("terms", "unexplained", "vanishing"):
            assert all(typeset.term(term["term"]) for term in entry[part])


def texts(element: str | None) -> str:
    assert element is not None
    return "".join(ET.fromstring(element).itertext())


@pytest.mark.parametrize(
    ("text", "defines", "shown"),
    [
        ("mu - a*b = 0", "mu", "mu=a\N{INVISIBLE TIMES}b"),
        ("-a*b + mu = 0", "mu", "mu=a\N{INVISIBLE TIMES}b"),
        ("-c + a - b = 0", "c", "c=a\N{MINUS SIGN}b"),
        ("-c - a + b = 0", "c", "c=b\N{MINUS SIGN}a"),
        ("a*b - c*d + e = 0", "", "e=c\N{INVISIBLE TIMES}d\N{MINUS SIGN}a\N{INVISIBLE TIMES}b"),
        ("a + b = 0", "", "a+b=0"),
        ("a - b*c >= 0", "a", "a\N{MINUS SIGN}b\N{INVISIBLE TIMES}c\N{GREATER-THAN OR EQUAL TO}0"),
    ],
)
def test_an_equation_is_solved_for_what_it_defines(text: str, defines: str, shown: str) -> None:
    assert texts(typeset.equation(text, True, defines)).replace("\N{GREEK SMALL LETTER MU}", "mu") == shown


def test_a_long_sum_is_broken_before_its_signs_and_loses_nothing() -> None:
    terms = [f"a{i}*b{i}" for i in range(60)]
    text = " - ".join(terms) + " = 0"
    element = typeset.equation(text)
    rows = list(ET.fromstring(element or "").iter("mtr"))
    assert len(rows) > 2
    assert all("".join(row.itertext()).startswith("\N{MINUS SIGN}") for row in rows[1:])
    assert texts(element) == texts(typeset.equation(text.replace(" - ", "-")))
    assert [f"a{i}\N{INVISIBLE TIMES}b{i}" in texts(element) for i in range(60)] == [True] * 60


def test_an_equation_on_trial_shows_all_that_was_found() -> None:
    term = {"term": "m*g", "max_abs": 2.5, "unit": "N", "share_of_largest": 0.25}
    entry = {
        "paper": "p", "equation": "1'", "claims": "x < y", "legibility": "printed", "verdict": "contradicted",
        "finding": "printed, but not derived: q", "correction": ["sign of F_A", "b for a"],
        "reading": "psi read as phi",
        "terms": [term, {**term, "term": "k*x", "share_of_largest": None, "max_abs": None}],
        "unexplained": [{**term, "term": "q"}], "printed": "F_A + q = 0", "derived": "F_A - m*g = 0", "defines": "F_A",
        "vanishing": [{"term": "m*phi_ddot", "because": "phi_ddot = 0: constant speed", "printed": False}],
    }  # fmt: skip
    root = ET.fromstring(article.trial(entry))
    notes = [node.text for node in root.iter("annotation")]
    assert notes[:2] == ["F_A + q = 0", "F_A - m*g = 0"]
    assert {"m*g", "k*x", "q", "m*phi_ddot"} <= set(notes)
    shown = " ".join(" ".join(root.itertext()).split())
    for text in ("x < y", "no real value", "25 %", "; or ", "constant speed", "Read so:"):
        assert text in shown
    assert root.get("class") == "contradicted"
    assert " " not in root.get("id", " ")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("-a*(b - c)", "\N{MINUS SIGN}a\N{INVISIBLE TIMES}(b\N{MINUS SIGN}c)"),
        ("a - (b - c)", "a\N{MINUS SIGN}(b\N{MINUS SIGN}c)"),
        ("a*(-b)", "a\N{INVISIBLE TIMES}(\N{MINUS SIGN}b)"),
        ("(a + b)**2", "(a+b)2"),
        ("(a*b)**2", "(a\N{INVISIBLE TIMES}b)2"),
        ("-(a + b)", "\N{MINUS SIGN}(a+b)"),
        ("cos(a)*b", "cos\N{FUNCTION APPLICATION}(a)\N{INVISIBLE TIMES}b"),
        ("Abs(y)", "|y|"),
    ],
)
def test_brackets_stand_where_they_must(text: str, shown: str) -> None:
    assert "".join(ET.fromstring(typeset.expression(text)).itertext()) == shown


def test_what_cannot_be_set_stays_text() -> None:
    for text in ("no relation", "a[0] = 0", "lambda: 0 = 0", "x ; y = 0"):
        assert typeset.equation(text) is None
    assert "<code>a[0] = 0</code>" in markup.equation("a[0] = 0")


def test_a_remark_names_correction_and_largest_term() -> None:
    entry = {"verdict": "incomplete", "finding": "f", "correction": ["c"], "terms": [
        {"term": "small", "share_of_largest": 0.1}, {"term": "big", "share_of_largest": 0.4}]}  # fmt: skip
    assert tables.remark(entry) == "correct c; 2 terms missing, such as big, 40 % of the largest term"
