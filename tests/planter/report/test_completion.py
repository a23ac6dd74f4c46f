"""Completion by the shell: commands, machines, files, keys of `--set`, templates and words."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from planter.files import examples
from planter.report import completion

PROGRAM = "import sys; sys.argv[0] = 'planter'; from planter.cli import main; main()"
MACHINE = """\
speed = 3
[mass]
sun_kg = 0.4
far_kg = 1
[other]
far_kg = 2.5
text = "x"
flag = true
[bounds]
sun_kg = [0.1, 1.0]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a machine, and one in a folder below."""
    monkeypatch.chdir(tmp_path)
    for path in (tmp_path / "wide.toml", tmp_path / "own" / "crank.toml"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(MACHINE, encoding="utf-8")
    (tmp_path / "wide.csv").touch()
    return tmp_path


def complete(words: str, place: Path) -> list[str]:
    """The words by which a shell continues the last one."""
    variables = {
        "_PLANTER_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    call = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(
        call, cwd=place, env=os.environ | variables, capture_output=True, text=True, check=True
    )
    return done.stdout.split()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("planter simu", ["simulate"]),
        ("planter turn", []),
        ("planter der", ["derive"]),
        ("planter do", ["doctor"]),
        ("planter simulate w", ["wang2017", "wang2017-wide", "wide.toml"]),
        ("planter turn own/", ["own/crank.toml"]),
        ("planter simulate wide.toml --set s", ["speed=", "sun_kg="]),
        ("planter design clutch eng", ["engage"]),
        ("planter new six", ["six-bar"]),
        ("planter help m.pi", ["m.pin"]),
    ],
)
def test_shell_continues_words(words: str, expected: list[str], folder: Path) -> None:
    assert complete(words, folder) == expected


def list_changes(*words: str) -> dict[str, str]:
    """Completions of `--set` behind some words of a call."""
    context = typer.Context(typer.main.get_command(typer.Typer(callback=lambda: None)))
    context.args = list(words)
    return dict(completion.complete_changes(context))


def test_keys_of_a_file_have_their_values(folder: Path) -> None:
    """A last part that several paths share is no name, and bounds are no values."""
    assert list_changes("wide.toml") == {
        "speed=": "now 3",
        "mass.sun_kg=": "now 0.4",
        "mass.far_kg=": "now 1",
        "other.far_kg=": "now 2.5",
        "sun_kg=": "now 0.4",
    }
    assert list_changes("own/crank") == list_changes("wide.toml")


def test_every_completed_key_may_be_set() -> None:
    from planter.engine.machine import load_machine

    for key in list_changes("wang2017"):
        name = key.removesuffix("=")
        value = float(list_changes("wang2017")[key].split()[1])
        load_machine("wang2017", {name: value})


@pytest.mark.parametrize("source", ["nothing", "no\0file", "wide.csv"])
def test_no_machine_has_no_keys(source: str, folder: Path) -> None:
    assert list_changes(source) == list_changes() == {}


def test_files_are_found_by_suffix_below_their_folder(folder: Path) -> None:
    assert completion.complete_files(".csv", ".toml")("wi") == ["wide.csv", "wide.toml"]
    assert completion.complete_files(".toml")("") == ["own/crank.toml", "wide.toml"]
    assert completion.complete_files(".toml")(f"{folder}/own/c") == [f"{folder}/own/crank.toml"]
    assert completion.complete_files(".toml")("nowhere/") == []
    assert completion.complete_files(".toml")("[") == []


def test_files_of_one_package_are_offered() -> None:
    assert set(completion.complete_sources("clutch")("")) >= {"shi2021"}
    assert "wang2017" not in completion.complete_sources("clutch")("")
    assert set(completion.complete_machines("")) >= set(examples.list_examples(suffix=".toml"))
