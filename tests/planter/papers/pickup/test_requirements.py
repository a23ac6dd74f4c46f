"""Requirements of the path, its points among them, and the printed numbers behind them; each has a
case that breaks it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planter.files import examples
from planter.papers.pickup import file
from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.model import PickupTrain, build_train
from planter.papers.pickup.requirements import Cell, CellEntry, find_push, list_requirements
from planter.papers.pickup.results import Demand
from tests.planter.papers.pickup.pickups import L1, L2, law

MACHINE = load_pickup("yu2023")
TRAIN = build_train(MACHINE)


def by_name(train: PickupTrain = TRAIN, **changes: float) -> dict[str, Demand]:
    return {
        requirement.name: requirement
        for requirement in list_requirements(load_pickup("yu2023", changes), train)
    }


def entry(train: PickupTrain = TRAIN, **changes: float) -> CellEntry:
    return CellEntry(train, replace(Cell.from_pickup(MACHINE), **changes))


def test_printed_numbers() -> None:
    """L1, L2, a2, gamma as printed; the helix angle is within the printed range and the contact
    ratio near 1.9358.
    """
    g = TRAIN.geometry
    assert (g.L1, g.L2, g.a2) == pytest.approx((0.0933377, 0.163, 0.0446))
    assert 8 < np.degrees(g.helix) < 20
    assert np.cos(g.helix) == pytest.approx(2 * 42 / 2 / 44.6)
    assert g.helical_contact_ratio == pytest.approx(1.9358, abs=2e-4)
    assert g.a1 > g.a2


def test_contact_ratio_equals_osculating_circles() -> None:
    """External spur gears on those circles, from their tip and base circles (ISO 21771)."""
    t, angle, m = TRAIN.samples(50), np.radians(20), 0.002
    radii = [1 / TRAIN.pitch(t)[key] for key in ("kappa1", "kappa2")]
    reach = sum(
        np.sqrt((r + 1.2 * m) ** 2 - (r * np.cos(angle)) ** 2) - r * np.sin(angle) for r in radii
    )
    assert TRAIN.contact_ratio(t) == pytest.approx(reach / (np.pi * m * np.cos(angle)))


def test_the_arm_swings_fifty_degrees_under_the_law_made_for_it() -> None:
    """The variant of the digest: dwell of 87.0766 deg about 240 deg."""
    swinging = law(0.2322871381, *np.radians([240 - 87.0766 / 2, 240 + 87.0766 / 2]))
    assert swinging.mean_on_teeth == pytest.approx(1.2761830240, abs=1e-6)
    train = replace(TRAIN, law=swinging)
    assert np.degrees(find_push(train)[1]) == pytest.approx(50, abs=1e-3)
    requirements = by_name(train)
    assert requirements["push angle"].value == pytest.approx(90, abs=1e-3)
    assert requirements["push angle"].holds
    assert requirements["push angle less pick angle"].holds


def test_depth_and_straight_entry() -> None:
    requirements = by_name()
    assert requirements["entry depth"].value == pytest.approx(35)
    assert requirements["straight entry"].holds
    tip = TRAIN.tip(np.linspace(0, -np.pi / 2, 4000))
    assert np.linalg.norm(tip[0]) == pytest.approx(L1 + L2)
    chord = requirements["straight entry"].value / 1000
    end = int(np.argmin(np.abs(np.hypot(*(tip - tip[0]).T) - chord)))
    ahead = (tip[end] - tip[0]) / np.hypot(*(tip[end] - tip[0]))
    gone = tip[: end + 1] - tip[0]
    offset = np.abs(ahead[0] * gone[:, 1] - ahead[1] * gone[:, 0])
    assert offset.max() * 1000 == pytest.approx(1.0, abs=5e-3)
    assert entry().straight(0.0001) < entry().straight(0.001) < entry().straight(0.004)
    assert not by_name(straightness_mm=0.1)["straight entry"].holds


def test_upright_needle_clearance_equals_trapezium() -> None:
    """Tip corner against the inclined wall, by similar triangles, at the pick."""
    cell = Cell.from_pickup(MACHINE)
    corner = entry().needle(0.0)[0]
    half = (cell.top - (cell.top - cell.bottom) * corner[0] / cell.depth) / 2
    slope = (cell.top - cell.bottom) / 2 / cell.depth
    by_hand = (half - cell.needle_width / 2) / np.hypot(1, slope)
    gap, _ = entry().clearance()
    assert gap < by_hand
    still = replace(TRAIN, law=law(0.0, np.radians(210), np.radians(270)))
    assert corner == pytest.approx([0.035, -0.005])
    assert CellEntry(still, cell).needle(0.0) == pytest.approx(entry().needle(0.0))


def test_a_needle_too_wide_or_too_deep_cuts_the_tray() -> None:
    assert entry().clearance()[0] > 0
    assert entry(needle_width=0.020).clearance()[0] < 0
    assert entry(entry=0.050).clearance()[0] < -0.004
    assert entry(mounting=np.radians(40)).clearance()[0] > -0.1
    assert not by_name(width_mm=22)["needle to tray"].holds


def test_a_hollow_pitch_curve_is_noticed() -> None:
    hollow = replace(TRAIN, law=law(0.93, np.radians(210), np.radians(270)))
    requirements = by_name(hollow)
    assert not (
        requirements["sun's pitch curve convex"].holds
        and requirements["intermediate gear's convex"].holds
    )


POINTS = [[-150.0, 90.0, 30.0], [150.0, 120.0, 5.0]]


def written(folder: Path, lines: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(
        examples.example("yu2023").replace("[tray]", f"[tip_path]\n{lines}\n\n[tray]", 1)
    )
    return path


def test_each_point_is_a_distance_requirement(tmp_path: Path) -> None:
    machine = file.load_pickup(written(tmp_path, f"points_mm = {POINTS}"))
    train = build_train(machine)
    path = 1000 * train.tip(np.linspace(0, 2 * np.pi, 50_001))
    requirements = [
        requirement
        for requirement in list_requirements(machine, train)
        if requirement.name.startswith("path by point")
    ]
    assert len(requirements) == len(POINTS)
    for requirement, (x, y, tube) in zip(requirements, POINTS, strict=True):
        distance = np.hypot(*(path - (x, y)).T).min()
        assert requirement.value == pytest.approx(distance, abs=1e-3)
        assert requirement.margin == pytest.approx(tube - requirement.value)
        assert requirement.t_deg is not None
        assert np.hypot(
            *(1000 * train.tip(np.radians([requirement.t_deg]))[0] - (x, y))
        ) == pytest.approx(requirement.value)
