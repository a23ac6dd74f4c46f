"""Values that change over time while a mechanism moves."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter.errors import InputError
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import load
from planter.mechanism.input_history import read_history
from tests.planter.mechanism.state_space.statements import CART, RUBBING
from tests.support import own
from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema

MASS = 1.3
"""Of cart and bob together, whose centroid the push accelerates alone [kg]."""


def find_file(source: str) -> Path:
    return own.generated(source) / "own.toml"


def test_ramp_moves_the_centroid_by_a_cubic(tmp_path: Path) -> None:
    """A push of 6 t up to half a second, then constant, with the bob: momentum is its integral."""
    table = tmp_path / "push.csv"
    table.write_text("# a ramp\nt_s,F_N\n0,0\n0.5,3\n2,3\n", encoding="utf-8")
    file = load(find_file(CART), {"values.d_N_s_m": 0.0})
    dynamics = Dynamics(file, read_history(table, file))
    times = np.linspace(0, 1, 11)
    _, a, s_rate, a_rate = dynamics.run(times).states
    momentum = MASS * s_rate + 0.3 * 0.5 * np.cos(a) * a_rate
    expected = np.where(times < 0.5, 3 * times**2, 0.75 + 3 * (times - 0.5))
    np.testing.assert_allclose(momentum, expected, atol=1e-8)


def test_constant_input_is_the_value_of_the_file(tmp_path: Path) -> None:
    """Also where friction makes the motion depend on forces of joints, and in what is reported."""
    table = tmp_path / "push.csv"
    table.write_text("t_s,F_N\n0,7\n", encoding="utf-8")
    path = find_file(RUBBING)
    file = load(path, {})
    moved = Dynamics(file, read_history(table, file)).run(np.linspace(0, 0.3, 4))
    fixed = Dynamics(load(path, {"values.F_N": 7.0})).run(np.linspace(0, 0.3, 4))
    np.testing.assert_allclose(moved.states, fixed.states, rtol=1e-12)
    for name, values in fixed.results.items():
        np.testing.assert_allclose(moved.results[name], values, rtol=1e-9, atol=1e-9)
    other = Dynamics(load(path, {})).run(np.linspace(0, 0.3, 4))
    assert np.abs(other.states - fixed.states).max() > 0.01


def test_move_takes_a_table(tmp_path: Path) -> None:
    table = tmp_path / "push.csv"
    table.write_text("t_s,F_N\n0,0\n1,2\n", encoding="utf-8")
    path = str(find_file(CART))
    pushed = answer("move", path, "--until", "1", "--input", str(table))
    assert pushed["quantities"]["s_mm"]["last"] > 100
    assert answer("move", path, "--until", "1")["quantities"]["s_mm"]["last"] == 0


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("t_s,F_N\n0,1\n0,2\n", "line 3"),
        ("F_N\n1\n", "t_s"),
        ("t_s,G_N\n0,1\n", "G_N"),
        ("t_s,F_N\n0,x\n", "line 2"),
        ("t_s,F_N\n", "header"),
    ],
)
def test_tables_that_cannot_be_meant_are_refused(tmp_path: Path, text: str, named: str) -> None:
    table = tmp_path / "push.csv"
    table.write_text(text, encoding="utf-8")
    file = load(find_file(CART), {})
    with pytest.raises(InputError, match=named):
        read_history(table, file)


def test_simulate_takes_what_moves_freely(tmp_path: Path) -> None:
    table = tmp_path / "push.csv"
    table.write_text("t_s,F_N\n0,0\n1,2\n", encoding="utf-8")
    path = str(find_file(CART))
    words = "--until", "1", "--input", str(table)
    result = answer("simulate", path, *words, "--out", str(tmp_path / "out"))
    assert result == answer("move", path, *words)
    jsonschema.validate(result, load_schema("simulate"))
    assert (tmp_path / "out" / "values.csv").is_file()
    assert answer("simulate", path)["until_s"] == 2
    assert "--samples" in refusal("simulate", path, "--until", "1", "--samples", "9")
    assert "--until" in refusal("simulate", "wang2017", "--until", "1")
