"""A text on trial from its own LaTeX: rows, names, corrections at their lines, and errors in the
files.
"""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from planter.audit.equation_page import list_changes
from tests.support import own
from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema

TEXT = (own.EXAMPLES / "slider_crank_text.tex").read_text(encoding="utf-8")
NAMES = (own.EXAMPLES / "slider_crank_text.names.toml").read_text(encoding="utf-8")
"""What docs/text.md shows."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("text")
    shutil.copy(own.EXAMPLES / "slider_crank.py", place)
    (place / "crank.tex").write_text(TEXT, encoding="utf-8")
    (place / "complete.toml").write_text(NAMES, encoding="utf-8")
    return place


def audit(folder: Path, *options: str) -> Any:
    return answer(
        "audit", str(folder / "crank.tex"), "--against", str(folder / "slider_crank.py"), *options
    )


@pytest.fixture(scope="module")
def result(folder: Path) -> Any:
    return audit(folder, "--names", str(folder / "complete.toml"), "--out", str(folder / "trial"))


def line_of(words: str) -> int:
    return TEXT[: TEXT.index(words)].count("\n") + 1


def test_each_row_is_read_or_refused_at_its_line(result: Any) -> None:
    jsonschema.validate(result, load_schema("audit"))
    starts = [r"s &= r", r"r\sin", r"\dot s &=", r"l\dot\beta\cos", "T &=", "F_1 ="]
    assert [row["line"] for row in result["rows"]] == [line_of(start) for start in starts]
    assert [row["status"] for row in result["rows"]] == ["read"] * 5 + ["refused"]
    assert [bool(row["reason"]) for row in result["rows"]] == [False] * 5 + [True]


def test_wrong_sign_is_corrected_in_the_source(result: Any) -> None:
    verdicts = {e["equation"]: e["verdict"] for e in result["equations"]}
    assert verdicts == {
        "eq:s": "confirmed",
        "2": "confirmed",
        "eq:v": "misprint",
        "4": "confirmed",
        "7": "confirmed",
    }
    (wrong,) = [e for e in result["equations"] if e["corrected_latex"]]
    assert (wrong["equation"], wrong["file"], wrong["line"]) == (
        "eq:v",
        "crank.tex",
        line_of(r"\dot s &="),
    )
    changes = [
        (mark, text)
        for mark, text in list_changes(wrong["latex"], wrong["corrected_latex"])
        if mark != " "
    ]
    assert changes == [("-", "+"), ("+", "-")]
    assert wrong["latex"] in TEXT


def test_correction_is_marked_on_the_page(folder: Path, result: Any) -> None:
    page = (folder / "trial" / "report.html").read_text(encoding="utf-8")
    assert r"\varphi <del>+</del><ins>-</ins> l\dot" in page
    line = line_of(r"\dot s &=")
    assert f"crank.tex, line {line}" in page


def test_skeleton_lists_names_and_is_never_replaced(folder: Path) -> None:
    text = audit(folder)
    skeleton = folder / "crank.names.toml"
    names = tomllib.loads(skeleton.read_text(encoding="utf-8"))["names"]
    assert names[r"\varphi"] == names[r"\phi"] == "phi"
    assert names["T"] == names["v_{C}"] == ""
    assert [row["status"] for row in text["rows"]] == ["read"] * 5 + ["refused"]
    unjudged = {
        e["equation"]: e["finding"] for e in text["equations"] if e["verdict"] == "not judged"
    }
    assert unjudged.keys() == {"7"}
    assert "T" in unjudged["7"]
    skeleton.write_text("# mine\n", encoding="utf-8")
    audit(folder)
    assert skeleton.read_text(encoding="utf-8") == "# mine\n"


def test_error_in_a_names_file_is_one_sentence(folder: Path) -> None:
    names = folder / "wrong.toml"
    names.write_text("[names]\n'T' = \"kinetc()\"\n", encoding="utf-8")
    options = ("--against", str(folder / "slider_crank.py"), "--names", str(names))
    message = refusal("audit", str(folder / "crank.tex"), *options)
    assert "wrong.toml" in message
    assert "kinetc" in message


def test_options_that_do_not_fit_are_refused(folder: Path) -> None:
    assert "--against" in refusal("audit", str(folder / "crank.tex"))
    assert "--against" in refusal("audit wang2017 --against", str(folder / "slider_crank.py"))
    assert "nothing.tex" in refusal("audit nothing.tex --against", str(folder / "slider_crank.py"))


def test_notebook_rows_have_lines_of_the_file(folder: Path) -> None:
    cells = [
        {
            "cell_type": "markdown",
            "metadata": {},
            "source": ["The slider is at\n", "$$s = r\\cos\\phi + l\\cos\\beta$$\n"],
        },
        {
            "cell_type": "code",
            "metadata": {},
            "source": ["a = '$$s = r$$'"],
            "outputs": [],
            "execution_count": None,
        },
    ]
    notebook = folder / "crank.ipynb"
    notebook.write_text(
        json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}, indent=1),
        "utf-8",
    )
    (row,) = answer(f"audit {notebook} --against", str(folder / "slider_crank.py"))["rows"]
    lines = notebook.read_text(encoding="utf-8").splitlines()
    assert "$$s = r" in lines[row["line"] - 1]
    assert row["status"] == "read"
