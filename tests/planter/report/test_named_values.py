"""Results are named in words, and their keys stand beside the names alone."""

from __future__ import annotations

import re

import pytest

from planter.report.labels import tabulate_named
from tests.support.cli import run

RAW = re.compile(r"\w*[A-Za-z]_\w+")


def find_raw_keys(text: str) -> list[str]:
    """Return the keys of a printed text that do not stand alone in the last column, to the right of
    a name.
    """
    return [
        key
        for line in text.splitlines()
        for key in RAW.findall(re.sub(r"(?<=\s)\S+\s*$", "", line))
    ]


@pytest.mark.parametrize(
    "words",
    [
        ("clutch", "geometry", "shi2021"),
        ("clutch", "engage", "shi2021"),
        ("clutch", "design", "shi2021"),
        ("clutch", "optimise", "shi2021", "--starts", "1"),
        ("clutch", "rotor"),
        ("clutch", "field"),
        ("train", "sun2019-curve", "--crank-mm", "30"),
        ("synthesise", "sun2019"),
    ],
)
def test_results_are_named_in_words(words: tuple[str, ...]) -> None:
    code, text, _ = run(*words)
    assert code == 0
    assert find_raw_keys(text) == []


def test_named_values_have_units_and_keys() -> None:
    names = {"t_max_s": "Time of the largest load", "x_s": "Split /", "error_per_s": "Error / 1/s"}
    table = tabulate_named({"t_max_s": 1.5, "x_s": 0.9, "error_per_s": 2.0, "mass_kg": 3.0}, names)
    assert table.rows == [
        ("Time of the largest load", 1.5, "s", "t_max_s"),
        ("Split", 0.9, "", "x_s"),
        ("Error", 2.0, "1/s", "error_per_s"),
        ("mass", 3.0, "kg", "mass_kg"),
    ]
