"""Files of a mechanism on a motor: summary, the turn as a table, figures, the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planter.engine.drive import RPM
from planter.engine.driven import Drive
from planter.engine.machine import Machine
from planter.engine.shown import drive_tables, driven_quantities
from planter.mechanism.report import page
from planter.progress import Listener
from planter.report import files, style
from planter.report.html import Section, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def write_drive(out: Path, found: Drive, machine: Machine, progress: Listener | None = None) -> None:
    """Write summary.json, turn.csv, figures/drive and report.html.

    Raises InputError for a folder that it cannot write.
    """
    table = files.cycle_csv("turn.csv", files.comments(machine.document, "mechanism"), found.columns())
    page.write_tables(
        out, f"{machine.name} on a motor", machine, found.result.table(), _sections(found),
        {"drive": draw_speed_and_torque(found)}, {"turn.csv": table}, progress,
    )  # fmt: skip


def _sections(found: Drive) -> Iterator[Section]:
    motor, speed = drive_tables(found.result)
    forces = driven_quantities(found.result)
    yield Section("Motor", [Table(motor.head, motor.rows)])
    yield Section("Speed", [Table(speed.head, speed.rows, speed.title)])
    yield Section("Forces", [Table(forces.head, forces.rows, forces.title)])


@style.drawn
def draw_speed_and_torque(found: Drive) -> Figure:
    """Draw the speed from the start on and over a turn, and the torques on the shaft over that turn."""
    figure = style.new_figure(6.2)
    begun, over, torque = figure.subplots(3, 1, height_ratios=(1, 1, 1.5))
    draw_speeds(found, begun, over)
    angles, ends = np.degrees(found.turn.phi), []
    for label, curve, shade in (
        ("motor", found.driven.torque, style.VERMILION), ("load", found.driven.load, style.BLUE),
        ("load at constant speed", found.constant.load, style.INK),
    ):  # fmt: skip
        torque.plot(angles, curve, color=shade, linewidth=1.2)
        ends.append((float(curve[-1]), label, shade))
    draw_turn(torque, "torque / (N m)", ends)
    for axes in (over, torque):
        axes.set_xlabel("angle of the drive / deg")
    return figure


def draw_speeds(found: Drive, begun: Axes, over: Axes) -> None:
    """Draw the speed from the start on, and over the turn that repeats itself."""
    start, turn = found.started, found.turn
    begun.plot(start.phi / (2 * np.pi), start.omega * RPM, color=style.BLUE, linewidth=1.0)
    begun.set_xlim(0, start.phi[-1] / (2 * np.pi))
    begun.set_xlabel("turns from the start")
    begun.set_ylabel("speed / (r/min)")
    over.plot(np.degrees(turn.phi), turn.omega * RPM, color=style.BLUE)
    mean = found.result.speed.mean_rpm
    over.axhline(mean, color=style.VERMILION, linewidth=1.0)
    draw_turn(over, "speed / (r/min)", [(turn.omega[-1] * RPM, "driven", style.BLUE), (mean, "mean", style.VERMILION)])


def draw_turn(axes: Axes, label: str, ends: list[tuple[float, str, str]]) -> None:
    """Label curves over a turn at their ends."""
    style.over_a_turn(axes)
    axes.set_ylabel(label)
    style.label_ends(axes, ends, 0.12)
