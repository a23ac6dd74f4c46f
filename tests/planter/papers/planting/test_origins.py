"""An origin belongs to the number it was written for: in a copied file, after options, and in files
that we write.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from planter.files import examples
from planter.files.fields import OWN, SET
from planter.papers.planting.file import PlantingMachine, load
from tests.support import own
from tests.support.cli import answer, run

WIDE = "wang2017-wide"
MACHINES = examples.list_examples("planting", ".toml")


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copied example with another speed, mass and limit."""
    text = examples.example(WIDE)
    for before, after in (
        ("\nspeed_rpm = 40 ", "\nspeed_rpm = 50 "),
        ("\nplanet_kg = 1.20 ", "\nplanet_kg = 1.25 "),
        ("\nfunnel_speed_max_m_s = 0.6", "\nfunnel_speed_max_m_s = 0.7"),
    ):
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    path = tmp_path / "my.toml"
    path.write_text(text, encoding="utf-8")
    return path


CHANGED = ["operation.speed_rpm", "mass.planet_kg", "requirements.funnel_speed_max_m_s"]


@pytest.mark.parametrize("name", MACHINES)
def test_built_in_files_have_their_own_origins(name: str) -> None:
    assert load(name).own_numbers() == []


def test_changed_numbers_are_of_this_file(copy: Path) -> None:
    original, changed = load(WIDE).number_origins(), load(str(copy)).number_origins()
    assert {path for path, words in changed.items() if words != original[path]} == set(CHANGED)
    assert {changed[path] for path in CHANGED} == {OWN}
    assert original["operation.speed_rpm"].startswith("paper")


def test_origin_of_the_file_itself_stays(copy: Path) -> None:
    table: dict[str, Any] = load(str(copy)).table()
    table["origin"] |= {"mass.planet_kg": "measured on my scales"}
    machine = PlantingMachine.read(table, str(copy))
    assert machine.origin("mass.planet_kg") == "measured on my scales"
    assert machine.own_numbers() == [path for path in CHANGED if path != "mass.planet_kg"]


def test_validate_lists_numbers_of_this_file(copy: Path) -> None:
    assert answer("validate", WIDE)["own_numbers"] == []
    assert answer("validate", str(copy))["own_numbers"] == CHANGED
    left = answer("validate", str(copy), "--speed-rpm", "45")["own_numbers"]
    assert left == CHANGED[1:]
    assert load(str(copy), {"speed_rpm": 45}).origin("operation.speed_rpm") == SET


@pytest.mark.long
def test_closest_design_keeps_origins(copy: Path, tmp_path: Path) -> None:
    """At this speed nothing satisfies the requirements, so that the search writes the closest
    design.
    """
    options = (
        "--method",
        "ipopt",
        "--starts",
        "1",
        "--set",
        "sun_kg=0.5",
        "--out",
        str(tmp_path / "out"),
    )
    assert run("optimise", str(copy), *options)[0] == 1
    closest = load(str(tmp_path / "out" / "closest.toml"))
    origins = closest.number_origins()
    assert [origins[path] for path in CHANGED] == [OWN] * 3
    assert "set on the command line" in origins["mass.sun_kg"]
    moved = [path for path, words in origins.items() if words.startswith("optimised")]
    assert moved
    assert all(path.startswith("design.") for path in moved)
    assert answer("validate", str(tmp_path / "out" / "closest.toml"))["own_numbers"] == CHANGED


def test_optimum_of_mechanism_names_what_was_set(tmp_path: Path) -> None:
    source = own.generated("slider_crank") / "slider_crank.toml"
    options = ("--least", "range s", "--starts", "1", "--set", "m_s_kg=1.7", "--out", str(tmp_path))
    answer("optimise", str(source), *options)
    text = (tmp_path / "optimum.toml").read_text()
    assert '"values.m_s_kg" = "assumed; set on the command line"' in text
    assert '"values.m_r_kg"' not in text
