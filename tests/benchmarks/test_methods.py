"""The table of methods: its page holds the record, its rows measure what they say."""

from __future__ import annotations

import copy
import json

import pytest

from tests.benchmarks import methods

RECORD = json.loads(methods.RECORD.read_text("utf-8"))


def test_page_holds_the_table_of_methods() -> None:
    page = methods.PAGE.read_text("utf-8")
    assert methods.fill_page(page, RECORD) == page
    for key, value in (("objective", 1.0), ("agreeing_starts", 99), ("cpu_s", 1e3)):
        tampered = copy.deepcopy(RECORD)
        tampered["rows"][0][key] += value
        assert methods.fill_page(page, tampered) != page


def test_rows_that_the_record_lacks_are_said() -> None:
    names = [case.name for case in methods.list_cases()]
    listed = [(name, method) for name in names for method in methods.METHODS]
    rows = [(row["problem"], row["method"]) for row in RECORD["rows"]]
    assert rows == listed[: len(rows)]
    text = methods.render_page(RECORD | {"rows": RECORD["rows"][:1]})
    assert all(f"{name} ({method})" in text for name, method in listed[1:])


def test_worse_objective_is_not_called_best() -> None:
    record = copy.deepcopy(RECORD)
    record["rows"][1]["objective"] = 1.25 * record["rows"][0]["objective"]
    (line,) = [line for line in methods.render_page(record).splitlines() if "| ga |" in line][:1]
    assert "25 %" in line


def test_local_searches_of_the_paper_reach_the_recorded_optimum() -> None:
    (recorded,) = [row for row in RECORD["rows"] if (row["problem"], row["method"]) == FIRST]
    row = methods.measure_method(methods.list_cases()[0], "ipopt", 1)
    assert row["objective"] == pytest.approx(recorded["objective"], rel=1e-9)
    assert row["cpu_s"] > 0


FIRST = ("wang2017, bounds of the paper", "ipopt")
