"""Files of a device on a motor: summary, the turn as a table, one figure, the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planter.engine.tables import drive_tables
from planter.kernels import generated
from planter.mechanism.drawing import draw_drive_speeds, label_cycle_curves
from planter.planting import motor_drive
from planter.planting.cycle import compute_weight
from planter.planting.model import FORCE, Device
from planter.planting.motor_drive import NAME, DeviceDrive
from planter.planting.report.page import meanings
from planter.progress import Listener
from planter.report import bundle, files, style
from planter.report.html import FigureSvg, Items, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "drive"
CAPTION = (
    "Speed of the carrier from the start on, then over the turn that repeats itself, and the vertical support force of "
    "that turn beside the force at its mean speed, held constant."
)


def write(out: Path, device: Device, found: DeviceDrive, progress: Listener | None = None) -> None:
    """Writes summary.json, turn.csv, figures/drive and report.html. Raises InputError for a folder that it cannot."""
    files.output_folder(out)
    drawn = bundle.drawn({FIGURE: speed_and_force(found, compute_weight(device))}, progress)
    provenance, table = files.provenance(device.machine), found.result.table()
    summary = {**table, "input": device.machine.table(), "provenance": provenance}
    sections = [*_told(device, found, drawn[FIGURE].svg), provenance_section(provenance)]
    title = f"The planting device {device.machine.name} on a motor"
    texts = {
        "summary.json": files.summary_text(summary),
        "turn.csv": files.cycle_csv("turn.csv", files.comments(device.machine, "machine"), found.columns()),
        "report.html": page(title, sections, device.machine.description),
    }
    bundle.write(out, texts, drawn)


def _told(device: Device, found: DeviceDrive, svg: str) -> Iterator[Section]:
    model = generated.sidecar(NAME)
    motor, speed = drive_tables(found.result)
    yield Section("Motor", [Table(motor.head, motor.rows)])
    yield Section("Speed", [Table(speed.head, speed.rows)])
    yield Section("Forces", [Table(motor_drive.FORCE_HEAD, motor_drive.list_force_rows(found.result))])
    yield Section("Figure", [FigureSvg(svg, CAPTION)])
    yield Section("Model", [Text(f"{model['title']} ({model['source']}). It assumes:"), Items(model["assumptions"])])
    yield Section("Inputs", list(inputs(device.machine, meanings(model), besides=("bounds",))))


@style.drawn
def speed_and_force(found: DeviceDrive, weight_N: float) -> Figure:
    """Speed from the start on and over a turn, support force over that turn."""
    figure = style.new_figure(6.2)
    begun, over, force = figure.subplots(3, 1, height_ratios=(1, 1, 1.5))
    drive = found.drive
    draw_drive_speeds(drive, begun, over)
    ends = [(weight_N, f"weight {weight_N:.1f} N", style.INK)]
    for label, curve, shade in (
        ("driven", drive.driven.values[FORCE], style.BLUE),
        ("constant speed", drive.constant.values[FORCE], style.VERMILION),
    ):  # fmt: skip
        force.plot(np.degrees(drive.turn.phi), curve, color=shade, linewidth=1.2)
        ends.append((float(curve[-1]), label, shade))
    force.axhline(weight_N, color=style.INK, linewidth=0.8, linestyle=(0, (1, 2)))
    label_cycle_curves(force, "support force / N", ends)
    return figure
