"""The files that a command leaves in a folder: summary, cycle, figures and page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.optimise.joints import places
from planter.planting import cycle, optimum
from planter.planting.functions import MODELS
from planter.planting.model import Device
from planter.planting.objective import problem, weights
from planter.planting.report import figures
from planter.planting.report.gearing import gearing, ratios
from planter.planting.report.page import device_page
from planter.planting.report.scene import scene
from planter.planting.scores import curve_angles
from planter.report import files
from planter.report.folder import renews
from planter.view.block import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.optimise.conditions import Look
    from planter.planting.optimisation import Optimisation
    from planter.planting.simulation import Simulation
    from planter.records import Record

MOVING = (
    "The device over a turn, both sides, with the path of the tip. How wide the nozzle is drawn is a sketch: the "
    "machine file holds its length only; beside it, seen across, the halves that the cam opens."
)
CLOUD = 300
"""Designs drawn at random from the box, for the figure of the front."""


@renews
def write_simulation(out: Path, device: Device, found: Simulation) -> None:
    """Writes summary.json, cycle.csv, figures and report.html. Raises InputError for a folder that it cannot."""
    folder = files.output_folder(out)
    result = found.result.table()
    _write_numbers(folder, device, result, found.cycle, device.design)
    both: dict[str, Device] = {m: device if m == device.model else Device(device.machine, m) for m in MODELS}
    drawn = _forces(both, device.design) | _motion(device, device.design)
    _write_page(folder, device, result, drawn, moving=_moving(device, device.design))


@renews
def write_result(out: Path, device: Device, found: Record) -> None:
    """Writes summary.json and report.html. Raises InputError for a folder that it cannot write."""
    folder, result = files.output_folder(out), found.table()
    files.write_summary(folder / "summary.json", _summary(device, result))
    _write_page(folder, device, result, {})


def write_optimum(out: Path, device: Device, found: Optimisation) -> None:
    """Writes summary.json, optimum.toml and the optimum's cycle.csv. Raises InputError for a folder that it cannot."""
    folder = files.output_folder(out)
    x, seed, sampling = found.found.design, found.found.seed, found.found.sampling
    samples = device.machine.objective.samples if sampling == "refined" else sampling
    turn = cycle.cycle(device, device.prologue(x), cycle.angles(samples))
    files.write_text(folder / "optimum.toml", optimum.text(device.machine, device.model, found.result, sampling))
    _write_numbers(folder, device, found.result.table(), turn, x, seed)


def draw_optimum(out: Path, device: Device, found: Optimisation) -> None:
    """Writes figures and report.html of an optimum. Raises InputError for a folder that it cannot write."""
    folder, x = files.output_folder(out), found.found.design
    drawn = _forces(found.devices, x, device.design) | _search(device, found) | _motion(device, x, device.design)
    _write_page(folder, device, found.result.table(), drawn, found.found.seed, _moving(device, x, device.design))


def write_partial(out: Path, device: Device, partial: Mapping[str, Any], interrupted: bool = False) -> None:
    """Writes what an unfinished optimisation has found to summary.json."""
    folder = files.output_folder(out)
    marks = {"finished": False, **({"interrupted": True} if interrupted else {})}
    files.write_summary(folder / "summary.json", _summary(device, {**partial, **marks}))


def _write_numbers(
    folder: Path, device: Device, result: Mapping[str, Any], turn: cycle.Cycle, x: Array, seed: int | None = None
) -> None:
    files.write_summary(folder / "summary.json", _summary(device, result, seed))
    design = ", ".join(f"{name} = {value!r}" for name, value in device.named(x).items())
    more = (f"model: {device.model}", f"design: {design}")
    comments = files.comments(device.machine, "machine", more, seed)
    files.write_cycle_csv(folder / "cycle.csv", comments, turn.columns())


def _summary(device: Device, result: Mapping[str, Any], seed: int | None = None) -> dict[str, Any]:
    """The result, what it assumes, and what it can be had again from."""
    return {
        **result,
        "assumptions": device.sidecar["assumptions"],
        "input": device.machine.table(),
        "provenance": files.provenance(device.machine, seed),
    }


