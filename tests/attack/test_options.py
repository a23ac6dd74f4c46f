"""No option is passed over in silence: it changes the result, or it is refused or named in a
note.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer
from hypothesis import given, seed
from hypothesis import strategies as st

from planter.cli.app import build_application
from tests.attack.test_attack import SEED, share
from tests.attack.test_own_files import walk
from tests.support import own
from tests.support.cli import run
from tests.support.labview import Layout, write_lvm

FREE = {"--json", "--overwrite", "--help", "--out", "--set"}
"""Options that change no result by their meaning, or whose values are those of a file."""
MEANS = {"--seed", "--workers", "--cluster"}
"""Options that change no result where there is something random, or a task that is shared."""
NO_TASKS = ("simulate", "calibrate", "sweep --list")
"""Beginnings of calls without such a task; an ensemble has one."""
VALUES: dict[str, tuple[str, ...]] = {
    "--samples": ("48",),
    "--at": ("33",),
    "--model": ("printed",),
    "--lift": (),
    "--motor": (),
    "--all-pairs": (),
    "--resume": (),
    "--pair": ("sine+sine",),
    "--module-mm": ("3",),
    "--speed-rpm": ("31",),
    "--least": ("range M_L",),
    "--all": (),
    "--points": ("31",),
    "--tolerance": ("1e-6",),
    "--rest": (),
    "--least-squares": (),
    "--stiff": (),
    "--perturbation": ("0.01",),
    "--since": ("0.002",),
    "--period": ("0.003",),
    "--seed": ("5",),
    "--ensemble": ("3",),
    "--workers": ("2",),
    "--cluster": ("tcp://a:1",),
    "--column": ("Channel 0",),
    "--angle": ("Channel 1",),
    "--time": ("X_Value",),
    "--trigger": ("Channel 1",),
    "--interval-s": ("0.003",),
    "--unit": ("kN",),
    "--place-unit": ("ms",),
    "--quantity": ("M_L_Nm",),
    "--fit": ("mass.planet_kg=0.8:1.6",),
    "--prior": ("mass.planet_kg=1.2:0.1",),
    "--preview": (),
    "--explain": (),
    "--check": ("own.lvm",),
    "--check-rpm": ("50",),
    "--target": ("other",),
    "--data": ("own.lvm",),
    "--least-slope": ("0.2",),
    "--largest-slope": ("5",),
    "--carrier": ("2",),
    "--poses": ("sun2019",),
    "--crank-mm": ("80",),
    "--centre-distance-mm": ("75",),
    "--optimise": (),
    "--bibtex": (),
    "--hold": ("M_L <= 3 N m",),
    "--shape": ("clamped-cosine",),
    "--mode": ("contact",),
    "--vertices": ("3",),
    "--sides": ("8",),
    "--shaft-mm": ("21",),
    "--travel-mm": ("14",),
    "--radius-mm": ("90",),
    "--length-mm": ("200",),
    "--response": ("Y2",),
    "--blank": ("C",),
    "--ignore": ("C",),
    "--goal": ("Y1=larger",),
    "--comparison": ("none.csv",),
    "--factor": ("A=1,2",),
    "--turns": ("2",),
    "--start-rpm": ("33",),
    "--stall-Nm": ("7",),
    "--idle-rpm": ("45",),
    "--flywheel-kgm2": ("0.5",),
    "--roller-mm": ("7",),
    "--y": ("y",),
    "--x": ("x",),
    "--force": ("F_E",),
    "--bore-mm": ("10",),
    "--width-mm": ("14",),
    "--tolerance-um": ("2",),
    "--step": (),
    "--out": ("out",),
    "--list": ("wang2017",),
    "--starts": ("3",),
    "--until": ("0.012",),
    "--against": ("a.py",),
    "--names": ("a.toml",),
    "--numbers": ("a.toml",),
    "--front": (),
    "--slips": ("3",),
    "--answers": ("a.jsonl",),
}
"""A value for each option, other than its default."""
FLAGS = {("simulate", "--check")}
"""Options that take a value in other commands alone."""
VALID = {
    "simulate wang2017 --check": {"--speed-rpm"},
    "about cite simulate": {"--bibtex"},
    "design clutch engage shi2021": {"--mode"},
}
"""Options by calls whose result says that a value is valid, has both forms, or takes long."""
CALLS = (
    "simulate wang2017",
    "simulate own",
    "sensitivity wang2017 --samples 36",
    "simulate wang2017 --check",
    "simulate free --until 0.01 --points 11",
    "simulate free --until 0.01 --points 11 --ensemble 2",
    "calibrate wang2017 --data own.lvm --preview",
    "calibrate wang2017 --data own.lvm --preview --column 2 --time 1",
    "design synthesise sun2019",
    "design train sun2019-curve",
    "about cite",
    "about cite simulate",
    "about explain",
    "about explain range_N",
    "about explain wang2017 F_E",
    "design clutch engage shi2021",
    "design clutch geometry shi2021",
    "design clutch rotor",
    "design clutch field",
    "design clutch plan L9",
    "simulate compact --motor --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.4",
    "cam wang2017 --roller-mm 6",
    "sweep --list wang2017",
    "audit wang2017",
    "diff compact wang2017",
)
"""Calls that are quick, in modes that differ by the options which they take."""


@cache
def list_options() -> dict[str, set[str]]:
    return dict(walk(typer.main.get_command(build_application())))


def find_command(call: str) -> str:
    words = call.split()
    names = (" ".join(words[:count]) for count in (3, 2, 1))
    return next(name for name in names if name in list_options())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a driven mechanism, a free one, and a file of measurements."""
    folder = tmp_path_factory.mktemp("options")
    for name, source in (("own", "slider_crank"), ("free", "gear_rattle")):
        shutil.copytree(own.generated(source), folder / name)
    write_lvm(folder / "own.lvm", Layout())
    return folder


