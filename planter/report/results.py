"""Result files of the commands: summary, cycle, figures and page in one folder."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter import optimise, planting
from planter.device import MODELS, Device
from planter.report import figures, files, gearing
from planter.report.planting import device_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.optimisation import Optimisation
    from planter.planting import Cycle
    from planter.simulate import Simulation

Named = tuple[str, "Figure"]
FRONT_POINTS = 15
"""Weightings of range and variance on the way along a Pareto front."""


def write_simulation(folder: Path, device: Device, found: Simulation) -> None:
    """Files of `planter simulate --out`. Raises InputError if the folder cannot be written."""
    place = files.output_folder(folder)
    devices = {model: device if model == device.model else Device(device.machine, model) for model in MODELS}
    cycles = {model: _cycle(other, device.design, found.result["samples"]) for model, other in devices.items()}
    drawn = list(_device_figures(device, device.design, cycles, {}))
    _write(place, device, device.design, found.cycle, found.result, drawn)


def write_optimisation(folder: Path, device: Device, found: Optimisation) -> None:
    """Files of `planter optimise --out`: those of the optimum, with the search and the Pareto front."""
    place = files.output_folder(folder)
    x, count = found.found.design, _samples(device, found.result["samples"])
    cycles = {model: _cycle(other, x, count) for model, other in found.devices.items()}
    before = {model: _cycle(other, device.design, count) for model, other in found.devices.items()}
    drawn = list(_device_figures(device, x, cycles, before))
    drawn.append(("convergence", figures.convergence(found.found.history)))
    drawn.append(("pareto", _pareto(device, found.result)))
    _write(place, device, x, cycles[device.model], found.result, drawn, found.found.seed)


def write_sensitivity(folder: Path, device: Device, result: Mapping[str, Any]) -> None:
    """Files of `planter sensitivity --out`: the summary."""
    place = files.output_folder(folder)
    files.write_summary(place / "summary.json", _summary(device, result))


def write_partial(folder: Path, device: Device, partial: Mapping[str, Any]) -> None:
    """What an interrupted optimisation had found."""
    place = files.output_folder(folder)
    files.write_summary(place / "summary.json", _summary(device, {**partial, "interrupted": True}))


def _summary(device: Device, result: Mapping[str, Any], seed: int | None = None) -> dict[str, Any]:
    return {
        **result,
        "assumptions": device.sidecar["assumptions"],
        "input": device.machine.table(),
        "provenance": files.provenance(device.machine, seed),
    }


def _write(
    place: Path,
    device: Device,
    x: Array,
    turn: Cycle,
    result: Mapping[str, Any],
    drawn: list[Named],
    seed: int | None = None,
) -> None:
    design = planting.shown_design(device, x)
    drawings = files.output_folder(place / "figures")
    for name, figure in drawn:
        figures.save(figure, drawings, name)
    comments = files.comments(device.machine, device.model, design, seed)
    files.write_cycle_csv(place / "cycle.csv", comments, turn.columns())
    summary = _summary(device, result, seed)
    files.write_summary(place / "summary.json", summary)
    inline = {name: figures.svg(figure) for name, figure in drawn}
    page = device_page(device.machine, device.sidecar, result, inline, summary["provenance"])
    files.write_text(place / "report.html", page)


def _cycle(device: Device, x: Array, samples: int) -> Cycle:
    return planting.cycle(device, device.prologue(x), planting.angles(samples))


def _samples(device: Device, sampling: int | str) -> int:
    return device.machine.objective.samples if isinstance(sampling, str) else sampling


def _device_figures(
    device: Device, x: Array, cycles: Mapping[str, Cycle], before: Mapping[str, Cycle]
) -> Iterator[Named]:
    curves, old = ({m: (c.columns()["phi_deg"], c.support) for m, c in of.items()} for of in (cycles, before))
    columns = {model: cycle.columns() for model, cycle in cycles.items()}
    own = columns[device.model]
    yield "support_force", figures.support_force(curves, planting.weight(device), _joints(device, x), old)
    yield "tip_path", figures.tip_path(own, device.machine.nozzle.tip_distance_mm)
    yield "pitch_curves", figures.pitch_curves(gearing.gearing(device, x))
    yield "rotation", figures.rotation(own, gearing.ratios(device, x, own["phi_deg"]))
    yield "joint_forces", figures.joint_forces(columns)


def _joints(device: Device, x: Array) -> dict[str, list[float]]:
    found: defaultdict[str, list[float]] = defaultdict(list)
    for place in optimise.joints_of(device, x):
        found[place.name].append(float(np.degrees(place.angle)))
    return dict(found)


def _pareto(device: Device, result: Mapping[str, Any]) -> Figure:
    front = optimise.front(device, result["samples"], FRONT_POINTS)
    points = np.array([(one.evaluation.range_N, one.evaluation.variance_N2) for one in front])
    marks = {
        "machine file": (result["start_range_N"], result["start_variance_N2"]),
        "optimum": (result["range_N"], result["variance_N2"]),
    }
    return figures.pareto(points, marks)
