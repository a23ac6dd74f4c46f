"""What pages tell to type can be typed: commands run in turn in an empty folder, tables of files
are read.
"""

from __future__ import annotations

import re
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.cli import run
from tests.support.structure import ROOT

DOCS = ROOT / "docs"
PAGES = sorted([ROOT / "README.md", *DOCS.glob("*.md")])
LONGER = (
    "--prove",
    "--front",
    "--lift",
    "--step",
    "--cluster",
    "hybrid",
    "optimise wang2017-wide",
    "contact",
    "animate",
    "bench",
    "calibrate",
    "compare",
    "drive",
    "export",
    "gears",
    "optimise own",
    "studio",
    "sweep",
    "tolerance",
)
"""What takes minutes, or never ends, and what goes on from there; tests of their own run these."""


def typed(text: str) -> Iterator[tuple[list[str], str | None]]:
    """Calls of a page's indented blocks as words, each with the file that its output goes into."""
    for line in text.splitlines():
        if re.match(r" {4}planter [a-z]", line):
            call, _, target = line.partition("#")[0].partition(">")
            yield re.findall(r'"[^"]*"|\S+', call)[1:], target.strip() or None


def tables(text: str) -> Iterator[str]:
    """Indented blocks that are parts of a machine's file."""
    for block in text.split("\n\n"):
        if re.match(r" {4}(\[\w+\]|\w+ = [\[\d\"-])", block):
            yield "\n".join(line.removeprefix("    ") for line in block.strip("\n").splitlines())


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_commands_on_pages_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(DOCS / "examples", tmp_path / "docs" / "examples")
    monkeypatch.chdir(tmp_path)
    left = set(LONGER)
    for words, target in typed(page.read_text(encoding="utf-8")):
        if any(part in " ".join(words) for part in left):
            left |= {f"{words[words.index('--out') + 1]}/"} if "--out" in words else set()
            continue
        code, out, err = run(*(word.strip('"') for word in words))
        assert code == 0, (words, err)
        if target is not None:
            Path(target).write_text(out, encoding="utf-8")


def test_tables_on_pages_are_read() -> None:
    blocks = [block for page in PAGES for block in tables(page.read_text(encoding="utf-8"))]
    assert blocks
    for block in blocks:
        assert tomllib.loads(block)


def test_calls_and_tables_are_recognised() -> None:
    text = (
        'Take\n\n    planter example a > b.toml   # one\n    planter turn b --least "range '
        'F"\n\n    [law]\n    p = 1\n'
    )
    assert list(typed(text)) == [
        (["example", "a"], "b.toml"),
        (["turn", "b", "--least", '"range F"'], None),
    ]
    assert list(tables(text)) == ["[law]\np = 1"]
