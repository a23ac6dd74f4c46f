"""Pick-ups as machines of the engine: the numbers of their trains, with derivatives that
differences confirm.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import Machine, load_machine
from planter.papers.pickup import file
from planter.papers.pickup.machines import build_machine, takes
from planter.papers.pickup.model import PickupTrain, build_train
from planter.papers.pickup.requirements import Cell, CellEntry
from tests.planter.papers.pickup.pickups import steps, tips
from tests.planter.papers.pickup.test_laws import smooth_file
from tests.support.responses import values_of

ANGLES = np.concatenate([np.radians(np.arange(-30, 400, 5)), steps(37, 0.3)])
"""Carrier angles, both ends of the dwell among them."""


@pytest.fixture(scope="module", params=["law", "smooth law", "path with a dwell", "closed path"])
def source(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Files of all kinds of laws."""
    folder = tmp_path_factory.mktemp("pickups")
    if request.param == "smooth law":
        return smooth_file(folder)
    if request.param == "closed path":
        t = steps(24)
        rows = [f"{x:.9f},{y:.9f}" for x, y in 1e3 * tips(t, np.pi + t + 0.3 * np.sin(t))]
        (folder / "path.csv").write_text("\n".join(["x_mm,y_mm", *rows]))
        return str(folder / "path.csv")
    return {"law": "yu2023", "path with a dwell": "yu2023-path"}[str(request.param)]


@cache
def train_of(source: str) -> tuple[file.Pickup, PickupTrain, Machine]:
    machine = file.load_pickup(source)
    train = build_train(machine)
    return machine, train, build_machine(machine, train)


def test_motion_equals_train(source: str) -> None:
    pickup, train, machine = train_of(source)
    values, expected = values_of(machine, ANGLES), train.motion(ANGLES)
    entry = CellEntry(train, Cell.from_pickup(pickup)).place(ANGLES).T
    expected |= {
        "phi1": train.law.arm(ANGLES),
        "g": train.slope(ANGLES),
        "arm": train.arm_heading(ANGLES),
    }
    expected |= {"along": entry[0], "across": entry[1]}
    for name in set(expected) & set(values):
        np.testing.assert_allclose(values[name], expected[name], rtol=0, atol=1e-12, err_msg=name)
    assert len(set(expected) & set(values)) == 14


def test_gears_are_those_of_the_train(source: str) -> None:
    _, train, machine = train_of(source)
    angles = ANGLES[train.meshes(ANGLES)]
    values, expected = values_of(machine, angles), train.pitch(angles)
    for name in ("R1", "R2", "kappa1", "kappa2"):
        np.testing.assert_allclose(values[name], expected[name], rtol=1e-12, err_msg=name)
    np.testing.assert_allclose(values["epsilon"], train.contact_ratio(angles), rtol=1e-12)
    np.testing.assert_allclose(values["beta"], train.geometry.helix, rtol=1e-14)
    np.testing.assert_allclose(values["R1"] + values["R2"], train.geometry.a1, rtol=1e-14)


def test_changes_and_other_files(tmp_path: Path) -> None:
    machine = load_machine("yu2023", {"L2_mm": 150.0, "speed_deg_per_s": 180.0})
    assert machine.data[machine.find_index("bars.L2_mm")] == pytest.approx(0.15)
    assert machine.data[machine.speed] == pytest.approx(np.pi)
    assert not any(takes(name) for name in ("sun2019-curve", "wang2017"))
    assert takes("yu2023-path")
    (tmp_path / "other.csv").write_text("carrier_deg,relative_deg\n0,0\n")
    assert not takes(str(tmp_path / "other.csv"))
