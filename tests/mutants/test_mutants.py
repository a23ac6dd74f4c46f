"""Faults planted in the code: of a seeded sample nearly all are caught by the tests of their
module.

`python -m tests.mutants.test_mutants ADAPTER` prints what becomes of each.
"""

from __future__ import annotations

import os
import sys

import pytest

from tests.mutants.forks import Job, answers
from tests.mutants.mutator import mutants, mutated
from tests.mutants.rooms import SEED, Room, equivalent, rooms

ROOMS = rooms()
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
    assert set(equivalent()) <= {
        trial.name for room in ROOMS.values() for trial in room.list_trials
    }
    assert all(equivalent().values())


@pytest.mark.long
@forks
@pytest.mark.parametrize("name", ROOMS)
def test_nearly_every_fault_is_caught(name: str) -> None:
    room, known_equivalent = ROOMS[name], equivalent()
    trials = [trial for trial in room.sample if trial.name not in known_equivalent]
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
        outcome = "equivalent" if trial.name in equivalent() else "MISSED"
        print(f"{answer.seconds:6.2f} s  {answer.by or outcome}  {trial.name}", flush=True)
    print(f"seed {SEED}")
