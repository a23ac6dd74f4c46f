"""The folder that a run leaves: complete, the same bytes each time, and the numbers of the run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planter.engine import front
from planter.errors import InputError
from planter.planting.design_presentation import (
    present_optimum,
    present_sensitivity,
    present_simulation,
)
from planter.planting.file import load
from planter.planting.model import Device
from planter.planting.objective import find_curve_angles
from planter.planting.optimisation import add_pareto_front, optimise
from planter.planting.simulation import sensitivity, simulate
from planter.report import files

MOTION = {"tip_path", "pitch_curves", "rotation"}
FORCES = {"support_force", "joint_forces"}


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
        present_simulation(simulation).write(tmp_path / folder)
    first = written(tmp_path / "one")
    assert set(first) == names(MOTION | FORCES, "summary.json", "cycle.csv", "report.html")
    assert first == written(tmp_path / "two")
    summary = json.loads(first["summary.json"])
    result = simulation.result.table()
    assert {key: summary[key] for key in result} == json.loads(json.dumps(result))
    assert summary["provenance"] == files.list_provenance(device.machine)
    comments, columns = files.read_cycle_csv(tmp_path / "one" / "cycle.csv")
    assert "model: printed" in comments
    assert {k: v.tobytes() for k, v in columns.items()} == {
        k: np.asarray(v, dtype=float).tobytes() for k, v in simulation.cycle.columns().items()
    }


def test_optimisation_writes_optimum_and_optional_front(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(front, "FRONT_POINTS", 2)
    monkeypatch.setattr(Device, "compile", lambda self, refined: None)  # not worth it for one start
    device = Device(load("wang2017"))
    optimum = optimise(device, "ipopt", "60", starts=1)
    numbers = {"summary.json", "cycle.csv", "optimum.toml"}
    present_optimum(optimum, device).write_data(tmp_path)
    assert set(written(tmp_path)) == numbers
    present_optimum(optimum, device).write(tmp_path)
    figure_names = MOTION | FORCES | {"convergence"}
    assert set(written(tmp_path)) == names(figure_names, "report.html", *numbers)
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    _, columns = files.read_cycle_csv(tmp_path / "cycle.csv")
    assert len(columns["support_N"]) == 60
    assert np.ptp(columns["support_N"]) == pytest.approx(summary["range_N"], abs=1e-9)
    assert summary["range_N"] < summary["start_range_N"]
    assert summary["provenance"]["seed"] == 0
    assert "front" not in summary
    compromises = add_pareto_front(optimum)
    present_optimum(compromises, device).write(tmp_path)
    assert set(written(tmp_path)) == names(figure_names | {"pareto"}, "report.html", *numbers)
    ranges = [point.range_N for point in compromises.result.front]
    assert ranges == sorted(ranges)
    assert min(ranges) < summary["range_N"] * (1 + 1e-6)


def test_report_has_a_single_range_per_design(tmp_path: Path) -> None:
    """True extremes stand in table and figure; those of samples stand beside them, under their
    number.
    """
    device = Device(load("wang2017"))
    simulation = simulate(device)
    present_simulation(simulation).write(tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    true = simulation.result.refined.range_N
    assert f"{true:.6g}" in page
    assert f"{simulation.result.samples} samples" in page
    phi = find_curve_angles(device, device.design)
    assert np.ptp(device.support(device.prologue(device.design), phi)) == pytest.approx(
        true, rel=1e-12
    )


def test_optimised_device_is_not_changed() -> None:
    device = Device(load("wang2017"))
    before = device.constants.copy()
    optimise(device, "ipopt", "60", starts=1)
    assert (device.constants == before).all()


def test_sensitivity_writes_summary(tmp_path: Path) -> None:
    device = Device(load("wang2017"))
    sensitivity_result = sensitivity(device, 24)
    present_sensitivity(sensitivity_result, device).write(tmp_path)
    result = sensitivity_result.table()
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert {key: summary[key] for key in result} == json.loads(json.dumps(result))
    assert summary["input"] == device.machine.table()


def test_folder_occupied_by_file_is_refused(tmp_path: Path) -> None:
    occupied = tmp_path / "occupied"
    occupied.write_text("a file")
    device = Device(load("wang2017"))
    with pytest.raises(InputError, match="occupied"):
        present_sensitivity(sensitivity(device, 24), device).write(occupied)
    assert occupied.read_text() == "a file"
