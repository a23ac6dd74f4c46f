"""Paths that are wished: points on a machine's own path, which a hand draws about and a search
follows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.errors import InputError
from planter.papers.pickup.file import load_pickup
from planter.report.subject import Searching, Shown, Wishing, open_machine


def values(machine: Shown) -> dict[str, float]:
    return {control.path: control.value for control in machine.controls}


def wished(source: str, folder: Path) -> tuple[Shown, Shown]:
    """A machine, and what comes of its file with a wished path."""
    machine = open_machine(source)
    assert isinstance(machine, Wishing)
    (folder / "wished.toml").write_text(machine.wished(values(machine)), encoding="utf-8")
    return machine, open_machine(str(folder / "wished.toml"))


def test_pickup_on_same_path_is_unchanged_and_follows_points(tmp_path: Path) -> None:
    """The law's gears come back from points on the path; a point that is drawn away takes the path
    along.
    """
    machine, changed = wished("yu2023", tmp_path)
    readings, changed_readings = (
        [reading.value for reading in each.readings(values(each), "exact")]
        for each in (machine, changed)
    )
    assert changed_readings == pytest.approx(readings, abs=1e-3)
    moved = values(changed)
    x, y = changed.handles[12]
    moved[x], moved[y] = moved[x] + 2.0, moved[y] - 1.0
    for numbers, passes in ((moved, True), (values(changed), False)):
        tip = changed.scenes(numbers, "exact")[0].points[0]
        distance = np.hypot(np.asarray(tip.x) - moved[x], np.asarray(tip.y) - moved[y]).min()
        assert bool(distance < 0.5) == passes


def test_planting_device_stays_within_path_tubes(tmp_path: Path) -> None:
    """Within the whole radius of their tubes; drawn away, a point breaks the requirement that a
    search keeps.
    """
    _, changed = wished("wang2017-wide", tmp_path)
    numbers = values(changed)
    check = next(check for check in changed.checks(numbers, "exact") if "tube" in check.name)
    assert check.value == pytest.approx(-10.0, abs=1e-3)
    numbers[changed.handles[2][0]] += 60.0
    broken = next(check for check in changed.checks(numbers, "exact") if "tube" in check.name)
    assert not broken.met
    assert isinstance(changed, Searching)
    assert changed.search == ("optimise",)


def test_only_machines_with_paths_accept_wishes() -> None:
    assert not isinstance(open_machine("shi2021"), Wishing)
    still = open_machine("wang2017")
    assert isinstance(still, Wishing)
    assert not still.wishes  # it does not travel: requirements are of no use


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        (
            'csv = "yu2023-path"\npoints_mm = POINTS',
            "there must be either csv or points_mm, not both",
        ),
        ("tolerance_mm = 1.0", "there must be either csv or points_mm"),
        ("points_mm = [[1.0, 2.0]]", "at least 12"),
        ("points_mm = TWICE", r"path.points_mm\[4\] = \[3.0, 9.0\]: neighbours must differ"),
    ],
)
def test_a_path_of_no_use_is_refused(path: str, sentence: str, tmp_path: Path) -> None:
    points = [[float(k), float(k * k)] for k in range(14)]
    twice = [*points[:3], points[3], points[3], *points[4:]]
    machine = open_machine("yu2023")
    assert isinstance(machine, Wishing)
    text = machine.wished(values(machine))
    start = text.index("[path]")
    rest = text[text.index("[", start + 6 + text[start + 6 :].index("]]")) :]
    user_path = path.replace("POINTS", str(points)).replace("TWICE", str(twice))
    (tmp_path / "own.toml").write_text(
        f"{text[:start]}[path]\n{user_path}\n\n{rest}", encoding="utf-8"
    )
    with pytest.raises(InputError, match=sentence):
        load_pickup(tmp_path / "own.toml")
