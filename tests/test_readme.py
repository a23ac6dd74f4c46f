"""README.md, its Chinese version and the pages of questions: short, with pictures that commands draw
and lines that print what they say.
"""

import doctest
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.support.pictures import FOLDER, PICTURES, SMALL, draw_picture
from tests.support.structure import ROOT

TEXT, CHINESE = (
    (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "README.zh-CN.md")
)
USE, TRIAL, INDEX, DEVICE = (
    (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    for name in ("use", "verdicts", "index", "device")
)
OTHERS = {"notebook.png", "front.png", "experiment.png"}
"""Pictures of a notebook in a browser, and of docs/studies, which no command draws."""
PICTURE = re.compile(r"!\[[^\]]*\]\((?:docs/)?([\w./]+\.(?:png|gif))\)")
MOST_WORDS = 500
QUICK = ("pictures/symbols.png", "support_force.png")
LINK = re.compile(r"\]\(([^)#:]+)[^)]*\)")


def difference(path: Path, reference: Path) -> float:
    """Mean difference of two pictures of one size, of 255; infinite for other sizes."""
    with Image.open(path) as first, Image.open(reference) as second:
        if first.size != second.size:
            return float("inf")
        arrays = [np.asarray(image.convert("RGB"), dtype=float) for image in (first, second)]
    return float(np.abs(arrays[0] - arrays[1]).mean())


def failures(text: str) -> int:
    """Examples of a text whose output is not the one that stands below them."""
    test = doctest.DocTestParser().get_doctest(text, {}, "README.md", "README.md", 0)
    assert test.examples
    return doctest.DocTestRunner(verbose=False).run(test, out=lambda _: None).failed


def test_pictures_are_those_that_commands_draw() -> None:
    names = set(PICTURE.findall(TEXT + CHINESE + USE + INDEX + DEVICE)) - OTHERS
    small = {f"{SMALL}{path.name}" for path in (FOLDER / SMALL).iterdir()}
    assert small == {name for name in PICTURES if name.startswith(SMALL)}
    assert names == set(PICTURES)
    assert sum((FOLDER / name).stat().st_size for name in names) < 1_000_000


def test_first_page_is_short() -> None:
    assert len(TEXT.split()) <= MOST_WORDS
    assert len(PICTURE.findall(TEXT)) == len(PICTURE.findall(CHINESE)) == 1
    commands = [line for line in TEXT.splitlines() if line.startswith("    planter ")]
    assert commands
    assert all(line.split("#")[0].strip() in CHINESE for line in commands)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.long] * (name not in QUICK)) for name in PICTURES],
)
def test_picture_equals_command_output(name: str, tmp_path: Path) -> None:
    assert difference(draw_picture(name, tmp_path), FOLDER / name) < 2
    other = "support_force.png" if name != "support_force.png" else "front.png"
    assert difference(FOLDER / name, FOLDER / other) > 2


def test_first_lines_print_shown_output() -> None:
    assert failures(USE) == 0
    assert failures(USE.replace("range 3.13 N", "range 3.14 N")) == 1


def test_chinese_version_has_the_same_code_and_commands() -> None:
    """Its lines of code, and commands, are those of the English one, which runs; its links lead
    somewhere.
    """
    lines = [
        line.partition("#")[0].rstrip() for line in CHINESE.splitlines() if line.startswith("    ")
    ]
    assert set(lines) <= {line.partition("#")[0].rstrip() for line in TEXT.splitlines()}
    commands = set(re.findall(r"`(planter [^`]+)`", CHINESE))
    assert commands
    assert commands <= set(re.findall(r"`(planter [^`]+)`", TEXT))
    for text in (TEXT, CHINESE):
        assert all((ROOT / link).exists() for link in LINK.findall(text))


def test_paper_table_equals_audit() -> None:
    page = (ROOT / "generated" / "AUDIT.md").read_text(encoding="utf-8").split("\n## ")[0]
    rows = [line for line in page.splitlines() if line.startswith("| ")]
    assert len(rows) == 5
    words = " ".join(TRIAL.split())
    assert all(" ".join(row.split()) in words for row in rows)
