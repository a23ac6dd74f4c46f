"""The points of a sweep: schemes keep what they promise, and any chunk is drawn alone."""

import numpy as np
import pytest
from scipy.stats import qmc

from planter.errors import InputError
from planter.rows.job import CHUNK
from planter.rows.points import Axis, Grid, Plan, SobolSequence, UnitCubePoints, draw_latin

RANGE, LISTED = Axis.model_validate({"from": -2, "to": 6}), Axis(values=(1.0, 4.0, 9.0))
TEXTS = Axis(values=("red", "blue"))


def test_grid_has_every_combination_once() -> None:
    steps = Axis.model_validate({"from": 0, "to": 1, "steps": 3})
    grid = Grid([LISTED, steps, TEXTS])
    rows = grid.block(0, grid.rows)
    assert grid.rows == len({tuple(row) for row in rows}) == 18
    assert rows[:3].tolist() == [[1, 0, 0], [1, 0, 1], [1, 0.5, 0]]
    assert np.array_equal(grid.block(7, 11), rows[7:11])


def test_sequence_blocks_are_independent_of_start() -> None:
    block = SobolSequence(3, 5)(0, 64)
    other = SobolSequence(3, 5)
    assert np.array_equal(other(40, 64), block[40:])
    assert np.array_equal(other(8, 24), block[8:24])
    assert not np.array_equal(SobolSequence(3, 6)(0, 64), block)


def test_sobol_points_are_evenly_distributed() -> None:
    points = UnitCubePoints([RANGE, LISTED, TEXTS], 3 * 1024, SobolSequence(3, 1)).block(0, 1024)
    assert ((points[:, 0] >= -2) & (points[:, 0] < 6)).all()
    assert qmc.discrepancy((points[:, [0]] + 2) / 8) < 1e-5
    _, counts = np.unique(points[:, 1], return_counts=True)
    assert np.ptp(counts) <= 2
    assert (points[:, 2] == 0).sum() == 512


def test_latin_hypercube_has_a_row_per_slice() -> None:
    latin = UnitCubePoints([RANGE, RANGE], CHUNK + 50, draw_latin(2, 1))
    for start, stop in ((0, CHUNK), (CHUNK, CHUNK + 50)):
        slices = np.floor((latin.block(start, stop) + 2) / 8 * (stop - start)).astype(int)
        assert all(np.array_equal(np.sort(column), np.arange(stop - start)) for column in slices.T)
    assert not np.array_equal(latin.block(0, 50), latin.block(CHUNK, CHUNK + 50))
    assert np.array_equal(latin.block(CHUNK, CHUNK + 50), latin.block(CHUNK, CHUNK + 50))


BASE = {"machine": "wang2017", "inputs": {"speed_rpm": [35, 45]}}
WRONG = {
    "a range without steps": (
        {"inputs": {"m31": {"from": 1, "to": 2}}},
        "inputs.m31.steps is missing",
    ),
    "a range upside down": (
        {"inputs": {"m31": {"from": 2, "to": 1, "steps": 3}}},
        "it must have from less than to",
    ),
    "half a range": (
        {"inputs": {"m31": {"from": 2, "steps": 3}}},
        "it must have from less than to",
    ),
    "a list and a range": (
        {"inputs": {"m31": {"from": 1, "to": 2, "values": [1]}}},
        "it must be a list of values, or",
    ),
    "a number": ({"inputs": {"m31": 1.5}}, "inputs.m31 = 1.5: it must be a list of values"),
    "numbers and texts": (
        {"inputs": {"m31": [1.5, "exact"]}},
        "a list of numbers, or a list of texts",
    ),
    "a value twice": ({"inputs": {"m31": [1.5, 1.5]}}, "= [1.5, 1.5]"),
    "nothing": ({"inputs": {}}, "inputs = {}"),
    "points of a grid": ({"points": 5}, "points = 5:"),
    "no points": ({"scheme": "sobol"}, "points is missing"),
    "too many": (
        {"inputs": {n: {"from": 0, "to": 1, "steps": 999_999} for n in "ab"}},
        "at most 100000000",
    ),
    "another scheme": ({"scheme": "halton"}, "'grid', 'sobol' or 'latin'"),
    "an unknown key": ({"sead": 1}, "did you mean seed?"),
    "not finite": ({"inputs": {"m31": [float("nan")]}}, "inputs.m31"),
}


@pytest.mark.parametrize(("change", "message"), WRONG.values(), ids=WRONG.keys())
def test_invalid_plan_is_rejected(change: dict, message: str) -> None:
    with pytest.raises(InputError) as refused:
        Plan.read(BASE | change, "plan.toml")
    assert message in refused.value.message
    assert refused.value.message.startswith("plan.toml: ")


def test_several_machines_become_first_input() -> None:
    plan = Plan.read(BASE | {"machine": ["wang2017", "compact"]}, "plan.toml")
    assert list(plan.axes) == ["machine", "speed_rpm"]
    assert plan.sample_points.rows == 4


@pytest.mark.parametrize(
    "value",
    [
        [[1], [2]],
        [{"a": 1}],
        [1, "exact"],
        [True, False],
        [[]],
        [1, [2]],
        {"from": [1], "to": 2},
        3,
        None,
        "x",
    ],
)
def test_values_of_wrong_kind_are_rejected(value: object) -> None:
    with pytest.raises(InputError, match=r"plan\.toml: .*speed_rpm"):
        Plan.read({"machine": "wang2017", "inputs": {"speed_rpm": value}}, "plan.toml")
