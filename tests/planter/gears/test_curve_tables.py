"""Tables of pitch curves: one closed turn, or one sentence, in seconds and bounded memory."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from planter.errors import PlanterError
from planter.gears.geometry.pitch_curves import POLAR as POLAR_ROW
from planter.gears.geometry.pitch_curves import SampledRadius
from planter.gears.request import GearTurns, load_pair
from planter.kernels import Array
from tests.support.cli import answer, refusal

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
    assert message in refusal(f"gears --curve {file} --module 2")


def test_radius_without_closure_exits_2(tmp_path: Path) -> None:
    for end, message in ((1.001, "radius_mm: 42.8"), (1.0, None)):
        radius = np.append(RADIUS, end * RADIUS[0])
        file = write_curve(tmp_path / "own.csv", np.append(POLAR, 360.0), radius)
        if message:
            assert message in refusal(f"gears --curve {file} --module 2")
        else:
            assert load_pair(file, None).sense == 1


@pytest.mark.parametrize("dropped", [[7], [20, 21, 22], [30, 59]])
def test_missing_rows_within_the_spacing_are_allowed(tmp_path: Path, dropped: list[int]) -> None:
    rows = np.delete(np.arange(60), dropped)
    pair = load_pair(write_curve(tmp_path / "own.csv", POLAR[rows], RADIUS[rows]), None)
    assert pair.gear.length == pytest.approx(0.2517, rel=2e-3)


IMPOSSIBLE = {
    "one radius of 120": (replaced(30, 120.0), "must be at most 80°"),
    "nearly nothing": (RADIUS * 1e-12, "must be at least 0.01 mm"),
    "too many": (np.full(4001, 40.0), "4001 points"),
    "no mate": (
        np.maximum(100 * np.exp(-4.0 * np.abs(np.linspace(-np.pi, np.pi, 361)[:-1])), 1),
        "no mate rolls",
    ),
    "through its axis": (
        np.where(np.isin(np.arange(60), [30, 31]), 0.05, RADIUS),
        "it must be above 0",
    ),
}


@pytest.mark.parametrize("kind", IMPOSSIBLE)
def test_impossible_curve_is_refused_in_seconds(tmp_path: Path, kind: str) -> None:
    radius, message = IMPOSSIBLE[kind]
    file = write_curve(tmp_path / "own.csv", np.arange(len(radius)) * 360 / len(radius), radius)
    begun = time.process_time()
    assert message in refusal(f"gears --curve {file} --module 2")
    assert time.process_time() - begun < 5


def perturb(random: np.random.Generator) -> tuple[Array, Array]:
    """Return polar angles [deg] and radii [mm] of a curve after one kind of damage, drawn at
    random.
    """
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


SEEDS = [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 300))]


@pytest.mark.parametrize("seed", SEEDS)
def test_perturbed_table_gives_pair_or_single_line(tmp_path: Path, seed: int) -> None:
    """In seconds."""
    file = write_curve(tmp_path / "own.csv", *perturb(np.random.default_rng(seed)))
    begun, refused = time.process_time(), ""
    try:
        load_pair(file, None)
    except PlanterError as error:
        refused = error.message
    assert not refused or str(tmp_path) in refused
    assert time.process_time() - begun < 20


def test_clockwise_table_error_names_the_table_angle() -> None:
    with pytest.raises(PlanterError, match=r"at the polar angle 1[78]\d\.?\d* deg"):
        SampledRadius(np.radians(POLAR), replaced(30, 120.0) * 1e-3, "own", -1).build_pair()


@pytest.mark.parametrize("turns", [1, 3])
def test_mate_of_a_circle_is_a_circle(turns: int) -> None:
    pair = SampledRadius(np.radians(POLAR), np.full(60, 0.0317), "own").build_pair(turns)
    assert pair.distance == pytest.approx(0.0317 * (1 + turns), rel=1e-12)


DEGREES = np.arange(360.0)
CORNERS = {
    "convex": (30 + 5 * np.exp(-np.abs((DEGREES - 270) / 50)), 270.0),
    "concave": (30 + 4 * np.abs(np.sin(np.radians(DEGREES - 140))), 140.0),
    "shallow": (30 + 1.0 * np.abs((DEGREES - 200 + 180) % 360 - 180) / 180, 200.0),
    "between rows": (30 + 4 * np.abs(np.sin(np.radians(DEGREES - 140.4))), 140.4),
}


@pytest.mark.parametrize("kind", CORNERS)
def test_corner_is_refused_with_its_place(tmp_path: Path, kind: str) -> None:
    radius, place = CORNERS[kind]
    message = refusal(
        "gears --curve", write_curve(tmp_path / "own.csv", DEGREES, radius), "--module", "2"
    )
    assert "corner" in message
    polar = float(message.partition("polar angle ")[2].partition("°")[0])
    assert min(abs(polar - place - k * 180) for k in (-1, 0, 1)) <= 1


CROWDED = np.unique(np.concatenate([np.arange(0, 360, 3.0), 100 + np.arange(100) / 10]))
SMOOTH = {
    "lobes": (DEGREES, 30 / (1 - 0.25 * np.cos(2 * np.radians(DEGREES)))),
    "seven waves": (DEGREES, 40 + np.cos(7 * np.radians(DEGREES))),
    "a narrow bump": (DEGREES, 40 + 0.3 * np.exp(-(((DEGREES - 90) / 3) ** 2))),
    "a jump of the curvature": (
        DEGREES,
        40 + np.where(DEGREES < 180, 3e-4 * DEGREES * (180 - DEGREES), 0.0) ** 2 / 20,
    ),
    "three decimals": (DEGREES, np.round(40 + 3 * np.cos(np.radians(DEGREES)), 3)),
    "crowded rows": (CROWDED, 40 + 3 * np.cos(np.radians(CROWDED))),
}
"""Steps of crowded rows vary by a factor of 30: a smooth curve bends in proportion to them."""


@pytest.mark.parametrize("kind", SMOOTH)
def test_smooth_table_has_no_corner(tmp_path: Path, kind: str) -> None:
    assert load_pair(write_curve(tmp_path / "own.csv", *SMOOTH[kind]), None).sense == 1


AXES, MEAN, SWING = 60.0, 2, 0.25
"""Distance of the axes [mm] of a gear whose mate turns MEAN times as fast, with a swing of that
ratio.
"""


def faster_mate(lobes: int = MEAN) -> Array:
    ratio = MEAN * (1 + SWING * np.cos(lobes * np.radians(DEGREES)))
    return AXES * ratio / (1 + ratio)


def test_unclear_turns_are_asked_for(tmp_path: Path) -> None:
    file = write_curve(tmp_path / "own.csv", DEGREES, faster_mate())
    message = refusal(f"gears --curve {file} --teeth 40 --turns 2")
    assert "--turns 2:1 or --turns 1:2" in message
    assert "60 mm" in message


def test_faster_mate_closes_at_its_distance(tmp_path: Path) -> None:
    file = write_curve(tmp_path / "own.csv", DEGREES, faster_mate())
    (stage,) = answer(f"gears --curve {file} --teeth 40,20 --turns 1:2")["stages"]
    assert stage["centre_distance_mm"] == pytest.approx(AXES, abs=1e-6)
    assert stage["z"] == [20, 40]
    assert [gear["name"] for gear in stage["gears"]] == ["mate", "gear"]
    assert stage["perimeter_mm"][1] == pytest.approx(2 * stage["perimeter_mm"][0], rel=1e-11)
    assert stage["transmission_error_rad"] < 1e-11
    assert stage["overlap_mm2"] < 1e-9
    pair = load_pair(file, None, GearTurns(1, 2))
    slower = load_pair(file, None, GearTurns(2, 1, is_stated=True))
    assert slower.distance > 0.1
    assert slower.mate.length == pytest.approx(2 * slower.gear.length, rel=1e-11)
    rows = pair.mate.at(np.linspace(0, pair.mate.length, 900, endpoint=False))
    expected = AXES * (1 - 1 / (1 + MEAN * (1 + SWING * np.cos(2 * rows[POLAR_ROW])))) * 1e-3
    np.testing.assert_allclose(np.hypot(*rows[:2]), expected, rtol=1e-7)


def test_mate_in_a_file_tells_the_turns(tmp_path: Path) -> None:
    """The table of the faster mate fits the pair that turns so, and not the slower one."""
    file = write_curve(tmp_path / "own.csv", DEGREES, faster_mate())
    pair = load_pair(file, None, GearTurns(1, 2))
    rows = pair.gear.at(np.linspace(0, pair.gear.length, 720, endpoint=False))
    mate = write_curve(
        tmp_path / "mate.csv", np.degrees(rows[POLAR_ROW])[::-1], 1e3 * np.hypot(*rows[:2])[::-1]
    )
    assert load_pair(file, mate, GearTurns(1, 2)).distance == pytest.approx(pair.distance)
    with pytest.raises(PlanterError, match="the conjugate of the gear has"):
        load_pair(file, mate, GearTurns(2, 1))


def test_mate_needs_a_curve_that_repeats(tmp_path: Path) -> None:
    file = write_curve(tmp_path / "own.csv", DEGREES, faster_mate(lobes=1))
    message = refusal(f"gears --curve {file} --teeth 40 --turns 1:2")
    assert "must repeat after 180°" in message


@pytest.mark.parametrize("text", ["0", "2:3", "x", "1:2:3", "21", "-1", ":2"])
def test_invalid_turns_are_refused(text: str) -> None:
    with pytest.raises(PlanterError, match=f"--turns {text}"):
        GearTurns.parse(text)
