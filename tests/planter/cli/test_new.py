"""`planter new`: each template in an empty folder, and the commands that it says to type next."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest

from planter.cli.templates import TEMPLATES
from planter.files import documents
from tests.support.cli import answer, refusal, run

SHORTENED = {"planter optimise": ("--method", "ipopt", "--starts", "1")}
"""Options that spare time, by the beginning of a command."""
QUICK = {"planting-device", "poses", "clutch", "slider-crank", "pendulum"}
"""Templates whose first commands the suite runs, one of each kind."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def follow(step: str) -> tuple[int, str, str]:
    """What a command prints that a template says to type."""
    words = shlex.split(step)
    more = next((m for start, m in SHORTENED.items() if step.startswith(start)), ())
    return run(*words[1:], *more)


def test_templates_are_listed() -> None:
    listed = answer("new")["templates"]
    assert listed.keys() == TEMPLATES.keys()
    assert len(listed) == len(set(listed.values())) == 15


@pytest.mark.parametrize("name", TEMPLATES)
def test_template_has_comments_and_existing_commands(name: str, folder: Path) -> None:
    result = answer("new", name)
    assert set(result["files"]) == {path.name for path in folder.iterdir()}
    text = Path(result["files"][0]).read_text(encoding="utf-8")
    assert text.startswith(("#", '"""', "\\documentclass"))
    assert result["next"]
    for step in result["next"]:
        words = shlex.split(step)
        assert words[0] == "planter"
        assert run(words[1], "--help")[0] == 0
    assert any(result["files"][0] in step for step in result["next"])


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.long) for name in TEMPLATES],
)
def test_next_commands_run(name: str) -> None:
    steps = answer("new", name)["next"]
    for step in steps[:2] if name in QUICK else steps:
        code, out, err = follow(step)
        assert code == 0, (step, err)
        assert out
    if name == "measured-curve":
        fitted = {
            row["name"]: row["interval"] for row in answer(*shlex.split(steps[0])[1:])["fitted"]
        }
        low, high = fitted["mass.planet_kg"]
        assert low <= 1.29 <= high


def test_command_that_fails_is_detected() -> None:
    assert follow("planter simulate nothing.toml --out run")[0] == 2


@pytest.mark.parametrize("name", ["slider-crank", "paper", "clutch"])
def test_existing_file_is_never_overwritten(name: str, folder: Path) -> None:
    """Neither the file nor one that it needs; then nothing is written at all."""
    for existing in answer("new", name)["files"]:
        for path in folder.iterdir():
            path.unlink()
        Path(existing).write_text("mine", encoding="utf-8")
        assert "this file exists, and it is not overwritten" in refusal("new", name)
        assert [path.name for path in folder.iterdir()] == [existing]
        assert Path(existing).read_text(encoding="utf-8") == "mine"


@pytest.mark.skipif(os.name == "nt", reason="links need a privilege there")
def test_dangling_link_is_not_followed(folder: Path) -> None:
    Path("clutch.toml").symlink_to(folder / "elsewhere.toml")
    assert "not overwritten" in refusal("new clutch")
    assert not (folder / "elsewhere.toml").exists()


def test_file_may_lie_in_a_new_folder_with_spaces() -> None:
    result = answer("new", "paper", "my papers/mine.tex")
    assert Path("my papers", "slider_crank.py").is_file()
    words = shlex.split(result["next"][0])
    assert words[2:5] == ["my papers/mine.tex", "--against", "my papers/slider_crank.py"]


def test_wrong_names_are_refused() -> None:
    assert "did you mean cam?" in refusal("new cams")
    assert "FILE = x.toml: its name must end in .py" in refusal("new cam x.toml")


def test_built_in_template_is_the_example() -> None:
    answer("new clutch")
    assert Path("clutch.toml").read_text(encoding="utf-8") == answer("example shi2021")["text"]


def test_statement_s_name_is_that_of_its_commands() -> None:
    for name, template in TEMPLATES.items():
        if template.name.endswith(".py"):
            stem = template.source.removesuffix(".py")
            assert f'"{stem}"' in documents.read_statement(template.source), name
