"""The points of a sweep: schemes keep what they promise, and any chunk is drawn alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from planter.errors import ComputationError, InputError
from planter.rows.job import CHUNK
from planter.rows.points import (
    Axis,
    Grid,
    HalvedTolerances,
    Plan,
    Saltelli,
    SobolSequence,
    Spread,
    UnitCubePoints,
    draw_latin,
    draw_points,
)
from planter.rows.tolerance_analysis import (
    compute_bands,
    compute_indices,
    compute_tightening,
    first_order_std,
)

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
    "lists in a list": ({"inputs": {"m31": [[1], [2]]}}, "inputs.m31"),
    "truth values": ({"inputs": {"m31": [True, False]}}, "inputs.m31"),
    "lists as ends": ({"inputs": {"m31": {"from": [1], "to": 2}}}, "inputs.m31"),
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


LAWS = {
    "uniform": stats.uniform(2, 6),
    "triangular": stats.triang(0.5, 2, 6),
    "normal": stats.truncnorm(-3, 3, loc=5, scale=1),
}


SPREADS = [
    Spread("normal", -3, 3),
    Spread("uniform", 0, 2),
    Spread("triangular", -1, 1),
    Spread("uniform", 5, 9),
]


@pytest.mark.parametrize("kind", LAWS)
def test_distributions_are_those_of_scipy(kind: str) -> None:
    spread, law, shares = Spread(kind, 2, 8), LAWS[kind], np.linspace(0, 1, 21)  # type: ignore[arg-type]
    np.testing.assert_allclose(spread.from_unit(shares), law.ppf(shares), rtol=1e-9)
    assert np.isclose(spread.std, law.std(), rtol=1e-6)
    assert np.isclose(spread.centre, law.mean())


def test_blocks_of_points_do_not_depend_on_start() -> None:
    spreads = [Spread("normal", -1, 1), Spread("uniform", 2, 8)]
    mixed = Saltelli(spreads, 64, 3)
    block = mixed.block(0, mixed.rows)
    assert mixed.rows == 4 * 64
    assert np.array_equal(mixed.block(50, 200), block[50:200])
    a, b, first, second = block.reshape(4, 64, 2)
    assert np.array_equal(first, np.column_stack([b[:, 0], a[:, 1]]))
    assert np.array_equal(second, np.column_stack([a[:, 0], b[:, 1]]))
    points = draw_points(spreads, 20_000, 3)
    assert np.array_equal(
        points.block(10_000, 10_050), draw_points(spreads, 30_000, 3).block(10_000, 10_050)
    )
    assert not np.array_equal(points.block(10_000, 10_050), points.block(0, 50))


def test_additive_function_has_exact_indices() -> None:
    weights = np.array([1.0, 2.0, -1.5, 0.0])
    mixed = Saltelli(SPREADS, 4096, 1)
    rows = mixed.block(0, mixed.rows) @ weights
    shares = compute_indices(["y"], list("abcd"), rows[:, None], 4096, 0)["y"]
    parts = weights**2 * np.array([spread.std for spread in SPREADS]) ** 2
    for name, part in zip("abcd", parts / parts.sum(), strict=True):
        assert abs(shares[name].first - part) < 0.01
        assert abs(shares[name].total - part) < 0.01
    assert (shares["d"].first, shares["d"].total) == (0, 0)
    slopes = first_order_std(weights[None], SPREADS)
    assert np.isclose(slopes[0] ** 2, parts.sum())


def test_half_a_tolerance_takes_three_quarters_of_its_variance() -> None:
    """Of an additive function; an input without effect buys nothing, nor does a function of other
    inputs.
    """
    weights = np.array([[1.0, 2.0, -1.5, 0.0], [0.0, 0.0, 0.0, 3.0]])
    points = HalvedTolerances(SPREADS, 4096, 1)
    block = points.block(0, points.rows)
    assert np.array_equal(points.block(4000, 9000), block[4000:9000])
    rows = block @ weights.T
    bands = compute_bands(["y", "z"], rows[:4096], rows[0], np.zeros((2, 4)), SPREADS)
    tightened = compute_tightening(["y", "z"], list("abcd"), rows, bands)
    parts = weights[0] ** 2 * np.array([spread.std for spread in SPREADS]) ** 2
    for name, part in zip("abcd", parts, strict=True):
        assert tightened["y"][name].std == pytest.approx(
            np.sqrt(parts.sum() - 0.75 * part), rel=5e-3
        )
    assert tightened["y"]["d"].reduction_percent == tightened["z"]["a"].reduction_percent == 0
    assert tightened["z"]["d"].reduction_percent == pytest.approx(50, abs=1e-9)


def test_machines_without_cycle_are_left_out_of_tightening() -> None:
    spreads = [Spread("uniform", 0, 2), Spread("uniform", -1, 1)]
    points = HalvedTolerances(spreads, 256, 1)
    rows = points.block(0, points.rows)[:, :1].copy()
    bands = compute_bands(["y"], rows[:256], rows[0], np.zeros((1, 2)), spreads)
    rows[::7] = np.nan
    assert compute_tightening(["y"], ["a", "b"], rows, bands)["y"][
        "a"
    ].reduction_percent == pytest.approx(50)
    rows[:] = np.nan
    with pytest.raises(ComputationError, match="no machines"):
        compute_tightening(["y"], ["a", "b"], rows, bands)


def test_ishigami_function_has_published_indices() -> None:
    """Ishigami and Homma (1990), a = 7, b = 0.1."""
    mixed = Saltelli([Spread("uniform", -np.pi, np.pi)] * 3, 8192, 1)
    x, y, z = mixed.block(0, mixed.rows).T
    rows = np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    sobol_indices = compute_indices(["f"], list("xyz"), rows[:, None], 8192, 0)["f"]
    for name, first, total in (("x", 0.3139, 0.5576), ("y", 0.4424, 0.4424), ("z", 0.0, 0.2437)):
        assert abs(sobol_indices[name].first - first) < 0.02
        assert abs(sobol_indices[name].total - total) < 0.01
        assert abs(sobol_indices[name].total - total) < 2 * sobol_indices[name].total_error + 1e-3


def test_constant_output_has_zero_indices() -> None:
    mixed = Saltelli([Spread("uniform", 0, 1)], 64, 1)
    sobol_indices = compute_indices(["f"], ["x"], np.full((mixed.rows, 1), 3.0), 64, 0)["f"]["x"]
    assert (sobol_indices.first, sobol_indices.total, sobol_indices.first_error) == (0, 0, 0)


def test_bands_use_rows_with_results() -> None:
    rows = np.column_stack([np.arange(101.0), np.ones(101)])
    rows[7] = np.nan
    band = compute_bands(["a", "b"], rows, np.array([50.0, 1.0]), np.zeros((2, 0)), [])["a"]
    remaining = np.delete(np.arange(101.0), 7)
    assert (band.missing, band.nominal, band.first_order_std) == (1, 50, 0)
    assert np.allclose(
        [band.mean, band.std, band.p5],
        [remaining.mean(), remaining.std(ddof=1), np.percentile(remaining, 5)],
    )
    with pytest.raises(ComputationError, match="101 of 101 machines have no cycle"):
        compute_bands(["a", "b"], np.full_like(rows, np.nan), np.zeros(2), np.zeros((2, 0)), [])


def test_indices_require_every_row() -> None:
    mixed = Saltelli([Spread("uniform", 0, 1)], 64, 1)
    rows = np.arange(float(mixed.rows))[:, None]
    rows[3] = np.nan
    with pytest.raises(ComputationError, match="1 of 192 machines have no cycle"):
        compute_indices(["f"], ["x"], rows, 64, 0)
