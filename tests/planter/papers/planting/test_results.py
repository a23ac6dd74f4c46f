"""The folder that a run leaves: complete, the same bytes each time, and the numbers of the run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planter import simulate
from planter.engine import front
from planter.mechanism.presentation import present_cycle
from planter.papers.planting.design_presentation import present_optimum
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.optimisation import add_pareto_front, optimise
from planter.report import files
from tests.support.tables import read_cycle_csv

OWN = {"support_force"}


pytestmark = pytest.mark.usefixtures("blank_figures")


def names(figure_names: set[str], *other_names: str) -> set[str]:
    return {f"figures/{name}.{kind}" for name in figure_names for kind in ("svg", "png", "pdf")} | {
        *other_names
    }


def written(folder: Path) -> dict[str, bytes]:
    return {
        p.relative_to(folder).as_posix(): p.read_bytes()
        for p in folder.rglob("*")
        if p.is_file() and p.name[0] != "."
    }


def test_simulation_files_are_complete_and_reproducible(tmp_path: Path) -> None:
    device = Device(load("wang2017", {"forward_speed_m_s": -0.667}), "printed")
    simulation = simulate(device, 24, [0.0, 100.0])
    for folder in ("one", "two"):
        present_cycle(simulation).write(tmp_path / folder)
    first = written(tmp_path / "one")
    assert set(first) > names(OWN | {"N_1", "mm_1"}, "summary.json", "values.csv", "report.html")
    assert first == written(tmp_path / "two")
    summary = json.loads(first["summary.json"])
    result = simulation.result.table()
    assert {key: summary[key] for key in result} == json.loads(json.dumps(result))
    assert summary["provenance"] == files.list_provenance(device.machine)
    _, columns = read_cycle_csv(tmp_path / "one" / "values.csv")
    assert {k: v.tobytes() for k, v in columns.items()} == {
        k: np.asarray(v, dtype=float).tobytes() for k, v in simulation.table().items()
    }


def test_optimisation_writes_optimum_and_optional_front(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(front, "FRONT_POINTS", 2)
    device = Device(load("wang2017"))
    optimum = optimise(device, "ipopt", "60", starts=1)
    numbers = {"summary.json", "cycle.csv", "optimum.toml"}
    present_optimum(optimum, device).write_data(tmp_path)
    assert set(written(tmp_path)) == numbers
    present_optimum(optimum, device).write(tmp_path)
    figure_names = OWN | {"tip_path", "pitch_curves", "convergence"}
    assert set(written(tmp_path)) == names(figure_names, "report.html", *numbers)
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    _, columns = read_cycle_csv(tmp_path / "cycle.csv")
    assert len(columns["support_N"]) == 60
    assert np.ptp(columns["support_N"]) == pytest.approx(summary["range_N"], abs=1e-9)
    assert summary["range_N"] < summary["start_range_N"]
    assert summary["provenance"]["seed"] == 0
    assert "front" not in summary
    compromises = add_pareto_front(optimum)
    present_optimum(compromises, device).write(tmp_path)
    figure_names |= {"pareto"}
    assert set(written(tmp_path)) == names(figure_names, "report.html", *numbers)
    ranges = [point.range_N for point in compromises.result.front]
    assert ranges == sorted(ranges)
    assert min(ranges) < summary["range_N"] * (1 + 1e-6)
