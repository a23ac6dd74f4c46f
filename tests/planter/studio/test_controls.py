"""What sliders do: each changes something that is shown, and none reaches a value that is not allowed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from planter.errors import PlanterError
from planter.files import examples
from planter.studio.session import Session
from planter.view.animation import packed
from planter.view.picture import picture
from planter.view.scene import Scene
from planter.view.subject import Shown, Values, farthest, opened

MACHINES = [name for name in examples.names(None, ".toml") if name != "compact"]
"""Built-in machines; `compact` is one of the kind of wang2017 with the same controls."""
SHARE = 0.05
"""Of the way to an end by which a number is moved."""
SLOW = {"sun2019", "sun2019-corrected"}
"""Machines whose readings take so long that the ends of their numbers are not computed."""


def shown(machine: Shown, values: Values, last: Sequence[Any] = ()) -> tuple[Any, ...]:
    """Return what is shown of a machine, the cheapest first, as far as it is the same as before."""
    found: list[Any] = []
    for compute in (
        lambda: [asdict(one) for one in machine.readings(values, machine.models[0])],
        lambda: [asdict(one) for one in machine.checks(values, machine.models[0])],
        lambda: [_drawing(one) for one in machine.scenes(values, machine.models[0])],
        lambda: [asdict(one) for one in machine.details(values, machine.models[0])],
    ):
        found.append(compute())
        if last and found[-1] != last[len(found) - 1]:
            break
    return tuple(found)


def _drawing(scene: Scene) -> tuple[str, Any]:
    return picture(scene), packed(scene)


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.long) if one in SLOW else one for one in MACHINES]
)
def test_every_control_changes_something_shown(name: str) -> None:
    machine = opened(name)
    own = {one.path: one.value for one in machine.controls}
    before = shown(machine, own)
    for one in machine.controls:
        for end in (one.upper, one.lower):
            moved = {**own, one.path: one.value + SHARE * (end - one.value)}
            try:
                changed = shown(machine, moved, before) != before
            except PlanterError:
                continue
            if changed:
                break
        else:
            pytest.fail(f"{name}: {one.path} changes nothing")


@pytest.mark.parametrize("name", [pytest.param("shi2021", marks=pytest.mark.long), "wang2017", "yu2023"])
def test_ends_of_controls_make_a_machine(name: str, tmp_path: Path) -> None:
    session = Session(tmp_path, tmp_path / "scratch")
    session.open({"name": name})
    machine = session.machine
    assert machine
    own = {one.path: one.value for one in machine.controls}
    ends = session.ends({"values": own})["ends"]
    assert ends.keys() == own.keys()
    for path, pair in ends.items():
        assert pair[0] <= own[path] <= pair[1]
        for end in pair:
            machine.readings({**own, path: end}, machine.models[0])


def test_ends_follow_the_other_numbers(tmp_path: Path) -> None:
    """The cell of the tray is below its pitch, wherever that is."""
    session = Session(tmp_path, tmp_path / "scratch")
    session.open({"name": "yu2023"})
    far = []
    for pitch in (31, 40):
        ends = session.ends({"values": {"tray.cell_pitch_mm": pitch, "tray.cell_top_mm": 28}})["ends"]
        far.append(ends["tray.cell_top_mm"][1])
    assert 30.9 < far[0] < 31 < far[1] < 32


def test_controls_end_where_the_file_does(tmp_path: Path) -> None:
    """Limits of a key, those that hang on other keys, and numbers that can have no other value."""
    clutch, pickup = ({one.path: one for one in opened(name).controls} for name in ("shi2021", "yu2023"))
    assert 89.9 < clutch["linkage.rack_phase_deg"].upper <= 90
    assert 163 > pickup["bars.L2_mm"].lower > 93.3377
    assert "law.phi1_far_deg" not in pickup


def test_farthest_number_is_where_attempts_begin_to_fail() -> None:
    def attempt(number: float) -> None:
        if number > 7.3:
            raise PlanterError("too far")

    assert farthest(5.0, 7.0, attempt) == 7.0
    assert farthest(5.0, 10.0, attempt) == pytest.approx(7.3, abs=5 / 512)
    assert farthest(7.3, 10.0, attempt) == 7.3
    assert farthest(5.0, -10.0, attempt) == -10.0
