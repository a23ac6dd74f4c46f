"""What sliders do: each changes something that is shown, and none reaches a value that is not
allowed.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from planter.errors import PlanterError
from planter.files import examples
from planter.mechanism.show import MechanismView
from planter.report.animation import pack_scene
from planter.report.picture import draw_picture
from planter.report.scene import Scene
from planter.report.subject import Shown, Values, find_farthest, open_machine
from planter.studio.session import Session
from tests.support import own

MACHINES = [name for name in examples.list_examples(None, ".toml") if name != "compact"]
"""Built-in machines; `compact` is one of the kind of wang2017 with the same controls."""
SHARE = 0.05
"""Of the way to an end by which a number is moved."""
SLOW = {"sun2019", "sun2019-corrected"}
"""Machines whose readings take so long that the ends of their numbers are not computed."""


def read_all(machine: Shown, values: Values, last: Sequence[Any] = ()) -> tuple[Any, ...]:
    """Return what is shown of a machine, the cheapest first, as far as it is the same as before."""
    numbers: list[Any] = []
    for compute in (
        lambda: [asdict(reading) for reading in machine.readings(values, machine.models[0])],
        lambda: [asdict(reading) for reading in machine.checks(values, machine.models[0])],
        lambda: [_drawing(reading) for reading in machine.scenes(values, machine.models[0])],
        lambda: [asdict(reading) for reading in machine.details(values, machine.models[0])],
    ):
        numbers.append(compute())
        if last and numbers[-1] != last[len(numbers) - 1]:
            break
    return tuple(numbers)


def _drawing(scene: Scene) -> tuple[str, Any]:
    return draw_picture(scene), pack_scene(scene)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.long) if name in SLOW else name for name in MACHINES],
)
def test_every_control_changes_something_shown(name: str) -> None:
    machine = open_machine(name)
    defaults = {control.path: control.value for control in machine.controls}
    before = read_all(machine, defaults)
    for control in machine.controls:
        for end in (control.upper, control.lower):
            moved = {**defaults, control.path: control.value + SHARE * (end - control.value)}
            try:
                changed = read_all(machine, moved, before) != before
            except PlanterError:
                continue
            if changed:
                break
        else:
            pytest.fail(f"{name}: {control.path} changes nothing")


@pytest.mark.parametrize(
    "name", [pytest.param("shi2021", marks=pytest.mark.long), "wang2017", "yu2023"]
)
def test_ends_of_controls_make_a_machine(name: str, tmp_path: Path) -> None:
    session = Session(tmp_path, tmp_path / "scratch")
    session.open({"name": name})
    machine = session.machine
    assert machine
    defaults = {control.path: control.value for control in machine.controls}
    ends = session.ends({"values": defaults})["ends"]
    assert ends.keys() == defaults.keys()
    for path, pair in ends.items():
        assert pair[0] <= defaults[path] <= pair[1]
        for end in pair:
            machine.readings({**defaults, path: end}, machine.models[0])


def test_ends_follow_the_other_numbers(tmp_path: Path) -> None:
    """The cell of the tray is below its pitch, wherever that is."""
    session = Session(tmp_path, tmp_path / "scratch")
    session.open({"name": "yu2023"})
    far = []
    for pitch in (31, 40):
        ends = session.ends({"values": {"tray.cell_pitch_mm": pitch, "tray.cell_top_mm": 28}})[
            "ends"
        ]
        far.append(ends["tray.cell_top_mm"][1])
    assert 30.9 < far[0] < 31 < far[1] < 32


def test_controls_end_where_the_file_does(tmp_path: Path) -> None:
    """Limits of a key, those that hang on other keys, and numbers that can have no other value."""
    clutch, pickup = (
        {control.path: control for control in open_machine(name).controls}
        for name in ("shi2021", "yu2023")
    )
    assert 89.9 < clutch["linkage.rack_phase_deg"].upper <= 90
    assert 163 > pickup["bars.L2_mm"].lower > 93.3377
    assert "law.phi1_far_deg" not in pickup


@pytest.mark.parametrize("name", MACHINES)
def test_controls_have_names_of_a_page(name: str) -> None:
    """Words instead of keys, each once in its group, and no group between controls of another."""
    controls = open_machine(name).controls
    for control in controls:
        assert not re.search(r"_(deg|mm|kg|rpm|N|m_s|N_m)\b", control.name + control.group)
    assert len({(control.group, control.name) for control in controls}) == len(controls)
    groups = [control.group for control in controls]
    assert len([group for group, _ in itertools.groupby(groups)]) == len(set(groups))


def test_mechanism_shows_its_motor_and_joint_forces() -> None:
    """The torque that keeps the motion comes first, and arrows of the joints are those of the
    curves.
    """
    view = MechanismView(own.file("slider_crank"))
    (scene,) = view.scenes({control.path: control.value for control in view.controls}, "exact")
    curves = {curve.name: curve for curve in scene.curves}
    assert next(iter(curves)).endswith("(M_in)")
    arrows = {force.at.name: force for force in scene.forces}
    assert arrows.keys() == {"O", "A"}
    for name, force in arrows.items():
        for values, axis in ((force.x, "x"), (force.y, "y")):
            (curve,) = (
                curve for text, curve in curves.items() if text.endswith(f"(F_{name}{axis})")
            )
            assert values == pytest.approx(curve.values)
            assert curve.unit == "N"


def test_farthest_number_is_where_attempts_begin_to_fail() -> None:
    def attempt(number: float) -> None:
        if number > 7.3:
            raise PlanterError("too far")

    assert find_farthest(5.0, 7.0, attempt) == 7.0
    assert find_farthest(5.0, 10.0, attempt) == pytest.approx(7.3, abs=5 / 512)
    assert find_farthest(7.3, 10.0, attempt) == 7.3
    assert find_farthest(5.0, -10.0, attempt) == -10.0
