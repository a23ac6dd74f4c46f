"""The page without a server: what it computes is what the commands compute, and it fetches and runs
nothing else.
"""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path

import numpy as np
import pytest

from planter.engine.outputs import CycleObjective
from planter.kernels import compiler, programs
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.model import Device
from planter.papers.planting.show import PlantingView
from planter.report.subject import open_machine
from tests.planter.studio.static.told import TWELVE, Told, assert_drawn
from tests.support import pairs
from tests.support.cli import run
from tests.support.machines import with_flank
from tests.support.wasm import Running, difference, needs_wasm

pytestmark = needs_wasm


@pytest.mark.parametrize("model", ["exact", "printed"])
def test_readings_equal_studio_to_twelve_digits(page: Told, model: str) -> None:
    machine = open_machine("wang2017-wide")
    for values in page.designs(6):
        expected = {reading.name: reading.value for reading in machine.readings(values, model)}
        assert page.readings(model, values) == pytest.approx(expected, rel=TWELVE)


def test_changed_constant_is_detected(page: Told) -> None:
    """One constant of the module, a thousandth more: some reading is wrong by more than twelve
    digits.
    """
    values = page.designs(1)[1]
    expected = page.readings("exact", values)
    start = np.array([load("wang2017-wide").si("mass.carrier_kg")]).tobytes()
    assert page.module.count(start) > 0
    changed = page.module.replace(start, (np.frombuffer(start) * 1.001).tobytes())
    assert page.readings("exact", values, Running(changed)) != pytest.approx(expected, rel=TWELVE)


@pytest.mark.parametrize("model", ["exact", "printed"])
def test_drawing_equals_studio(page: Told, model: str) -> None:
    """Every series, place, outline and label that follows numbers, at designs that it was not built
    at.
    """
    machine = open_machine("wang2017-wide")
    plan = page.machine["models"][model]["plan"]
    for values in page.designs(4)[1:]:
        numbers, scene = page.numbers(model, "seen", values), machine.scenes(values, model)[0]
        assert_drawn(plan, numbers, scene)


@pytest.mark.parametrize("model", ["exact", "printed"])
def test_slopes_equal_compiled_cycle(page: Told, model: str) -> None:
    mechanism = page.machine["models"][model]["descent"]
    for values in page.designs(3):
        device = Device(load("wang2017-wide", values), model)  # type: ignore[arg-type]
        objective, gradient = CycleObjective(device).gradient(device.design)
        numbers = page.numbers(model, "descent", values)
        assert numbers[mechanism["objective"]] == pytest.approx(objective, rel=TWELVE)
        results = numbers[mechanism["gradient"] :][: len(gradient)]
        assert np.abs(results - gradient).max() <= TWELVE * np.abs(gradient).max()


def test_page_runs_a_single_script_and_fetches_no_files(page: Told) -> None:
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page.html)
    assert policy
    parts = dict(part.strip().split(" ", 1) for part in policy[1].split(";"))
    for tag, key in (("script", "script-src"), ("style", "style-src")):
        texts = re.findall(rf'<{tag}(?: type="module")?>(.*?)</{tag}>', page.html, re.DOTALL)
        assert len(texts) == 1
        named = base64.b64encode(hashlib.sha256(texts[0].encode()).digest()).decode()
        assert parts[key].split()[0] == f"'sha256-{named}'"
    assert parts["default-src"] == "'none'"
    assert parts["script-src"].split()[1:] == ["'wasm-unsafe-eval'"]
    assert "connect-src" not in parts
    assert set(re.findall(r"https?://[^\s\\\"'<]+", page.html)) <= {"http://www.w3.org/2000/svg"}
    assert len(page.html) < 330_000


def test_other_families_flanks_masses_and_objectives_go_too() -> None:
    base = with_flank(pairs.machine("limacon", "fourier"), "cycloidal").table()
    base["objective"] |= {"kind": "newton", "weight_range": 0.3, "samples": 250}
    base["mass"] |= {"planet_kg": 2.5, "middle_kg": 0.2}
    base["nozzle"]["tip_distance_mm"] = 180.0
    machine = PlantingView(PlantingMachine.read(base, "other.toml"))
    portable = machine.portable("exact")
    running = Running(programs.build_webassembly(portable.programs))
    values = {
        control.path: control.lower + 0.3 * (control.upper - control.lower)
        for control in machine.controls
    }
    for program in portable.programs:
        expected = portable.at(values, program)
        results = running.vectors(program, **{key: expected[key] for key in ("x", "c")})
        assert results is not None
        assert difference(results, expected) < TWELVE
    singles = dict(
        zip(portable.singles, portable.at(values, portable.seen)["singles"], strict=True)
    )
    expected = {control.name: control.value for control in machine.readings(values, "exact")}
    assert {name: singles[name] for name in expected} == pytest.approx(expected, rel=TWELVE)


def refused(*arguments: str) -> str:
    """The one sentence of a refused call."""
    code, out, err = run("studio", *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    return err.strip()


@pytest.mark.parametrize("machine", ["yu2023", "shi2021", "sun2019"])
def test_uncomputable_machines_are_refused_in_a_sentence(tmp_path: Path, machine: str) -> None:
    message = refused(machine, "--static", str(tmp_path / "page.html"))
    assert message == (
        f"planter: --static is not available for {machine}: such a machine is computed in "
        f"Python only"
    )
    assert list(tmp_path.iterdir()) == []


def test_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    assert "ends in .html" in refused("--static", str(tmp_path / "page.pdf"))


def test_missing_compiler_names_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "bundled_command", lambda target="": ())
    assert "pip install 'planter[compiler]'" in refused("--static", str(tmp_path / "page.html"))