def _write_page(
    folder: Path,
    device: Device,
    result: Mapping[str, Any],
    drawn: Mapping[str, Figure],
    seed: int | None = None,
    moving: Motion | None = None,
) -> None:
    place = files.output_folder(folder / "figures") if drawn else folder
    inlined = {name: figures.save(figure, place, name) for name, figure in drawn.items()}
    provenance = files.provenance(device.machine, seed)
    page = device_page(device.machine, device.sidecar, result, inlined, provenance, moving)
    files.write_text(folder / "report.html", page)


def _moving(device: Device, x: Array, before: Array | None = None) -> Motion:
    """The machine over a turn."""
    dashed = "" if before is None else " Dashed: the path before the optimisation."
    return Motion(scene(device, x, before), f"{MOVING}{dashed}")


def _columns(device: Device, x: Array) -> dict[str, Array]:
    return cycle.cycle(device, device.prologue(x), curve_angles(device, x)).columns()


def _forces(devices: Mapping[str, Device], x: Array, start: Array | None = None) -> dict[str, Figure]:
    turns = {model: _columns(device, x) for model, device in devices.items()}
    before = {model: _columns(device, start) for model, device in devices.items()} if start is not None else {}
    curves, old = ({m: (t["phi_deg"], t["support_N"]) for m, t in of.items()} for of in (turns, before))
    exact = devices["exact"]
    support = figures.support_force(curves, cycle.weight(exact), _joints(exact, x), old)
    return {"support_force": support, "joint_forces": figures.joint_forces(turns)}


def _joints(device: Device, x: Array) -> dict[str, list[float]]:
    """Carrier angles [deg] of the joints of both sides, in the order of the model's events."""
    found: dict[str, list[float]] = {event["name"]: [] for event in device.sidecar["events"]}
    for place in places(device.force, device.prologue(x)):
        found[place.name].append(float(np.degrees(place.angle)))
    return {name: places for name, places in found.items() if places}


def _motion(device: Device, x: Array, start: Array | None = None) -> dict[str, Figure]:
    turn = _columns(device, x)
    old = None if start is None else _columns(device, start)
    return {
        "tip_path": figures.tip_path(turn, old, _soil(device, turn), _points(device)),
        "pitch_curves": figures.pitch_curves(gearing(device, x), None if start is None else gearing(device, start)),
        "rotation": figures.rotation(turn, ratios(device, x, turn["phi_deg"])),
    }


def _points(device: Device) -> Sequence[Sequence[float]]:
    """Points that the tip must pass: x, y and the radius of the tube [mm]."""
    required = device.machine.requirements
    return [] if required is None else required.points_mm or []


def _soil(device: Device, turn: Mapping[str, Array]) -> float | None:
    """Level of the soil [mm], where requirements say where it stands."""
    required = device.machine.requirements
    return None if required is None else required.surface_mm(float(turn["tip_y_mm"].min()))


def _search(device: Device, found: Optimisation) -> dict[str, Figure]:
    drawn = {"convergence": figures.convergence(found.found.history)}
    return drawn | _front(device, found) if found.front else drawn


def _front(device: Device, found: Optimisation) -> dict[str, Figure]:
    objective = weights(device.machine)
    marks = {
        "machine file": (found.result.start_range_N, found.result.start_variance_N2),
        "optimum": (found.result.range_N, found.result.variance_N2),
    }
    front = [one.evaluation.look for one in found.front]
    scored = [(one.range, one.variance) for one in (*front, *_cloud(device, found))]
    line = (objective.weight_range, objective.weight_variance) if objective.kind == "paper" else None
    return {"pareto": figures.pareto(np.array([*scored, *marks.values()]), marks, line)}


def _cloud(device: Device, found: Optimisation) -> list[Look]:
    """Turns of designs anywhere in the box."""
    task = problem(device, found.found.sampling)
    return [task.evaluate(u).look for u in np.random.default_rng(found.found.seed).random((CLOUD, device.size))]
