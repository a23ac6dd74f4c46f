"""A mechanism of one's own in a page: its turn, with closed loops and without, as `planter turn`
finds it.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.engine.wording import name_quantity
from planter.errors import ComputationError, NotFiniteError
from planter.kernels import programs
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.show import MechanismView
from planter.report.scene import Scene
from planter.report.subject import Movable, Values, open_machine
from planter.studio.static_page import Recogniser, bundle_modules, file_template
from tests.planter.studio.static.told import Told, assert_drawn, written
from tests.support import own
from tests.support.cli import run
from tests.support.wasm import Running, difference, needs_wasm

CRANK, TRAIN = "slider_crank", "planetary_train"


def designs(machine: MechanismView, count: int) -> list[dict[str, float]]:
    """Its own numbers, then some by lot near them."""
    rng, defaults = (
        np.random.default_rng(3),
        {control.path: control.value for control in machine.controls},
    )
    return [
        defaults,
        *(
            {path: value * float(rng.uniform(0.95, 1.05)) for path, value in defaults.items()}
            for _ in range(count)
        ),
    ]


@pytest.mark.parametrize("name", [CRANK, TRAIN])
def test_program_equals_cycle(name: str) -> None:
    """Extremes of every result's samples and each drawn curve, loops closed in the same
    assembly.
    """
    machine = MechanismView(own.file(name))
    portable = machine.portable("exact")
    for values in designs(machine, 3):
        numbers = portable.at(values, portable.seen)
        singles = dict(zip(portable.singles, numbers["singles"], strict=True))
        expected = compute_cycle(Model(build_machine(machine.file.with_numbers(values))))
        names = {quantity.key: name_quantity(quantity) for quantity in expected.machine.results}
        for key in expected.result.quantities:
            column = expected.columns[key]
            scale = np.abs(column).max()
            assert singles[f"{names[key]}, largest"] == pytest.approx(
                column.max(), abs=1e-12 * scale
            )
            assert singles[f"{names[key]}, least"] == pytest.approx(column.min(), abs=1e-12 * scale)
        assert singles["sound"] == 1


def test_open_loops_are_no_machine() -> None:
    """A rod shorter than the crank: what is found is not finite, which a page says in a
    sentence.
    """
    machine = MechanismView(own.file(CRANK))
    portable = machine.portable("exact")
    values = {control.path: control.value for control in machine.controls}
    with pytest.raises(NotFiniteError):
        portable.at(values | {"values.l_mm": 0.5 * values["values.r_mm"]}, portable.seen)


@needs_wasm
def test_webassembly_finds_the_same() -> None:
    machine = MechanismView(own.file(CRANK))
    portable = machine.portable("exact")
    running = Running(programs.build_webassembly(portable.programs))
    for values in designs(machine, 3):
        expected = portable.at(values, portable.seen)
        results = running.vectors(portable.seen, data=expected["data"])
        assert results is not None
        assert (
            difference(
                {key: results[key] for key in ("rows", "singles", "loops")},
                {key: expected[key] for key in ("rows", "singles", "loops")},
            )
            < 1e-12
        )
    assert running.vectors(portable.seen, data=0.5 * np.ones(len(expected["data"]))) is None


@needs_wasm
def test_page_has_no_local_paths_and_no_search(tmp_path: Path) -> None:
    own.file(CRANK)
    page: Told = written(tmp_path, str(own.generated(CRANK) / f"{CRANK}.toml"))
    assert page.machine["search"] is None
    assert str(own.generated(CRANK)) not in page.html
    assert not re.search(r"^folder", "\n".join(page.machine["file"]["lines"]), re.MULTILINE)
    assert json.dumps(page.machine["models"]["exact"]["plan"])


def test_undriven_mechanism_is_refused(tmp_path: Path) -> None:
    file = own.generated("manipulator") / "manipulator.toml"
    code, out, err = run(f"studio {file} --static", str(tmp_path / "page.html"))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "manipulator moves freely" in err


NAMES = ("wang2017-wide", "slider_crank")


@cache
def machine(name: str) -> Movable:
    machine = MechanismView(own.file(name)) if name == "slider_crank" else open_machine(name)
    assert isinstance(machine, Movable)
    return machine


def draw_values(name: str, count: int) -> tuple[list[Values], list[Scene]]:
    """Designs near the machine's own, by lot, and what is drawn of them."""
    subject, rng = machine(name).rigid, np.random.default_rng(5)
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
