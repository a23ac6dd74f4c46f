"""Figures of README and documentation are those that commands print."""

from __future__ import annotations

import pytest

from tests.support import figures
from tests.support.structure import ROOT

PAGES = [page["name"] for page in figures.listed()["page"]]
WHOLE = [page["name"] for page in figures.listed()["page"] if page.get("whole")]
SLOW = figures.listed()["slow"]


@pytest.mark.parametrize("page", PAGES)
def test_pages_have_the_recorded_figures(page: str) -> None:
    assert figures.renewed(page, figures.read_saved()) == (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.parametrize("page", WHOLE)
def test_every_figure_of_a_page_has_a_record(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    assert figures.loose(page, text) == []
    assert figures.loose(page, text + "\nIt is 12.5 N better.\n") == ["It is 12.5 N better."]


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(name, marks=[pytest.mark.long] * (name in SLOW))
        for name in figures.listed()["commands"]
    ],
)
def test_records_equal_command_output(command: str) -> None:
    values = figures.read_saved()
    for path, value in figures.measured(command).items():
        field = figures.fields()[path]
        assert field.format_values({path: value}) == field.format_values(values), path


def test_changed_figures_are_noticed() -> None:
    sentence = figures.Sentence.parse(
        "page", "a range of {exact.range_N:.1f} N and {exact.force:.0f} N"
    )
    text = "It has a range of\n3.1 N and 98 N."
    values = {"exact.range_N": 3.12, "exact.force": 97.9}
    assert sentence.renewed(text, values) == text
    assert sentence.renewed(text.replace("3.1", "3.0"), values) == text
    with pytest.raises(LookupError, match="page lacks"):
        sentence.find(text.replace("range", "width"))
