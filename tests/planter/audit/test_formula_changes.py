"""Marks of changes in formulas: what is not marked is the same, and nothing else changes."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator

import pytest

from planter.audit.equation_page import CLASS, mark_changes
from planter.kernels import generated

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


def test_equal_formulas_have_no_marks() -> None:
    _, _, printed, _ = CORRECTED[0]
    assert not any(CLASS in text for text in mark_changes(printed, printed))


def test_corrections_of_most_misprints_are_typeset() -> None:
    typeset = generated.sidecar("audit_mathml")
    misprints = [e for e in generated.sidecar("audit")["equations"] if e["verdict"] == "misprint"]
    without = [
        e["equation"] for e in misprints if not typeset[e["paper"]][e["equation"]]["corrected"]
    ]
    assert len(without) <= 1, without
