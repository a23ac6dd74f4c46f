"""The table of free dynamics: its page holds the record, its pieces measure what they say."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest

from planter.mechanism.state_space.model import load_dynamics
from tests.benchmarks import dynamics, peers
from tests.planter.mechanism.state_space.statements import build_chain
from tests.support import own
from tests.support.lanes import needs_compiler

RECORD = json.loads(dynamics.RECORD.read_text("utf-8"))


def test_page_holds_the_table_of_the_record() -> None:
    page = dynamics.PAGE.read_text("utf-8")
    assert dynamics.fill_page(page, RECORD) == page
    tampered = copy.deepcopy(RECORD)
    tampered["rows"][0]["f_ns"] *= 2
    assert dynamics.fill_page(page, tampered) != page


def test_missing_programs_and_machines_are_said() -> None:
    record = copy.deepcopy(RECORD)
    record["versions"]["mujoco"] = "not installed"
    left_out = record["rows"].pop()["machine"]
    text = dynamics.render_page(record)
    assert "mujoco" in text
    assert left_out in text


def test_digits_are_those_of_double_precision() -> None:
    eps = np.finfo(float).eps
    assert dynamics.count_lost_digits(eps) == "0.0"
    assert dynamics.count_lost_digits(1000 * eps) == "3.0"
    assert dynamics.count_lost_digits(None) == "-"


@needs_compiler
def test_short_chain_is_measured_and_agrees_with_pinocchio() -> None:
    pytest.importorskip("pinocchio")
    row = dynamics.measure_planter(dynamics.build_chain_machine(3))
    assert (row["coordinates"], row["constraints"], row["reference"]) == (3, 0, "Pinocchio")
    assert row["error"] < 1e-13
    assert row["jacobian_error"] < 1e-12
    for key in ("derive_s", "compile_s", "f_ns", "f_python_ns", "jacobian_ns", "jacobian_all_ns"):
        assert row[key] > 0, key
    assert row["f_ns"] < row["f_graph_ns"] < row["f_python_ns"]


@needs_compiler
def test_compiled_graph_is_the_function_of_the_model() -> None:
    model = load_dynamics(own.generated(build_chain(3)) / "own.toml")
    compiled = dynamics.CompiledGraph(dynamics.exports._densify(model, "rates_jacobian"))
    state = np.random.default_rng(3).uniform(-1, 1, 6)
    slopes = model.linearised(0.0, state)
    for values, expected in zip(
        compiled.evaluate(0.0, state, model.u, model.p), slopes, strict=True
    ):
        np.testing.assert_allclose(values[: expected.size], expected.ravel(), atol=1e-12)


def test_kane_and_pinocchio_state_the_same_chain() -> None:
    pytest.importorskip("pinocchio")
    assert peers.measure_kane(2)["error"] < 1e-13
    tree, state = peers.Pinocchio(2), np.full(2, 0.3)
    swapped = tree.accelerate(state, -2 * state, np.zeros(0))
    assert peers.find_error(swapped, tree.accelerate(state, state, np.zeros(0))) > 1e-3
