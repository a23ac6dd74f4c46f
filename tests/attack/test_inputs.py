"""What no file should be: nested without end, a device, a pipe without a writer; every command
refuses it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from planter import text_files
from planter.errors import InputError
from tests.support.cli import run

TAKERS = (
    "animate",
    "audit",
    "calibrate",
    "calibrate wang2017 --data",
    "cam",
    "design clutch engage",
    "design clutch field",
    "design clutch geometry",
    "optimise --all-pairs",
    "derive",
    "simulate --motor",
    "about explain",
    "export motion",
    "gears",
    "gears --curve",
    "optimise",
    "design pickup",
    "sensitivity",
    "simulate",
    "studio --static page.html",
    "sweep",
    "design synthesise",
    "tolerance",
    "design train",
    "simulate --check",
)
"""Commands that take a file, which follows."""
TEXTS = {
    "dots": "a" + ".a" * 3000 + " = 1\n",
    "brackets": "a = " + "[" * 2000,
    "values": "a = 1\n" * 60_000,
}
posix = pytest.mark.skipif(os.name != "posix", reason="no pipes with names and no /dev/zero here")


def make_text(path: Path) -> None:
    path.write_text(TEXTS["dots"])


def make_device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def make_pipe(path: Path) -> None:
    os.mkfifo(path)


@posix
@pytest.mark.parametrize(
    ("command", "make"),
    [
        (command, make)
        for command in TAKERS
        for make in (make_text, make_device, make_pipe)
        if not (
            command in ("audit", "derive") and make is make_text
        )  # that is a Python file, and run as one
    ],
)
def test_invalid_file_is_refused(
    command: str, make: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    make(tmp_path / "own.toml")
    code, out, err = run(*command.split(), "own.toml", "--json")
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("planter: ")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["own.toml"]


@pytest.mark.parametrize("name", ["sweep", "tolerance"])
def test_the_machine_of_a_plan_is_read_with_limits(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("own.toml").write_text('functions = "x"\n' + TEXTS["dots"])
    Path("plan.toml").write_text(
        'machine = "own.toml"\npoints = 4\noutputs = ["range_N"]\n[inputs]\nspeed_rpm = [30, 40]\n'
        if name == "sweep"
        else "[tolerances]\nspeed_rpm = 1\n"
    )
    code, _, err = run(*(["sweep", "plan.toml"] if name == "sweep" else ["tolerance", "own.toml"]))
    assert code == 2
    assert "Traceback" not in err


@pytest.mark.parametrize("content", TEXTS.values(), ids=TEXTS.keys())
def test_no_parser_gets_too_deep_or_too_large_text(content: str) -> None:
    for parse in (text_files.parse_toml, text_files.parse_json):
        with pytest.raises(InputError, match=r"own: .*(nested|too many)|valid JSON"):
            parse(content, "own")


@pytest.mark.parametrize(
    "message",
    [
        "",
        "[]",
        "3",
        "{",
        '{"a": 1e999}',
        '{"a": NaN}',
        '{"a": "\\u0000"}',
        '{"a": "\\ud800"}',
        '{"\\udfff": 1}',
        '{"a": ' + "[" * 3000,
        '{"a": ' + "9" * 5000 + "}",
        '{"a": 18446744073709551616}',
        '{"a": "\x00"}',
        "\ud800",
        '{"a": [' + "1," * 60_000 + "1]}",
        '{"' + "a" * 300 + '": 1}',
        " " * 1_000_001,
    ],
)
def test_no_json_input_is_unusable(message: str) -> None:
    with pytest.raises(InputError):
        text_files.parse_json(message, "the message")


def test_json_comes_in_whole() -> None:
    table = {"ask": "open", "text": "a = 'é'\n\t", "values": {"x": 1.5, "y": [None, True, -3]}}
    assert text_files.parse_json(json.dumps(table), "the message") == table


@pytest.mark.parametrize("words", [["x" * 20_000], ["--set"] * 20_000])
def test_nonsense_command_line_is_refused(words: list[str]) -> None:
    with pytest.raises(InputError):
        text_files.check_arguments(words)


@posix
def test_a_pipe_in_place_of_a_file_makes_nobody_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes the file's place between the look at it and the opening."""
    os.mkfifo(tmp_path / "own.toml")
    monkeypatch.setattr(text_files, "check_regular", lambda path: None)
    with pytest.raises(InputError, match="pipe"):
        text_files.read_text(tmp_path / "own.toml")


@posix
def test_a_file_without_end_is_read_to_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_files, "_check_mode", lambda mode, path: None)
    with pytest.raises(InputError, match="too large"):
        text_files.read_bytes("/dev/zero")
