"""Searches without a result: what was computed is on disk, is read by every command, and is gone on
from.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from planter.engine.machine import load_machine
from planter.engine.search import FailedSearchError, SearchSpec
from planter.engine.solvers.local_search import find_minima
from planter.errors import ComputationError
from planter.mechanism import optimisation
from planter.mechanism.optimisation import optimise_machine
from planter.report import process
from planter.report.console import Console
from tests.support import own
from tests.support.cli import answer, run

IMPOSSIBLE = "min M_in >= 5000 N m"
POSSIBLE = "max abs M_in <= 6 N m"


@pytest.fixture
def source(tmp_path: Path) -> str:
    folder = tmp_path / "own"
    shutil.copytree(own.generated("slider_crank"), folder)
    return str(folder / "slider_crank.toml")


def stop_after(count: int) -> Callable[..., None]:
    steps: list[Any] = []

    def stop(*arguments: Any) -> None:
        steps.append(arguments)
        if len(steps) >= count:
            raise KeyboardInterrupt

    return stop


def read(folder: Path) -> dict[str, Any]:
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return summary


def test_infeasible_search_writes_closest_design(source: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    options = ("--least", "range F_Ox", "--hold", IMPOSSIBLE, "--out", str(out))
    code, standard, error = run("optimise", source, *options, "--starts", "2", "--json")
    assert code == 1
    assert "2 starts" in error
    assert "no design within" not in error
    assert str(out / "closest.toml") in error
    partial = json.loads(standard)["partial"]
    assert (partial["met"], partial["violated"]) == (False, IMPOSSIBLE)
    assert {file.name for file in out.glob("[a-z]*")} == {"closest.toml", "summary.json"}
    assert read(out)["finished"] is False
    closest = load_machine(str(out / "closest.toml"))
    design = dict(zip(closest.design_names, closest.design / closest.scale, strict=True))
    assert design == pytest.approx(partial["design"], rel=1e-12)
    reached = answer("simulate", str(out / "closest.toml"))["quantities"]["M_in_Nm"]["min"]
    own_value = answer("simulate", source)["quantities"]["M_in_Nm"]["min"]
    assert reached > own_value, "the closest design is closer than that of the file"


def test_closest_design_is_gone_on_from(source: str, tmp_path: Path) -> None:
    out, further = tmp_path / "out", tmp_path / "further.toml"
    options = ("--least", "range F_Ox", "--starts", "1")
    assert run("optimise", source, *options, "--hold", IMPOSSIBLE, "--out", str(out))[0] == 1
    text = (out / "closest.toml").read_text(encoding="utf-8")
    assert text.count(IMPOSSIBLE) == 1
    further.write_text(text.replace(IMPOSSIBLE, POSSIBLE), encoding="utf-8")
    result = answer("optimise", str(further), "--starts", "1")
    assert result["met"]
    assert result["least"] == "range F_Ox"
    assert [limit["limit_on"] for limit in result["holds"]] == [POSSIBLE]
    assert result["start_design"] == pytest.approx(read(out)["design"])
    assert run("optimise", source, *options, "--hold", POSSIBLE, "--out", str(out))[0] == 0
    assert not (out / "closest.toml").exists(), "a result replaces it"
    assert "finished" not in read(out)


def test_every_command_judges_the_goal_of_the_call(source: str, tmp_path: Path) -> None:
    best = tmp_path / "best"
    options = ("--least", "range F_Ox", "--hold", POSSIBLE, "--starts", "1", "--out", str(best))
    result = answer("optimise", source, *options)
    optimum = str(best / "optimum.toml")
    simulated = answer("simulate", optimum)
    assert [limit["limit_on"] for limit in simulated["holds"]] == [POSSIBLE]
    compared = answer("diff", source, optimum)
    rows = {row["name"]: row for row in compared["results"]}
    assert rows["objective"]["values"][1] == pytest.approx(result["objective"], rel=1e-9)
    assert rows["objective"]["better"] == 1
    assert compared["requirements"][0]["met"][1]
    moved = {f"values.{key}" for key in result["design"]}
    changed = {value["name"] for value in compared["values"]}
    goal = {"objective.least", "objective.samples", "requirements.hold[0]"}
    assert changed - moved == goal
    again = answer("optimise", optimum, "--starts", "1")
    assert again["start_objective"] == pytest.approx(result["objective"], rel=1e-9)
    assert again["objective"] <= result["objective"] * (1 + 1e-9)


@pytest.mark.parametrize(
    ("hold", "name"), [(IMPOSSIBLE, "closest.toml"), (POSSIBLE, "optimum.toml")]
)
def test_interrupted_search_leaves_a_design(
    hold: str, name: str, source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    monkeypatch.setattr(Console, "progress", stop_after(2))
    options = (
        "--least",
        "range F_Ox",
        "--hold",
        hold,
        "--starts",
        "3",
        "--out",
        str(out),
        "--json",
    )
    code, standard, _ = run("optimise", source, *options)
    assert code == 130
    partial = json.loads(standard)["partial"]
    assert {file.name for file in out.glob("*.toml")} == {name}
    machine = load_machine(str(out / name))
    assert dict(
        zip(machine.design_names, machine.design / machine.scale, strict=True)
    ) == pytest.approx(partial["design"], rel=1e-12)
    assert answer("validate", str(out / name))["valid"]


def test_interrupted_front_keeps_the_optimum(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    monkeypatch.setattr("planter.engine.front.require_front", lambda problem: problem)
    monkeypatch.setattr(optimisation, "with_front", stop_after(1))
    options = ("--least", "range s", "--front", "--starts", "1", "--out", str(out), "--json")
    code, standard, _ = run("optimise", source, *options)
    assert code == 130
    assert json.loads(standard)["partial"]["certificate"]["starts"] == 1
    assert (out / "optimum.toml").exists()
    assert read(out)["objective"] == json.loads(standard)["partial"]["objective"]


def test_failed_workers_leave_the_best_design(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: Any) -> Any:
        minima = find_minima(*arguments)
        yield next(minima)
        raise ComputationError("5 worker processes ended at the same job")

    monkeypatch.setattr("planter.engine.solvers.optimiser.find_minima", fail)
    candidate: list[Any] = []
    with pytest.raises(FailedSearchError, match="worker processes ended") as caught:
        optimise_machine(
            own.machine("slider_crank"), "range s", (), SearchSpec(starts=3), keep=candidate.append
        )
    assert caught.value.partial is not None
    assert caught.value.partial["met"]
    assert candidate[-1].design == caught.value.partial["design"]


def test_swallowed_interrupt_keeps_what_was_found(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A solver may turn the interrupt of its callback into a failure of its own."""
    error = ComputationError("the solver failed")
    error.partial = {"design": {"r_mm": 1.0}}
    monkeypatch.setattr(process, "exit_code", lambda: 130)
    monkeypatch.setattr(process, "ignore_signals", lambda: None)
    with pytest.raises(SystemExit) as stop, Console(as_json=True).outcome():
        raise error
    assert stop.value.code == 130
    assert json.loads(capsys.readouterr().out)["partial"] == error.partial
    assert ComputationError("another").partial is None
