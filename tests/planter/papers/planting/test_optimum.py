"""The optimum as a machine file: it goes back into every command and gives what was found."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from planter.files import examples
from planter.mechanism.presentation import SET_ORIGIN
from planter.papers.planting import design_presentation, file
from planter.papers.planting.optimisation import OptimisationInterrupted
from planter.report.presentation import ResultPresentation
from tests.support.cli import refusal, run
from tests.support.sampled import sampled

SHORT = ("--method", "ipopt", "--starts", "1", "--samples", "60")


def called(*arguments: str, code: int = 0) -> dict:
    ended, out, err = run(*arguments, "--json")
    assert ended == code, err
    return json.loads(out)


@pytest.fixture(autouse=True)
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ResultPresentation, "write", lambda *_: None)


@pytest.fixture
def commented(tmp_path: Path) -> str:
    """A file of a stranger's: built in, with a comment more and an awkward text."""
    path = tmp_path / "own.toml"
    text = examples.read_source("compact", "planting")
    name = 'name = "mine \\"quoted\\" # no comment"'
    lines = [name if line.startswith("name =") else line for line in text.splitlines()]
    path.write_text("\n".join(["# of my own", *lines, "# the end"]))
    return str(path)


CASES = {
    "built in": ("wang2017", ()),
    "a file with comments": ("", ()),
    "a file with comments, numbers set": (
        "",
        ("--set", "sun_kg=0.5", "--set", "hinge_A_mm[0]=31", "--speed-rpm", "47"),
    ),
    "a design value set": ("wang2017", ("--set", "R3_mm=30.9")),
    "printed": ("wang2017", ("--model", "printed")),
}


@pytest.mark.parametrize("case", sampled(["a file with comments, numbers set"], CASES))
def test_optimum_file_works_in_every_command(case: str, commented: str, tmp_path: Path) -> None:
    source, options = CASES[case]
    result = called(
        "optimise", source or commented, *options, *SHORT, "--out", str(tmp_path / "out")
    )
    written = str(tmp_path / "out" / "optimum.toml")
    model = ("--model", "printed") if "printed" in options else ()
    assert called("simulate", written, *model)["objective"] == pytest.approx(
        result["objective"], rel=1e-12
    )
    again = called("optimise", written, *model, *SHORT)
    assert again["start_objective"] == pytest.approx(result["objective"], rel=1e-12)
    assert again["objective"] <= result["objective"] * (1 + 1e-9)
    assert called("validate", written)["valid"] is True


def test_default_search_reaches_true_optimum() -> None:
    """Over 360 samples the design with k6 = 0.0308 seems better; its true objective is not."""
    result = called("optimise", "wang2017", *SHORT[:4])
    assert result["samples"] == "refined"
    assert result["objective"] == pytest.approx(1.9044107, abs=1e-6)
    assert result["design"]["k6"] == pytest.approx(0.03, abs=1e-9)
    assert result["refined"]["objective"] == pytest.approx(result["objective"], rel=1e-12)
    assert result["refined"]["range_N"] == pytest.approx(result["range_N"], rel=1e-12)
    sampled, start = result["sampled"], called("simulate", "wang2017")
    assert sampled["samples"] == start["samples"]
    assert result["start_objective"] == pytest.approx(start["refined"]["objective"], rel=1e-12)
    design = [f"--set={name}={value!r}" for name, value in result["design"].items()]
    again = called("simulate", "wang2017", *design)
    assert sampled["objective"] == pytest.approx(again["objective"], rel=1e-12)
    assert sampled["range_N"] == pytest.approx(again["support_force"]["range_N"], rel=1e-12)
    other = called("optimise", "wang2017", *SHORT[:4], "--samples", "360")
    assert (other["samples"], other["sampled"]["objective"]) == (
        360,
        pytest.approx(other["objective"], rel=1e-12),
    )
    assert (
        other["objective"]
        < sampled["objective"]
        < result["objective"]
        < other["refined"]["objective"]
    )


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_every_seed_finds_the_true_optimum_in_a_minute(seed: int) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [
        sys.executable,
        "-m",
        "planter",
        "optimise",
        "wang2017",
        "--seed",
        str(seed),
        "--json",
    ]
    result = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    assert result["objective"] == pytest.approx(1.9044107, abs=1e-6)
    assert result["certificate"]["agreeing_starts"] == result["certificate"]["starts"]
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before < 60


