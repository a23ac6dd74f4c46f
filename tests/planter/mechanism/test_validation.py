"""`planter validate` of machines that are no planting device: cycles, limits, bounds, starts of
free motions.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from planter.cli.app import build_application
from planter.engine.machine import load_machine
from planter.files import examples
from planter.mechanism import file
from planter.mechanism.cycle import validate_machine
from planter.mechanism.motion import validate_free_motion
from tests.support import own
from tests.support.cli import answer

SLIDER_CRANK = "slider_crank"
OTHERS = [
    name
    for name in examples.list_examples(suffix=".toml")
    if name in ("yu2023", "shi2021", "sun2019-corrected")
]


def _source(name: str) -> str:
    return str(own.generated(name) / f"{name}.toml")


def _with_limit(folder: Path, limit: str) -> str:
    """The file of the slider-crank with a limit."""
    text = Path(_source(SLIDER_CRANK)).read_text(encoding="utf-8")
    path = folder / "limited.toml"
    functions = f'functions = "{SLIDER_CRANK}"\n'
    assert functions in text
    place = f'folder = "{own.generated(SLIDER_CRANK)}"\n'
    path.write_text(
        text.replace(functions, functions + place) + f"\n[requirements]\nhold = ['{limit}']\n"
    )
    return str(path)


@pytest.mark.parametrize("name", [SLIDER_CRANK, "elliptic_gears"])
def test_example_is_valid_without_warnings(name: str) -> None:
    result = answer("validate", _source(name))
    assert result["valid"] is True
    assert result["design"] == list(load_machine(_source(name)).design_names)
    assert result["warnings"] == []


@pytest.mark.parametrize("name", OTHERS)
def test_built_in_machine_is_valid(name: str) -> None:
    assert answer("validate", name)["valid"] is True


def test_value_outside_bounds_is_named() -> None:
    (warning,) = validate_machine(load_machine(_source(SLIDER_CRANK), {"r_mm": 81.0})).warnings
    assert "r_mm = 81" in warning.message
    assert "[30, 80]" in warning.message
    assert warning.phi_deg is None


@pytest.mark.parametrize(("limit", "met"), [(101.0, True), (99.0, False)])
def test_limit_of_the_file_is_compared(limit: float, met: bool, tmp_path: Path) -> None:
    """The slider of a crank of 50 mm and a rod of 200 mm, offset by 10 mm, travels the difference
    of two roots.
    """
    travel = np.sqrt(250**2 - 10**2) - np.sqrt(150**2 - 10**2)
    result = answer("validate", _with_limit(tmp_path, f"range s <= {travel * limit / 100:.9f} mm"))
    assert result["met"] is met
    assert result["holds"][0]["value"] == pytest.approx(travel, rel=1e-6)


def test_open_loop_fails() -> None:
    outcome = CliRunner().invoke(
        build_application(), ["validate", _source(SLIDER_CRANK), "--set", "l_mm=45"]
    )
    assert outcome.exit_code == 1
    assert not outcome.stdout


def test_free_motion_is_valid() -> None:
    result = answer("validate", _source("manipulator"))
    assert (result["valid"], result["warnings"]) == (True, [])


def test_start_off_constraints_is_reported() -> None:
    """Andrews' mechanism closes for the stated start alone: with another link its joints begin
    elsewhere.
    """
    mechanism = file.load(_source("andrews"), {})
    assert validate_free_motion(mechanism).warnings == []
    key = next(key for key in mechanism.values if key.startswith("rr"))
    changed = file.load(_source("andrews"), {key: mechanism.values[key] * 1.01})
    assert validate_free_motion(changed).warnings
