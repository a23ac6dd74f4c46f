"""Faults planted in the code: of a seeded sample nearly all are caught by the tests of their
module.

`python -m tests.mutants.test_mutants ADAPTER` prints what becomes of each.
"""

from __future__ import annotations

import os
import sys
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from tests.mutants.forks import ROOT, Job, answers
from tests.mutants.mutator import Mutant, mutants, mutated

SEED = 17
HERE = Path(__file__).parent


@dataclass(frozen=True)
class Trial:
    """A module with a fault in it."""

    path: Path
    mutant: Mutant

    @property
    def name(self) -> str:
        return f"{self.path.stem}: {self.mutant.name}"


@dataclass(frozen=True)
class Room:
    """Modules by patterns, the size of the sample, and tests, those first that most likely fail.

    `seconds` of the processor are more than twice what the tests need on sound modules. `writes`
    says that the modules write programmes, so that faults are planted in that text, too.
    """

    modules: tuple[str, ...]
    size: int
    tests: tuple[str, ...]
    seconds: int
    writes: bool = False

    @cached_property
    def paths(self) -> list[Path]:
        paths = (path for pattern in self.modules for path in ROOT.glob(pattern))
        return sorted(path for path in paths if path.stem != "__init__")

    @cached_property
    def trials(self) -> list[Trial]:
        return [
            Trial(path, m)
            for path in self.paths
            for m in mutants(path.read_text("utf-8"), self.writes)
        ]

    @property
    def sample(self) -> list[Trial]:
        """The mutants that come first in a seeded order of all."""
        return sorted(self.trials, key=lambda trial: trial.mutant.rank(SEED))[: self.size]

    def job(self, trial: Trial) -> Job:
        """The tests of a module with a fault in it."""
        return self._job(
            trial.path, mutated(trial.path.read_text("utf-8"), trial.mutant, self.writes)
        )

    def sound(self, path: Path) -> Job:
        """The tests of a module as it is."""
        return self._job(path, path.read_text("utf-8"))

    def _job(self, path: Path, text: str) -> Job:
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        return Job(module, text, tuple(self.tests), self.seconds)


def read_toml(name: str) -> dict[str, Any]:
    return tomllib.loads((HERE / name).read_text("utf-8"))


ROOMS = {name: Room(**fields) for name, fields in read_toml("rooms.toml").items()}
EQUIVALENT = {e["mutant"]: e["reason"] for e in read_toml("equivalent.toml")["equivalent"]}
"""Mutants that do the same as the module they are of, with the reason."""
MANY = 200
CAUGHT = 0.95
"""Share of the mutants of a room that do something else than the module they are of."""
FAULTY = """
def size(x, y, known=True):
    '''Not 1 but twice.'''
    if x < 0 and known:
        raise ValueError("x is < 0")
    return max(x, 2 * y)
"""

forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")


@pytest.mark.parametrize(
    "fault",
    [
        "if x <= 0 and known:",
        "if x < 0 or known:",
        "if not (x < 0 and known):",
        "known=False",
        "return min(x, 2 * y)",
        "return max(x, 2 / y)",
        "return max(x, 3 * y)",
        "return max(2 * y, x)",
        "return None",
    ],
)
def test_mutant_has_a_single_change(fault: str) -> None:
    assert [fault in mutated(FAULTY, m) for m in mutants(FAULTY)].count(True) == 1


def test_words_are_left_alone() -> None:
    assert all("Not 1 but twice." in mutated(FAULTY, m) for m in mutants(FAULTY))
    assert not any("x is <= 0" in mutated(FAULTY, m) for m in mutants(FAULTY, writes=True))


def test_signs_are_exchanged_in_program_text() -> None:
    source = "text = '{0} + {1} < 1.0'"
    assert not mutants(source)
    exchanged = {
        mutated(source, m, writes=True).split("'")[1] for m in mutants(source, writes=True)
    }
    assert exchanged == {
        "{1} + {1} < 1.0",
        "{0} - {1} < 1.0",
        "{0} + {0} < 1.0",
        "{0} + {1} <= 1.0",
        "{0} + {1} < 0.0",
    }


def test_mutants_have_unique_names_without_line_numbers() -> None:
    names = [m.name for m in mutants(FAULTY)]
    assert len(set(names)) == len(names)
    assert [m.name for m in mutants("\n\n" + FAULTY)] == names
    assert sorted(m.rank(1) for m in mutants(FAULTY)) != sorted(m.rank(2) for m in mutants(FAULTY))


def test_the_sample_is_large_and_tests_are_there() -> None:
    assert sum(room.size for room in ROOMS.values()) >= MANY
    assert all(len(room.sample) == room.size for room in ROOMS.values())
    assert all(room.job(trial).tests for room in ROOMS.values() for trial in room.sample)


def test_equivalent_mutants_exist_and_have_reasons() -> None:
    assert EQUIVALENT.keys() <= {trial.name for room in ROOMS.values() for trial in room.trials}
    assert all(EQUIVALENT.values())


@pytest.mark.long
@forks
@pytest.mark.parametrize("name", ROOMS)
def test_nearly_every_fault_is_caught(name: str) -> None:
    room = ROOMS[name]
    trials = [trial for trial in room.sample if trial.name not in EQUIVALENT]
    results = list(answers([room.job(trial) for trial in trials]))
    missed = [trial.name for trial, answer in zip(trials, results, strict=True) if not answer.by]
    print(
        f"{name}: {len(trials) - len(missed)} of {len(trials)} caught, {room.size - len(trials)} "
        f"equivalent"
    )
    assert len(missed) <= (1 - CAUGHT) * len(trials), missed


@pytest.mark.long
@forks
@pytest.mark.parametrize("name", ROOMS)
def test_sound_modules_are_not_caught(name: str) -> None:
    (answer,) = answers([ROOMS[name].sound(ROOMS[name].paths[0])])
    assert not answer.by
    assert 2 * answer.seconds < ROOMS[name].seconds


@pytest.mark.long
@forks
def test_endless_mutant_is_caught() -> None:
    """And a module that cannot be loaded."""
    tests = ("tests/derive/test_quantities.py",)
    endless, broken = (
        Job("derive.quantity", text, tests, seconds=2) for text in ("while True: pass", "1 / 0")
    )
    results = list(answers([endless, broken]))
    assert [answer.by for answer in results] == ["SIGXCPU", "collection"]


if __name__ == "__main__":
    chosen: Room = ROOMS[sys.argv[1]]
    for trial, answer in zip(
        chosen.sample, answers(list(map(chosen.job, chosen.sample))), strict=True
    ):
        outcome = "equivalent" if trial.name in EQUIVALENT else "MISSED"
        print(f"{answer.seconds:6.2f} s  {answer.by or outcome}  {trial.name}", flush=True)
    print(f"seed {SEED}")
