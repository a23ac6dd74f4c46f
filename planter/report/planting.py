"""The files that `planter simulate`, `sensitivity` and `optimise` leave in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter import emitted, planting
from planter.device import MODELS, Device
from planter.optimise import joints, pareto
from planter.optimise.objective import Objective
from planter.optimise.problem import Problem
from planter.optimise.response import Planting
from planter.report import figures, files
from planter.report.device_page import device_page
from planter.report.gearing import gearing, ratios

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.optimisation import Optimisation
    from planter.simulate import Simulation

DENSE = np.linspace(0, 2 * np.pi, 721)
"""Carrier angles of a figure's curves [rad]."""
CLOUD, SHARES = 300, 5
"""Designs drawn at random from the box, and weights between range and variance, for the figure of the front."""


def write_simulation(out: Path, device: Device, found: Simulation) -> None:
    """Writes summary.json, cycle.csv, the figures and report.html. Raises InputError for a folder that it cannot."""
    folder = files.output_folder(out)
    _write_numbers(folder, device, found.result, found.cycle, device.design)
    drawn = _forces(_both_models(device), device.design) | _motion(device, device.design)
    _write_page(folder, device, found.result, drawn)


def write_sensitivity(out: Path, device: Device, result: Mapping[str, Any]) -> None:
    """Writes summary.json and report.html. Raises InputError for a folder that it cannot."""
    folder = files.output_folder(out)
    files.write_summary(folder / "summary.json", _summary(device, result, None))
    _write_page(folder, device, result, {})


def write_optimisation(out: Path, device: Device, found: Optimisation) -> None:
    """Writes summary.json, the optimum's cycle.csv, the figures and report.html.

    Raises InputError for a folder that it cannot write.
    """
    folder = files.output_folder(out)
    x, seed, sampling = found.found.design, found.found.seed, found.found.sampling
    samples = device.machine.objective.samples if sampling == "refined" else sampling
    turn = planting.cycle(device, device.prologue(x), planting.angles(samples))
    _write_numbers(folder, device, found.result, turn, x, seed)
    drawn = _forces(found.devices, x, device.design) | _search(device, found) | _motion(device, x)
    _write_page(folder, device, found.result, drawn, seed)


def _both_models(device: Device) -> dict[str, Device]:
    return {model: device if model == device.model else Device(device.machine, model) for model in MODELS}


def _columns(device: Device, x: Array) -> dict[str, Array]:
    return planting.cycle(device, device.prologue(x), DENSE).columns()


def _forces(devices: Mapping[str, Device], x: Array, start: Array | None = None) -> dict[str, Figure]:
    turns = {model: _columns(device, x) for model, device in devices.items()}
    before = {model: _columns(device, start) for model, device in devices.items()} if start is not None else {}
    exact = devices["exact"]
    support = figures.support_force(
        {model: (turn["phi_deg"], turn["support_N"]) for model, turn in turns.items()},
        planting.weight(exact),
        _joints(exact, x),
        {model: (turn["phi_deg"], turn["support_N"]) for model, turn in before.items()},
    )
    return {"support_force": support, "joint_forces": figures.joint_forces(turns)}


def _joints(device: Device, x: Array) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for place in joints.places(Planting(device), device.prologue(x)):
        found.setdefault(place.name, []).append(float(np.degrees(place.angle)))
    # In the order of the model's events, not of the angles.
    return {name: found[name] for name in (e["name"] for e in device.sidecar["events"]) if name in found}


def _motion(device: Device, x: Array) -> dict[str, Figure]:
    turn = _columns(device, x)
    return {
        "tip_path": figures.tip_path(turn, device.machine.nozzle.tip_distance_mm),
        "pitch_curves": figures.pitch_curves(gearing(device, x)),
        "rotation": figures.rotation(turn, ratios(device, x, turn["phi_deg"])),
    }


def _search(device: Device, found: Optimisation) -> dict[str, Figure]:
    objective = Objective.of(device.machine)
    printed = objective.kind == "paper"
    marks = {
        "machine file": (found.result["start_range_N"], found.result["start_variance_N2"]),
        "optimum": (found.result["range_N"], found.result["variance_N2"]),
    }
    points = np.vstack([_cloud(device, found), _front(device, found), list(marks.values())])
    weights = (objective.weight_range, objective.weight_variance) if printed else None
    drawn = {"pareto": figures.pareto(points, marks, weights)}
    if any(found.found.history.values()):
        drawn["convergence"] = figures.convergence({k: h for k, h in found.found.history.items() if h})
    return drawn


def _front(device: Device, found: Optimisation) -> Array:
    compromises = pareto.front(device, found.found.sampling, SHARES)
    return np.array([(c.evaluation.range_N, c.evaluation.variance_N2) for c in compromises])


def _cloud(device: Device, found: Optimisation) -> Array:
    """Range and variance of designs anywhere in the box, (n, 2)."""
    problem = Problem(Planting(device), Objective.of(device.machine), found.found.sampling)
    scored = [problem.evaluate(u) for u in np.random.default_rng(found.found.seed).random((CLOUD, device.size))]
    return np.array([(one.range_N, one.variance_N2) for one in scored])


def _write_numbers(
    folder: Path, device: Device, result: Mapping[str, Any], turn: planting.Cycle, x: Array, seed: int | None = None
) -> None:
    files.write_summary(folder / "summary.json", _summary(device, result, seed))
    design = planting.shown_design(device, x)
    comments = files.comments(device.machine, device.model, design, seed)
    files.write_cycle_csv(folder / "cycle.csv", comments, turn.columns())


def _summary(device: Device, result: Mapping[str, Any], seed: int | None) -> dict[str, Any]:
    """The result, and what it can be had again from."""
    return {**result, "provenance": files.provenance(device.machine, seed), "input": device.machine.table()}


def _write_page(
    folder: Path, device: Device, result: Mapping[str, Any], drawn: Mapping[str, Figure], seed: int | None = None
) -> None:
    texts = {}
    for name, figure in drawn.items():
        vector, _ = figures.save(figure, folder, name)
        texts[name] = vector.read_text(encoding="utf-8")
    provenance = files.provenance(device.machine, seed)
    page = device_page(device.machine, emitted.sidecar(f"planting_{device.model}"), result, texts, provenance)
    files.write_text(folder / "report.html", page)
