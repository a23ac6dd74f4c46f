"""What the sensor of a machine file sees of a cycle, in reports: a section, and a figure with the
rigid curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.measured.findings import MeasurementResult
from planter.measured.sensor_curve import SensorSignal
from planter.report import style
from planter.report.html import Block, Items, Keys, Section
from planter.report.labels import format_name
from planter.report.subject import Reading

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "measurement"
"""Name of the figure."""
CAPTION = (
    "The measured quantity of the rigid machine, and what the sensor sees of it by "
    "[measurement] of the file."
)
RIGID = "the sensor sees the rigid machine"


def list_measurement_sections(result: MeasurementResult | None) -> Iterator[Section]:
    """Yield the section on what a sensor sees, if the machine file states it."""
    if result is None:
        return
    unit = result.unit or "1"
    keys = {f"{name} / {unit}": getattr(result, name) for name in ("max", "min", "range", "mean")}
    square = f"variance / {unit}2" if unit.isalnum() else f"variance / ({unit})2"
    sentences = [f"{sentence[0].upper()}{sentence[1:]}." for sentence in result.seen or [RIGID]]
    blocks: list[Block] = [Items(sentences), Keys({**keys, square: result.variance})]
    yield Section(f"Measurement, {result.quantity}", blocks)


def list_signal_readings(signal: SensorSignal | None) -> list[Reading]:
    """Return the extremes of what a sensor sees, none without a signal."""
    if signal is None:
        return []
    result = signal.result
    return [
        Reading(f"{signal.name}, {kind}", result.unit, value)
        for kind, value in (("largest", result.max), ("least", result.min))
    ]


def draw_signals(signal: SensorSignal | None, angle: str, end: float = 360.0) -> dict[str, Figure]:
    """Return the figure of a signal by its name, none without a signal, as `draw_signal`."""
    return {} if signal is None else {FIGURE: draw_signal(signal, angle, end)}


@style.with_style
def draw_signal(signal: SensorSignal, angle: str, end: float) -> Figure:
    """Draw the rigid curve and the signal over a cycle that ends at an angle [deg]; `angle` is the
    axis label.
    """
    figure = style.new_figure(3.2)
    axes = figure.subplots()
    style.over_a_turn(axes, end=end)
    ends = []
    phi = np.append(signal.angles_deg, end)
    for name, values, shade in (
        ("rigid", signal.rigid, style.SOFT),
        ("measured", signal.signal, style.BLUE),
    ):
        closed = np.append(values, values[0])
        axes.plot(phi, closed, color=shade, linewidth=1.3)
        ends.append((float(closed[-1]), name, shade))
    key = signal.view.quantity.key
    axes.set_xlabel(angle)
    axes.set_ylabel(f"{format_name(key)} / {units.display_unit(key) or '1'}")
    axes.autoscale_view()
    style.label_ends(axes, ends, 0.07)
    return figure