def test_optimum_file_has_all_inputs_and_marks_changes(tmp_path: Path) -> None:
    changes = {"sun_kg": 0.5, "nozzle.hinge_A_mm[0]": 31.0}
    machine = file.load("wang2017", changes)
    design = {**machine.design, "R3_mm": 30.95, "k6": 0.04}
    result = SimpleNamespace(
        design=design, objective=1.9, start_objective=2.0, method="ga", seed=3, teeth=None
    )
    text = design_presentation.format_optimum_file(machine, "exact", result, 360)
    back = file.PlantingMachine.read(tomllib.loads(text), "back")
    moved = {"design.R3_mm", "design.k6"}
    numbers = machine.numbers()
    assert {path for path, value in back.numbers().items() if value != numbers[path]} == moved
    assert "R3_mm = 30.95  # was 30.916 mm" in text.splitlines()
    assert text.count("# was") == 2
    assert all(back.origin(path).startswith("optimised") for path in moved)
    assert back.origin("design.m31").startswith("paper")
    assert back.origin("mass.sun_kg") == back.origin("nozzle.hinge_A_mm[0]") == SET_ORIGIN
    assert back.origin("operation.speed_rpm") == "paper"
    assert back.origin("nozzle.hinge_A_mm[1]") == "assumed"


def test_value_at_bound_stays_within_bounds() -> None:
    machine = file.load("wang2017")
    upper = machine.bounds["R3_mm"][1]
    design = {**machine.design, "R3_mm": np.nextafter(upper, 99)}
    result = SimpleNamespace(
        design=design, objective=1.9, start_objective=2.0, method="ga", seed=3, teeth=None
    )
    assert (
        tomllib.loads(design_presentation.format_optimum_file(machine, "exact", result, "refined"))[
            "design"
        ]["R3_mm"]
        == upper
    )


def interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def test_interrupt_while_writing_returns_optimum(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ResultPresentation, "write_data", interrupt)
    result = called("optimise", "wang2017", *SHORT, "--out", str(tmp_path), code=130)
    assert result["error"]["name"] == "Interrupted"
    assert result["partial"]["certificate"]["kkt_residual"] < 1e-6
    assert result["partial"]["cross"]


def test_interrupt_while_drawing_loses_no_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ResultPresentation, "write", interrupt)
    result = called("optimise", "wang2017", *SHORT, "--out", str(tmp_path), code=130)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert result["objective"] == summary["objective"]
    assert "interrupted" not in summary
    assert (tmp_path / "optimum.toml").exists()


def test_an_interrupt_after_the_search_hands_the_optimum_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from planter.papers.planting import optimisation
    from planter.papers.planting.model import Device

    monkeypatch.setattr(optimisation, "evaluate_in_both_models", interrupt)
    with pytest.raises(OptimisationInterrupted) as caught:
        optimisation.optimise(Device(file.load("wang2017")), "ipopt", "60", starts=1)
    assert caught.value.partial is not None
    assert caught.value.partial["certificate"]["kkt_residual"] < 1e-6


def test_best_so_far_is_saved_during_search(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from planter.engine import search

    monkeypatch.setattr(search, "INTERVAL_S", 0.0)
    saved: list[dict] = []
    write = design_presentation.write_partial
    monkeypatch.setattr(
        design_presentation,
        "write_partial",
        lambda out, device, best, stopped=False: (
            saved.append(dict(best)) or write(out, device, best, stopped)
        ),
    )
    options = (
        "--method",
        "hybrid",
        "--set",
        "individuals=10",
        "--set",
        "generations=6",
        "--samples",
        "60",
        "--starts",
        "2",
    )
    best = called("optimise", "wang2017", *options, "--out", str(tmp_path))
    objectives = [entry["objective"] for entry in saved]
    assert len(objectives) > 1
    assert objectives == sorted(objectives, reverse=True)
    assert objectives[-1] == pytest.approx(best["objective"], rel=1e-6)
    assert best["objective"] <= objectives[-1]
    assert saved[0]["design"].keys() == best["design"].keys()
    assert "finished" not in json.loads((tmp_path / "summary.json").read_text())


def test_unwritable_folder_is_reported_before_search(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from planter.papers.planting import optimisation

    monkeypatch.setattr(optimisation, "optimise", interrupt)
    occupied = tmp_path / "occupied"
    occupied.write_text("a file")
    refusal("optimise", "wang2017", "--out", str(occupied))