def say(folder: Path, words: list[str]) -> tuple[int, Any, str]:
    """Return exit code, result and notes of a call in a folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code, out, err = run(*words, "--json")
    return code, json.loads(out) if out else None, err


def list_pairs() -> Iterator[tuple[str, str]]:
    for call in CALLS:
        command = find_command(call)
        for option in sorted(list_options()[command]):
            if option.startswith("--") and option in VALUES and option not in call.split():
                yield call, option


def resolve(call: str) -> list[str]:
    names = {"own": "own/slider_crank.toml", "free": "free/gear_rattle.toml"}
    return [names.get(word, word) for word in call.split()]


@cache
def first_result(folder: Path, call: str) -> tuple[int, Any, str]:
    return say(folder, resolve(call))


def is_told(folder: Path, call: str, option: str, values: tuple[str, ...] | None = None) -> bool:
    """Return whether an option changes the result of a call, or what is said names it."""
    if values is None:
        values = () if (call.split()[0], option) in FLAGS else VALUES[option]
    code, result, notes = say(folder, [*resolve(call), option, *values])
    return code != 0 or result != first_result(folder, call)[1] or option in notes


def list_silent(folder: Path, call: str) -> list[str]:
    """Return the options of a call that are passed over in silence."""
    has_tasks = "--ensemble" in call or not call.startswith(NO_TASKS)
    free = FREE | (MEANS if has_tasks else set()) | VALID.get(call, set())
    options = [option for each, option in list_pairs() if each == call and option not in free]
    changed = {"--model": ("exact",)} if call.startswith("calibrate") else {}
    return [option for option in options if not is_told(folder, call, option, changed.get(option))]


@pytest.mark.long
@pytest.mark.parametrize("call", CALLS)
def test_options_without_effect_are_refused_or_said(call: str, folder: Path) -> None:
    assert first_result(folder, call)[0] == 0, first_result(folder, call)
    assert list_silent(folder, call) == []


IGNORED = {
    "simulate x --until 1": (
        "--since 1",
        "--period 1",
        "--perturbation 0.1",
        "--seed 1",
        "--workers 2",
    ),
    "simulate x --until 1 --ensemble 3": ("--rest", "--least-squares"),
    "optimise wang2017": ("--prove-seconds 3",),
    "studio --static x.html": ("--port 1", "--folder x"),
    "tolerance wang2017 --no-robust": ("--sigmas 2",),
    "audit": ("--seed 3", "--slips 2"),
    "audit --benchmark": ("--against a.py", "--numbers a.toml"),
    "simulate own": ("--module-mm 3",),
    "calibrate wang2017": (
        "--column F",
        "--angle a",
        "--time t",
        "--trigger t",
        "--interval-s 1",
        "--unit N",
        "--place-unit s",
        "--quantity F",
        "--fit a=1:2",
        "--prior a=1:2",
        "--preview",
        "--explain",
        "--check own.lvm",
        "--seed 1",
        "--workers 2",
    ),
    "calibrate wang2017 --data own.lvm --column F": ("--target other",),
    "calibrate wang2017 --data own.lvm --column F --explain": (
        "--workers 2",
        "--check own.lvm",
        "--preview",
    ),
    "about explain": ("--out x", "--set a=1"),
    "about explain wang2017 F_E": ("--out x",),
    "about cite": ("--bibtex",),
    "design train sun2019-curve": ("--carrier 2",),
    "sweep --list wang2017": ("--workers 2", "--out x"),
}
"""Options that have no effect in a mode, by calls."""


@pytest.mark.parametrize(
    ("call", "option"), [(call, option) for call in IGNORED for option in IGNORED[call]]
)
def test_options_of_other_modes_are_refused(call: str, option: str, folder: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code, out, message = run(*resolve(call), *option.split())
    assert (code, out) == (2, "")
    assert option.split()[0] in message


FLOATS = [
    (call, option)
    for call, option in list_pairs()
    if VALUES[option] and VALUES[option][0].replace(".", "", 1).replace("e-", "").isdigit()
]


@seed(SEED)
@share
@given(
    pair=st.sampled_from(FLOATS), number=st.sampled_from(["nan", "inf", "-inf", "1e400", "-1e400"])
)
def test_numbers_of_options_that_are_not_finite_are_refused(
    pair: tuple[str, str], number: str
) -> None:
    call, option = pair
    code, out, err = run(*call.split(), option, number)
    assert (code, out) == (2, "")
    assert option in err


def test_option_that_is_ignored_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("planter.mechanism.simulate_command.refuse_unused", lambda *words: None)
    assert not is_told(folder, "simulate wang2017", "--module-mm")
