"""Points that the path of the pick-up's tip must pass."""

from pathlib import Path

import numpy as np
import pytest

from planter.files import examples
from planter.papers.pickup import file
from planter.papers.pickup.model import build_train
from planter.papers.pickup.requirements import list_requirements

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


def test_a_point_on_the_path_is_passed(tmp_path: Path) -> None:
    x, y = 1000 * build_train(file.load_pickup("yu2023")).tip(np.array([1.234]))[0]
    machine = file.load_pickup(
        written(
            tmp_path,
            f"points_mm = [[{x!r}, {y!r}, 0.1]]".replace("np.float64(", "").replace(")", ""),
        )
    )
    (requirement,) = [
        requirement
        for requirement in list_requirements(machine, build_train(machine))
        if requirement.name == "path by point 1"
    ]
    assert requirement.value < 1e-3
    assert requirement.t_deg == pytest.approx(np.degrees(1.234), abs=0.06)
    assert requirement.holds
