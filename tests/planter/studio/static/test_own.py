"""A mechanism of one's own in a page: its turn, with closed loops and without, as `planter turn`
finds it.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from planter.engine.wording import name_quantity
from planter.errors import NotFiniteError
from planter.kernels import programs
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.show import MechanismView
from tests.planter.studio.static.told import Told, written
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
    assert "no angle drives manipulator" in err
