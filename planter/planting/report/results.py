"""Files of a result: summary, cycle, figures, page, and the machine file of an optimum."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.files import paths, units
from planter.files.document import lines
from planter.optimise.range_variance import Sampling
from planter.optimise.response import list_breakpoints
from planter.planting import cycle
from planter.planting.file import Machine
from planter.planting.functions import MODELS
from planter.planting.model import Device
from planter.planting.objective import build_problem, find_curve_angles, read_weights
from planter.planting.report import figures
from planter.planting.report.page import render_device_page
from planter.planting.report.scene import build_scene
from planter.planting.results import OptimisationFound
from planter.planting.toothed import compute_ratios, locate_pitch_curves
from planter.report import files
from planter.report.folder import renews
from planter.version import __version__
from planter.view.animation import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.optimise.objective import ObjectiveSummary
    from planter.planting.optimisation import Optimisation
    from planter.planting.simulation import Simulation
    from planter.records import Record

SET = "assumed; set on the command line"
"""Origin of a number that was set for one call: the file's own word for it no longer holds."""

ROUNDED = 1e-15
"""Relative difference that the way through SI units makes."""


def format_optimum_file(machine: Machine, model: str, result: OptimisationFound, sampling: Sampling) -> str:
    """A machine file (TOML) with an optimum of `machine` as its design.

    Fed back it gives the
    optimum's objective: the samples of the search stand in it, where it had any.
    """
    numbers, table = machine.numbers(), machine.table()
    table["design"] = {name: _restore_digits(machine, name, value) for name, value in result.design.items()}
    if sampling != "refined":
        table["objective"]["samples"] = int(sampling)
    optimised = Machine.read(table, machine.source).numbers()
    previous = {path: numbers[path] for path, value in optimised.items() if value != numbers[path]}
    method = f"{model} model, {result.method}, seed {result.seed}, " + (
        "true extremes and integrals" if sampling == "refined" else f"{sampling} samples"
    )
    table["origin"] = _list_origins(machine, previous, method)
    head = [
        f"# The machine {json.dumps(machine.name)} with its design optimised by planter {__version__}: {method}.",
        f"# Objective {result.objective!r}, before {result.start_objective!r}. A comment tells what moved.",
    ]
    if result.teeth is not None:
        stages = (
            f"stage {stage.stage} has {stage.z} teeth of {stage.module_mm:.12g} mm" for stage in result.teeth.stages
        )
        head.append(f"# Whole teeth: {', '.join(stages)}.")
    notes = {path: f"was {' '.join((repr(value), units.unit(path))).rstrip()}" for path, value in previous.items()}
    return "\n".join([*head, "", *lines(table, notes)]) + "\n"


def _restore_digits(machine: Machine, name: str, value: float) -> float:
    """A design value whose way through SI units may have cost it its last bits: where it was, or within its bounds."""
    start, (lower, upper) = machine.design[name], machine.bounds[name]
    return start if math.isclose(value, start, rel_tol=ROUNDED) else min(max(value, lower), upper)


def _list_origins(machine: Machine, previous: Mapping[str, float], method: str) -> dict[str, str]:
    """Origins of the file, with words of their own for the numbers that moved or were set on the command line."""
    changed = dict.fromkeys((*machine.changed, *previous), SET)
    changed |= dict.fromkeys((path for path in previous if path.startswith("design.")), f"optimised ({method})")
    renamed = set(changed) | {paths.last_part(path) for path in changed}
    return {name: words for name, words in machine.origins.items() if name not in renamed} | changed


MOVING = (
    "The device over a turn, both sides, with the path of the tip. How wide the nozzle is drawn is a sketch: the "
    "machine file holds its length only; beside it, seen across, the halves that the cam opens."
)
CLOUD = 300
"""Designs drawn at random from the box, for the figure of the front."""


@renews
def write_simulation(out: Path, device: Device, simulation: Simulation) -> None:
    """Writes summary.json, cycle.csv, figures and report.html. Raises InputError for a folder that it cannot."""
    folder = files.output_folder(out)
    result = simulation.result.table()
    _write_numbers(folder, device, result, simulation.cycle, device.design)
    devices: dict[str, Device] = {m: device if m == device.model else Device(device.machine, m) for m in MODELS}
    plots = _forces(devices, device.design) | _motion(device, device.design)
    _write_page(folder, device, result, plots, moving=_moving(device, device.design))


@renews
def write_result(out: Path, device: Device, record: Record) -> None:
    """Writes summary.json and report.html. Raises InputError for a folder that it cannot write."""
    folder, result = files.output_folder(out), record.table()
    files.write_summary(folder / "summary.json", _summary(device, result))
    _write_page(folder, device, result, {})


def write_optimum(out: Path, device: Device, optimisation: Optimisation) -> None:
    """Writes summary.json, optimum.toml and the optimum's cycle.csv. Raises InputError for a folder that it cannot."""
    folder = files.output_folder(out)
    x, seed, sampling = optimisation.optimum.design, optimisation.optimum.seed, optimisation.optimum.sampling
    samples = device.machine.objective.samples if sampling == "refined" else sampling
    turn = cycle.evaluate_cycle(device, device.prologue(x), cycle.sample_angles(samples))
    files.write_text(
        folder / "optimum.toml", format_optimum_file(device.machine, device.model, optimisation.result, sampling)
    )
    _write_numbers(folder, device, optimisation.result.table(), turn, x, seed)


