"""Points that the path of the pick-up's tip must pass."""

from pathlib import Path

import numpy as np
import pytest

from planter.errors import InputError
from planter.files import examples
from planter.pickup import file
from planter.pickup.model import build_train
from planter.pickup.requirements import list_requirements
from tests.support.cli import answer, refusal

POINTS = [[-150.0, 90.0, 30.0], [150.0, 120.0, 5.0]]


def written(folder: Path, lines: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(examples.example("yu2023").replace("[tray]", f"[tip_path]\n{lines}\n\n[tray]", 1))
    return path


def test_each_point_is_a_requirement_with_the_distance_to_the_nearest_of_many_points(tmp_path: Path) -> None:
    machine = file.load_pickup(written(tmp_path, f"points_mm = {POINTS}"))
    train = build_train(machine)
    path = 1000 * train.tip(np.linspace(0, 2 * np.pi, 50_001))
    found = [one for one in list_requirements(machine, train) if one.name.startswith("path by point")]
    assert len(found) == len(POINTS)
    for one, (x, y, tube) in zip(found, POINTS, strict=True):
        distance = np.hypot(*(path - (x, y)).T).min()
        assert one.value == pytest.approx(distance, abs=1e-3)
        assert one.margin == pytest.approx(tube - one.value)
        assert one.t is not None
        assert np.hypot(*(1000 * train.tip(np.array([one.t]))[0] - (x, y))) == pytest.approx(one.value)


def test_a_point_on_the_path_is_passed(tmp_path: Path) -> None:
    x, y = 1000 * build_train(file.load_pickup("yu2023")).tip(np.array([1.234]))[0]
    machine = file.load_pickup(
        written(tmp_path, f"points_mm = [[{x!r}, {y!r}, 0.1]]".replace("np.float64(", "").replace(")", ""))
    )
    (found,) = [one for one in list_requirements(machine, build_train(machine)) if one.name == "path by point 1"]
    assert found.value < 1e-3
    assert found.t == pytest.approx(1.234, abs=1e-3)
    assert found.holds


def test_a_csv_beside_the_file_and_its_figure(tmp_path: Path) -> None:
    lines = "\n".join(",".join(map(str, point)) for point in POINTS)
    (tmp_path / "path.csv").write_text(f"x_mm,y_mm,tube_mm\n{lines}\n")
    found = answer("pickup", str(written(tmp_path, 'points_csv = "path.csv"')))
    assert [one["name"] for one in found["requirements"]][-2:] == ["path by point 1", "path by point 2"]


def test_what_is_no_point_is_refused(tmp_path: Path) -> None:
    told = refusal("pickup", str(written(tmp_path, "points_mm = [[1, 2]]")))
    assert "tip_path.points_mm[0]" in told
    with pytest.raises(InputError, match="there is no such file"):
        file.load_pickup(written(tmp_path, 'points_csv = "nowhere.csv"'))
