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
from planter.planting.report.page import device_page
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
    own, table = machine.numbers(), machine.table()
    table["design"] = {name: _restore_digits(machine, name, value) for name, value in result.design.items()}
    if sampling != "refined":
        table["objective"]["samples"] = int(sampling)
    reached = Machine.read(table, machine.source).numbers()
    was = {path: own[path] for path, value in reached.items() if value != own[path]}
    how = f"{model} model, {result.method}, seed {result.seed}, " + (
        "true extremes and integrals" if sampling == "refined" else f"{sampling} samples"
    )
    table["origin"] = _list_origins(machine, was, how)
    head = [
        f"# The machine {json.dumps(machine.name)} with its design optimised by planter {__version__}: {how}.",
        f"# Objective {result.objective!r}, before {result.start_objective!r}. A comment tells what moved.",
    ]
    if result.teeth is not None:
        told = (f"stage {one.stage} has {one.z} teeth of {one.module_mm:.12g} mm" for one in result.teeth.stages)
        head.append(f"# Whole teeth: {', '.join(told)}.")
    notes = {path: f"was {' '.join((repr(value), units.unit(path))).rstrip()}" for path, value in was.items()}
    return "\n".join([*head, "", *lines(table, notes)]) + "\n"


def _restore_digits(machine: Machine, name: str, value: float) -> float:
    """A design value whose way through SI units may have cost it its last bits: where it was, or within its bounds."""
    own, (lower, upper) = machine.design[name], machine.bounds[name]
    return own if math.isclose(value, own, rel_tol=ROUNDED) else min(max(value, lower), upper)


def _list_origins(machine: Machine, was: Mapping[str, float], how: str) -> dict[str, str]:
    """Origins of the file, with words of their own for the numbers that moved or were set on the command line."""
    changed = dict.fromkeys((*machine.changed, *was), SET)
    changed |= dict.fromkeys((path for path in was if path.startswith("design.")), f"optimised ({how})")
    named = set(changed) | {paths.last_part(path) for path in changed}
    return {name: words for name, words in machine.origins.items() if name not in named} | changed


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
    turn = cycle.evaluate_cycle(device, device.prologue(x), cycle.sample_angles(samples))
    files.write_text(folder / "optimum.toml", format_optimum_file(device.machine, device.model, found.result, sampling))
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
    return Motion(build_scene(device, x, before), f"{MOVING}{dashed}")


def _columns(device: Device, x: Array) -> dict[str, Array]:
    return cycle.evaluate_cycle(device, device.prologue(x), find_curve_angles(device, x)).columns()


def _forces(devices: Mapping[str, Device], x: Array, start: Array | None = None) -> dict[str, Figure]:
    turns = {model: _columns(device, x) for model, device in devices.items()}
    before = {model: _columns(device, start) for model, device in devices.items()} if start is not None else {}
    curves, old = ({m: (t["phi_deg"], t["support_N"]) for m, t in of.items()} for of in (turns, before))
    exact = devices["exact"]
    support = figures.support_force(curves, cycle.compute_weight(exact), _joints(exact, x), old)
    return {"support_force": support, "joint_forces": figures.joint_forces(turns)}


def _joints(device: Device, x: Array) -> dict[str, list[float]]:
    """Carrier angles [deg] of the joints of both sides, in the order of the model's events."""
    found: dict[str, list[float]] = {event["name"]: [] for event in device.sidecar["events"]}
    for place in list_breakpoints(device.force, device.prologue(x)):
        found[place.name].append(float(np.degrees(place.angle)))
    return {name: places for name, places in found.items() if places}


def _motion(device: Device, x: Array, start: Array | None = None) -> dict[str, Figure]:
    turn = _columns(device, x)
    old = None if start is None else _columns(device, start)
    return {
        "tip_path": figures.tip_path(turn, old, _soil(device, turn), _points(device)),
        "pitch_curves": figures.pitch_curves(
            locate_pitch_curves(device, x), None if start is None else locate_pitch_curves(device, start)
        ),
        "rotation": figures.rotation(turn, compute_ratios(device, x, turn["phi_deg"])),
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
    objective = read_weights(device.machine)
    marks = {
        "machine file": (found.result.start_range_N, found.result.start_variance_N2),
        "optimum": (found.result.range_N, found.result.variance_N2),
    }
    front = [one.evaluation.look for one in found.front]
    scored = [(one.range, one.variance) for one in (*front, *_cloud(device, found))]
    line = (objective.weight_range, objective.weight_variance) if objective.kind == "paper" else None
    return {"pareto": figures.pareto(np.array([*scored, *marks.values()]), marks, line)}


def _cloud(device: Device, found: Optimisation) -> list[ObjectiveSummary]:
    """Turns of designs anywhere in the box."""
    task = build_problem(device, found.found.sampling)
    return [task.evaluate(u).look for u in np.random.default_rng(found.found.seed).random((CLOUD, device.size))]