def draw_optimum(out: Path, device: Device, optimisation: Optimisation) -> None:
    """Writes figures and report.html of an optimum. Raises InputError for a folder that it cannot write."""
    folder, x = files.output_folder(out), optimisation.optimum.design
    plots = (
        _forces(optimisation.devices, x, device.design)
        | _search(device, optimisation)
        | _motion(device, x, device.design)
    )
    _write_page(
        folder, device, optimisation.result.table(), plots, optimisation.optimum.seed, _moving(device, x, device.design)
    )


def write_partial(out: Path, device: Device, partial: Mapping[str, Any], interrupted: bool = False) -> None:
    """Writes what an unfinished optimisation has found to summary.json."""
    folder = files.output_folder(out)
    marks = {"finished": False, **({"interrupted": True} if interrupted else {})}
    files.write_summary(folder / "summary.json", _summary(device, {**partial, **marks}))


def _write_numbers(
    folder: Path,
    device: Device,
    result: Mapping[str, Any],
    turn: cycle.DeviceCycleTable,
    x: Array,
    seed: int | None = None,
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
    plots: Mapping[str, Figure],
    seed: int | None = None,
    moving: Motion | None = None,
) -> None:
    figures_folder = files.output_folder(folder / "figures") if plots else folder
    svgs = {name: figures.save(figure, figures_folder, name) for name, figure in plots.items()}
    provenance = files.provenance(device.machine, seed)
    page = render_device_page(device.machine, device.sidecar, result, svgs, provenance, moving)
    files.write_text(folder / "report.html", page)


def _moving(device: Device, x: Array, before: Array | None = None) -> Motion:
    """The machine over a turn."""
    dashed = "" if before is None else " Dashed: the path before the optimisation."
    return Motion(build_scene(device, x, before), f"{MOVING}{dashed}")


def _columns(device: Device, x: Array) -> dict[str, Array]:
    return cycle.evaluate_cycle(device, device.prologue(x), find_curve_angles(device, x)).columns()


def _forces(devices: Mapping[str, Device], x: Array, start: Array | None = None) -> dict[str, Figure]:
    turns = {model: _columns(device, x) for model, device in devices.items()}
    before = {model: _columns(device, start) for model, device in devices.items()} if start is not None else {}
    curves, old_curves = ({m: (t["phi_deg"], t["support_N"]) for m, t in cycles.items()} for cycles in (turns, before))
    exact = devices["exact"]
    support = figures.draw_support_force(curves, cycle.compute_weight(exact), _joints(exact, x), old_curves)
    return {"support_force": support, "joint_forces": figures.draw_joint_forces(turns)}


def _joints(device: Device, x: Array) -> dict[str, list[float]]:
    """Carrier angles [deg] of the joints of both sides, in the order of the model's events."""
    angles_deg: dict[str, list[float]] = {event["name"]: [] for event in device.sidecar["events"]}
    for switching_point in list_breakpoints(device.force, device.prologue(x)):
        angles_deg[switching_point.name].append(float(np.degrees(switching_point.angle)))
    return {name: places for name, places in angles_deg.items() if places}


def _motion(device: Device, x: Array, start: Array | None = None) -> dict[str, Figure]:
    turn = _columns(device, x)
    columns_before = None if start is None else _columns(device, start)
    return {
        "tip_path": figures.draw_tip_path(turn, columns_before, _soil(device, turn), _points(device)),
        "pitch_curves": figures.draw_pitch_curves(
            locate_pitch_curves(device, x), None if start is None else locate_pitch_curves(device, start)
        ),
        "rotation": figures.draw_rotation(turn, compute_ratios(device, x, turn["phi_deg"])),
    }


def _points(device: Device) -> Sequence[Sequence[float]]:
    """Points that the tip must pass: x, y and the radius of the tube [mm]."""
    required = device.machine.requirements
    return [] if required is None else required.points_mm or []


def _soil(device: Device, turn: Mapping[str, Array]) -> float | None:
    """Level of the soil [mm], where requirements say where it stands."""
    required = device.machine.requirements
    return None if required is None else required.surface_mm(float(turn["tip_y_mm"].min()))


def _search(device: Device, optimisation: Optimisation) -> dict[str, Figure]:
    plots = {"convergence": figures.convergence(optimisation.optimum.history)}
    return plots | _front(device, optimisation) if optimisation.front else plots


def _front(device: Device, optimisation: Optimisation) -> dict[str, Figure]:
    objective = read_weights(device.machine)
    marks = {
        "machine file": (optimisation.result.start_range_N, optimisation.result.start_variance_N2),
        "optimum": (optimisation.result.range_N, optimisation.result.variance_N2),
    }
    front = [point.evaluation.look for point in optimisation.front]
    points = [(point.range, point.variance) for point in (*front, *_cloud(device, optimisation))]
    line = (objective.weight_range, objective.weight_variance) if objective.kind == "paper" else None
    return {"pareto": figures.pareto(np.array([*points, *marks.values()]), marks, line)}


def _cloud(device: Device, optimisation: Optimisation) -> list[ObjectiveSummary]:
    """Turns of designs anywhere in the box."""
    task = build_problem(device, optimisation.optimum.sampling)
    return [
        task.evaluate(u).look for u in np.random.default_rng(optimisation.optimum.seed).random((CLOUD, device.size))
    ]
