"""Whatever a file or an option holds, a command ends in a result, or in one sentence; never in a traceback.

`make attack` tries ten thousand; the suite a sample of them, always the same one.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planter.files import examples
from tests.attack.files import CORPUS, NUMBERS, PIECES, Spoiled, spoiled
from tests.support.cli import run

CASES = int(os.environ.get("PLANTER_ATTACKS", "60"))
"""Cases of the generator in all."""
TAKERS = {
    "planting": ("validate",),
    "clutch": ("clutch", "geometry"),
    "pickup": ("pickup",),
    "mapping": ("synthesise",),
}
"""A quick command for the files of each room."""
TABLES = {"yu2023-path": ("pickup",), "sun2019-curve": ("train",), "shi2021-field": ("clutch", "field")}
OPTIONS = (
    ("validate", "wang2017", "--set"), ("simulate", "wang2017", "--at"), ("clutch", "rotor", "--vertices"),
    ("clutch", "geometry", "shi2021", "--set"), ("synthesise", "sun2019", "--set"), ("explain",), ("example",),
    ("schema",), ("animate",), ("turn",), ("move",), ("sweep",), ("train",), ("audit",), ("derive",),
)  # fmt: skip
"""Calls that want one more word."""
TEXTS = st.one_of(
    st.sampled_from((*NUMBERS, *PIECES)), st.text(max_size=12), st.floats().map(str), st.integers().map(str),
    st.tuples(st.sampled_from(("mass.sun_kg", "design.R3_mm", "x", "")), st.sampled_from(NUMBERS)).map("=".join),
)  # fmt: skip
share = settings(
    max_examples=max(1, CASES // 3), derandomize=True, deadline=None, database=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip


def held(*arguments: str) -> None:
    """A call ends as every call does: one JSON object with numbers that are finite, or one sentence and code 1 or 2.

    Of an option that cannot be read the library says so below its usage; the program makes one sentence of that.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code, out, err = run(*arguments, "--json")
    assert code in (0, 1, 2), (arguments, err)
    if code == 0:
        json.loads(out, parse_constant=pytest.fail)
    else:
        assert out == ""
        told = [line for line in err.splitlines() if line.startswith(("planter: ", "Error: "))]
        assert len(told) == 1, (arguments, err)
        assert "Traceback" not in err
        assert told[0].isprintable(), told


def handed(content: bytes, suffix: str, *command: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"own{suffix}"
        path.write_bytes(content)
        held(*command, str(path))


SAMPLED = (("validate",), ("train",), ("turn",))
EVERY = (*TAKERS.values(), *TABLES.values(), ("sweep",), ("turn",), ("simulate",))


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=[] if c in SAMPLED else pytest.mark.long, id=c[0]) for c in EVERY]
)
def test_the_corpus_ends_in_sentences(command: tuple[str, ...]) -> None:
    for content in CORPUS:
        handed(content, ".csv" if command in TABLES.values() else ".toml", *command)


@share
@given(found=spoiled(tuple(name for room in TAKERS for name in examples.names(room, ".toml"))))
def test_machine_files_that_are_spoiled_end_in_sentences_or_results(found: Spoiled) -> None:
    room = next(room for room in TAKERS if found.name in examples.names(room, ".toml"))
    handed(found.content, ".toml", *TAKERS[room])


@share
@given(found=spoiled(tuple(TABLES)))
def test_tables_that_are_spoiled_end_in_sentences_or_results(found: Spoiled) -> None:
    handed(found.content, ".csv", *TABLES[found.name])


@share
@given(call=st.sampled_from(OPTIONS), text=TEXTS)
def test_words_that_are_none_end_in_sentences_or_results(call: tuple[str, ...], text: str) -> None:
    held(*call, text)


@pytest.mark.parametrize("content", CORPUS[:24:6])
def test_a_process_ends_as_a_call_does(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "planter", "validate", str(tmp_path / "own.toml")],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1


def test_an_attack_that_gets_through_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    from planter.planting import validation

    def broken(device: object) -> object:
        raise KeyError("mass")

    monkeypatch.setattr(validation, "validate", broken)
    with pytest.raises((AssertionError, KeyError)):
        held("validate", "wang2017")
