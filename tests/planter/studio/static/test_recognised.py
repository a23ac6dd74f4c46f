"""What a page is made of, without the compiler: which numbers a drawing shows, the file that it
writes, its script.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.mechanism.show import MechanismView
from planter.report.scene import Scene
from planter.report.subject import Movable, Values, open_machine
from planter.studio.static_model import Recogniser
from planter.studio.static_page import bundle_modules, file_template
from tests.planter.studio.static.told import assert_drawn
from tests.support import own

NAMES = ("wang2017-wide", "slider_crank")


@cache
def machine(name: str) -> Movable:
    machine = MechanismView(own.file(name)) if name == "slider_crank" else open_machine(name)
    assert isinstance(machine, Movable)
    return machine


def draw_values(name: str, count: int) -> tuple[list[Values], list[Scene]]:
    """Designs near the machine's own, by lot, and what is drawn of them."""
    subject, rng = machine(name), np.random.default_rng(5)
    designs = [
        {
            control.path: control.value
            + 0.2 * float(rng.uniform(-1, 1)) * (control.upper - control.value + 1e-3)
            for control in subject.controls
        }
        for _ in range(count)
    ]
    return designs, [subject.scenes(values, "exact")[0] for values in designs]


@pytest.mark.parametrize("name", NAMES)
def test_recognised_formulas_hold_for_other_designs(name: str) -> None:
    portable = machine(name).portable("exact")
    designs, scenes = draw_values(name, 4)
    plan = Recogniser(portable, designs[:3], scenes[:3]).plan()
    assert len(plan.channels) > 10
    vectors = portable.at(designs[3], portable.seen)
    numbers = np.concatenate(list(vectors.values()))
    assert_drawn(plan.__dict__, numbers, scenes[3])


@pytest.mark.parametrize("name", NAMES)
def test_readings_are_the_machine_s(name: str) -> None:
    subject, portable = machine(name), machine(name).portable("exact")
    values = draw_values(name, 1)[0][0]
    singles = dict(
        zip(portable.singles, portable.at(values, portable.seen)["singles"], strict=True)
    )
    expected = {reading.name: reading.value for reading in subject.readings(values, "exact")}
    scale = max(map(abs, expected.values()))
    # a page without a server has the extremes of its samples, which lie inside the true ones
    assert {key: singles[key] for key in expected} == pytest.approx(
        expected, rel=1e-3, abs=1e-3 * scale
    )


def test_curve_following_no_number_is_detected() -> None:
    portable = machine("wang2017-wide").portable("exact")
    designs, scenes = draw_values("wang2017-wide", 3)
    strange = replace(scenes[1].curves[0], values=scenes[1].curves[0].values * (1 + 1e-6))
    tampered = [scenes[0], replace(scenes[1], curves=[strange, *scenes[1].curves[1:]]), scenes[2]]
    with pytest.raises(ComputationError, match=r"cannot follow its \['curves', 0, 'values'\]"):
        Recogniser(portable, designs, tampered).plan()


@pytest.mark.parametrize("name", NAMES)
def test_file_written_by_line_equals_planter(name: str) -> None:
    subject = machine(name)
    template = file_template(subject, subject.controls)
    values = {control.path: control.value for control in subject.controls}
    for count in (0, 1, len(values)):
        moved = {
            control.path: control.value + 0.25 * (control.upper - control.value)
            for control in list(subject.controls)[:count]
        }
        assert edited(template, moved) == subject.handed(values | moved)


def edited(template: dict[str, Any], moved: Values) -> str:
    """As the page's script does it."""
    lines = list(template["lines"])
    paths = sorted(moved, key=lambda path: -template["edits"][path][0]["from"])
    edits = [
        {**edit, "value": repr(moved[path])} for path in paths for edit in template["edits"][path]
    ]
    for edit in sorted(edits, key=lambda change: -change["from"]):
        lines[edit["from"] : edit["to"]] = [
            line.replace("{}", edit["value"], 1) for line in edit["lines"]
        ]
    return "\n".join(lines) + "\n"


def test_modules_become_a_single_scoped_script() -> None:
    modules = {
        "one": (
            "export const digits = (x) => x;\nconst own = 1;\nexport class Two {}\nexport "
            "default { own };\n"
        ),
        "two": (
            'import { digits, Two } from "./one.js";\nexport async function three() { return '
            "digits(new Two()); }\n"
        ),
    }
    script = bundle_modules(modules)
    assert "import " not in script
    assert "export " not in script
    assert "return { digits, Two };" in script
    assert "const { digits, Two } = modules.one;" in script
    assert "return { three };" in script
