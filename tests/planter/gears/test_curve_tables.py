"""Tables of pitch curves: one closed turn, or one sentence, in seconds and bounded memory."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from planter.errors import PlanterError
from planter.gear_geometry.pitch_curves import build_sampled_pair
from planter.gears.request import load_pair
from planter.kernels import Array
from planter.numerics import piecewise
from planter.numerics.arrays import find_gap
from tests.support.cli import refusal

POLAR = np.arange(60) * 6.0
RADIUS = 40 + 3 * np.cos(np.radians(POLAR) + 0.4)


def write_curve(path: Path, polar: Array, radius: Array) -> str:
    rows = zip(polar.tolist(), radius.tolist(), strict=True)
    path.write_text("polar_deg,radius_mm\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows))
    return str(path)


def replaced(row: int, radius: float) -> Array:
    changed = RADIUS.copy()
    changed[row] = radius
    return changed


PARTS = {
    "half a turn": (POLAR[POLAR <= 180], "covers 180°"),
    "20 deg": (np.linspace(0, 20, 20), "covers 20°"),
    "20 deg, backwards": (np.linspace(20, 0, 20), "covers 20°"),
    "a hole": (POLAR[(POLAR < 98) | (POLAR > 260)], "no row from 96 to 264°"),
    "radians": (np.radians(POLAR), "are these radians"),
    "all but 30 deg": (POLAR[POLAR <= 330], "covers 330°"),
    "beyond a turn": (np.append(POLAR, [360.0, 366.0]), "goes over 366°"),
}


@pytest.mark.parametrize("kind", PARTS)
def test_table_of_no_closed_turn_exits_2(tmp_path: Path, kind: str) -> None:
    polar, message = PARTS[kind]
    file = write_curve(tmp_path / "own.csv", polar, 40 + 3 * np.cos(np.radians(polar)))
    assert message in refusal("gears", "--curve", file, "--module", "2")


def test_radius_without_closure_exits_2(tmp_path: Path) -> None:
    for end, message in ((1.001, "radius_mm: 42.8"), (1.0, None)):
        radius = np.append(RADIUS, end * RADIUS[0])
        file = write_curve(tmp_path / "own.csv", np.append(POLAR, 360.0), radius)
        if message:
            assert message in refusal("gears", "--curve", file, "--module", "2")
        else:
            assert load_pair(file, None, 1).sense == 1


@pytest.mark.parametrize("dropped", [[7], [20, 21, 22], [30, 59]])
def test_missing_rows_within_the_spacing_are_allowed(tmp_path: Path, dropped: list[int]) -> None:
    rows = np.delete(np.arange(60), dropped)
    pair = load_pair(write_curve(tmp_path / "own.csv", POLAR[rows], RADIUS[rows]), None, 1)
    assert pair.gear.length == pytest.approx(0.2517, rel=2e-3)


def test_gap_is_judged_by_the_typical_step() -> None:
    assert find_gap(np.full(20, 3.0)) is None
    assert find_gap(np.array([1.0, 1.0, 4.9, 1.0])) is None
    assert find_gap(np.array([1.0, 1.0, 5.1, 1.0])) == 2


IMPOSSIBLE = {
    "one radius of 120": (replaced(30, 120.0), "must be at most 80°"),
    "nearly nothing": (RADIUS * 1e-12, "must be at least 0.01 mm"),
    "too many": (np.full(4001, 40.0), "4001 points"),
    "no mate": (np.maximum(100 * np.exp(-4.0 * np.abs(np.linspace(-np.pi, np.pi, 361)[:-1])), 1), "no mate rolls"),
    "through its axis": (np.where(np.isin(np.arange(60), [30, 31]), 0.05, RADIUS), "it must be above 0"),
}


@pytest.mark.parametrize("kind", IMPOSSIBLE)
def test_impossible_curve_is_refused_in_seconds(tmp_path: Path, kind: str) -> None:
    radius, message = IMPOSSIBLE[kind]
    file = write_curve(tmp_path / "own.csv", np.arange(len(radius)) * 360 / len(radius), radius)
    begun = time.process_time()
    assert message in refusal("gears", "--curve", file, "--module", "2")
    assert time.process_time() - begun < 5


def test_rough_function_ends_with_an_error() -> None:
    with pytest.raises(piecewise.RoughFunctionError):
        piecewise.ChebyshevPanels.fit(lambda t: np.sin(1e6 * t)[None], np.linspace(0, 1, 9))


def perturb(random: np.random.Generator) -> tuple[Array, Array]:
    """Return polar angles [deg] and radii [mm] of a curve after one kind of damage, drawn at random."""
    polar, radius, row = POLAR.copy(), RADIUS.copy(), int(random.integers(60))
    kind = random.integers(11)
    if kind == 0:
        radius[row] *= random.uniform(0.2, 4)
    elif kind == 1:
        radius += 10 ** random.uniform(-3, 1.5) * random.standard_normal(60)
    elif kind == 2:
        radius *= 10 ** random.uniform(-14, 8)
    elif kind == 3:
        polar += 10 ** random.uniform(-3, 1) * random.standard_normal(60)
    elif kind == 4:
        polar, radius = polar[::-1], radius[::-1]
    elif kind == 5:
        polar, radius = np.insert(polar, row, polar[row]), np.insert(radius, row, radius[row])
    elif kind == 6:
        rows = random.uniform(size=60) > random.uniform(0, 0.8)
        polar, radius = polar[rows], radius[rows]
    elif kind == 7:
        polar += random.uniform(-1e3, 1e3)
    elif kind == 8:
        radius -= random.uniform(30, 45)
    elif kind == 9:
        radius = 40 + random.uniform(0, 60) * np.cos(np.radians(polar) * random.integers(1, 6))
    else:
        radius[row : row + int(random.integers(1, 30))] += random.uniform(-30, 60)
    return polar, radius


def load_perturbed(tmp_path: Path, seed: int) -> None:
    """Load one damaged curve, in seconds: a pair, or one sentence."""
    file = write_curve(tmp_path / "own.csv", *perturb(np.random.default_rng(seed)))
    begun, refused = time.process_time(), ""
    try:
        load_pair(file, None, 1)
    except PlanterError as error:
        refused = error.message
    assert not refused or str(tmp_path) in refused
    assert time.process_time() - begun < 20


@pytest.mark.parametrize("seed", range(6))
def test_perturbed_table_gives_pair_or_single_line(tmp_path: Path, seed: int) -> None:
    load_perturbed(tmp_path, seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6, 300))
def test_any_perturbed_table_gives_pair_or_single_line(tmp_path: Path, seed: int) -> None:
    load_perturbed(tmp_path, seed)


def test_clockwise_table_error_names_the_table_angle() -> None:
    with pytest.raises(PlanterError, match=r"at the polar angle 1[78]\d\.?\d* deg"):
        build_sampled_pair(np.radians(POLAR), replaced(30, 120.0) * 1e-3, "own", sense=-1)


@pytest.mark.parametrize("turns", [1, 3])
def test_mate_of_a_circle_is_a_circle(turns: int) -> None:
    pair = build_sampled_pair(np.radians(POLAR), np.full(60, 0.0317), "own", turns)
    assert pair.distance == pytest.approx(0.0317 * (1 + turns), rel=1e-12)
