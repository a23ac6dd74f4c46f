"""Whatever a file or an option holds, a command ends in a result, or in one sentence; never in a
traceback.

`make attack` tries ten thousand, others with another PLANTER_ATTACK_SEED; the suite some,
always the same ones.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, seed, settings

from planter.files import examples
from tests.attack.files import CORPUS, Spoiled, spoiled
from tests.attack.words import CALLS
from tests.support.cli import run

CASES = int(os.environ.get("PLANTER_ATTACKS", "60"))
"""Cases of the generator in all; `make test-long` and `make attack` take thousands."""
SEED = int(os.environ.get("PLANTER_ATTACK_SEED", "0"))
TAKERS = {
    "planting": ("validate",),
    "clutch": ("clutch", "geometry"),
    "pickup": ("pickup",),
    "mapping": ("synthesise",),
}
"""A quick command for the files of each room."""
TABLES = {
    "yu2023-path": ("pickup",),
    "sun2019-curve": ("train",),
    "shi2021-field": ("clutch", "field"),
}
SLOW = ("pickup", "mapping", "yu2023-path")
"""Rooms and tables whose files, where nothing is wrong with them, take half a second; a tenth are
of these.
"""


def often(names: Iterable[str], slow: Iterable[str]) -> tuple[str, ...]:
    """Names to draw from; those that are slow seldom."""
    common, seldom = tuple(names), tuple(slow)
    quick = tuple(name for name in common if name not in seldom)
    return (*quick * (9 * len(seldom) // len(quick) + 1), *seldom)


MACHINES = {name: room for room in TAKERS for name in examples.list_examples(room, ".toml")}
share = settings(
    max_examples=max(1, CASES // 3),
    derandomize=not SEED,
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
)


def assert_ends_properly(*arguments: str) -> None:
    """A call ends as every call does: one JSON object with numbers that are finite, or one sentence
    and code 1 or 2.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code, out, err = run(*arguments, "--json")
    assert code in (0, 1, 2), (arguments, err)
    if code != 2:
        json.loads(out, parse_constant=pytest.fail)
    if code:
        assert (out == "") is (code == 2), (arguments, out)
        messages = [line for line in err.splitlines() if line.startswith("planter: ")]
        assert len(messages) == 1, (arguments, err)
        assert "Traceback" not in err
        assert messages[0].isprintable(), messages


def handed(content: bytes, suffix: str, *command: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"own{suffix}"
        path.write_bytes(content)
        assert_ends_properly(*command, str(path))


SAMPLED = (("validate",), ("train",), ("turn",))
EVERY = (*TAKERS.values(), *TABLES.values(), ("sweep",), ("turn",), ("simulate",))


@pytest.mark.parametrize(
    "command",
    [pytest.param(c, marks=[] if c in SAMPLED else pytest.mark.long, id=c[0]) for c in EVERY],
)
def test_the_corpus_ends_in_sentences(command: tuple[str, ...]) -> None:
    for content in CORPUS:
        handed(content, ".csv" if command in TABLES.values() else ".toml", *command)


def test_path_too_short_is_refused_without_warnings() -> None:
    """Its gears have a stretch of no length, which once was divided by."""
    lines = examples.example("yu2023-path").splitlines()
    handed("\n".join([*lines[:13], *lines[14:]]).encode(), ".csv", "pickup")


@seed(SEED)
@share
@given(damaged=spoiled(often(MACHINES, [name for name, room in MACHINES.items() if room in SLOW])))
def test_spoiled_machine_files_give_results_or_sentences(damaged: Spoiled) -> None:
    handed(damaged.content, ".toml", *TAKERS[MACHINES[damaged.name]])


@seed(SEED)
@share
@given(damaged=spoiled(often(TABLES, [name for name in TABLES if name in SLOW])))
def test_spoiled_tables_give_results_or_sentences(damaged: Spoiled) -> None:
    handed(damaged.content, ".csv", *TABLES[damaged.name])


@seed(SEED)
@share
@given(call=CALLS)
def test_nonsense_arguments_end_in_sentences(call: tuple[str, ...]) -> None:
    assert_ends_properly(*call)


@pytest.mark.parametrize("content", CORPUS[:24:6])
def test_a_process_ends_as_a_call_does(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "planter", "validate", str(tmp_path / "own.toml")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever a word names, it is not in the checkout."""
    monkeypatch.chdir(tmp_path)


def test_successful_attack_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:

    def broken(device: object) -> object:
        raise KeyError("mass")

    monkeypatch.setattr("planter.mechanism.cycle.validate_machine", broken)
    with pytest.raises((AssertionError, KeyError)):
        assert_ends_properly("validate", "wang2017")
