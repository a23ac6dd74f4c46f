"""The presentation of `planter cam`: what the terminal prints, and drawing, table, figures, page
and solid.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.files.document import Document
from planter.gears.results import Cam
from planter.gears.workshop.cam import SAMPLES, CamPart, Push, tabulate_contour
from planter.gears.workshop.drawing import format_dxf, format_svg
from planter.report import files, style
from planter.report.html import Block, Items, Keys, Section, Table, Text
from planter.report.labels import format_label
from planter.report.presentation import ResultPresentation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

CAPTIONS = {
    "contour": "Contour, pitch curve, and the roller at every 30 deg of the cam.",
    "limits": (
        "Pressure angle; 1 - roller / radius of curvature of the pitch curve, at zero the "
        "roller would cut in."
    ),
    "lifting": (
        "Force between cam and roller over a turn; the roller lifts off where it vanishes first."
    ),
}


@dataclass(frozen=True)
class CamOutput:
    """A cam with the context of its page: machine, meanings of its inputs, sidecar of the generated
    functions, contact force or None, the speed of the machine [rad/s]; and a function that builds
    its solid.
    """

    part: CamPart
    machine: Document
    meanings: Mapping[str, str]
    sidecar: Mapping[str, Any]
    push: Push | None
    machine_speed: float
    solid: Callable[[], bytes]

    @property
    def entries(self) -> Sequence[dict[str, str]]:
        """Name, unit and meaning of each result of the contour's functions."""
        return self.sidecar["vectors"]["contour"]


def present_cam(cam: CamOutput, step: bool = False, written: bool = False) -> ResultPresentation:
    """Return the presentation of a cam, with its solid if `step`; a `written` result names its
    files.

    Writing raises InputError if a solid needs Open CASCADE and it is not installed.
    """
    part = cam.part
    names = [
        "contour.dxf",
        "contour.svg",
        "contour.csv",
        *(["cam.step"] if step else []),
        "summary.json",
        "report.html",
    ]
    result = replace(part.result, files=names if written else [])
    title = f"Cam of {cam.machine.name}"
    model = Text(f"{cam.sidecar['title']} ({cam.sidecar['source']}). Assumptions:")
    return ResultPresentation(
        title=title,
        record=result,
        conclusion=_conclude(result),
        sections=[Section("Results", list(_list_results(result)))],
        document=cam.machine,
        meanings=cam.meanings,
        figures=lambda: _build_figures(cam),
        captions=CAPTIONS,
        details=lambda: [Section("Model", [model, Items(cam.sidecar["assumptions"])])],
        tables=lambda: {"contour.csv": tabulate_contour(part.profile, cam.entries)},
        comments=_describe_columns(cam),
        texts=lambda: {
            "contour.dxf": format_dxf(part.lines).decode(),
            "contour.svg": format_svg(part.lines, title),
            **({"cam.step": cam.solid().decode()} if step else {}),
        },
    )


def _conclude(result: Cam) -> str:
    angle = result.pressure_angle_deg
    lift = "stays on the cam" if result.lift_off is None else "would lift off the cam"
    return (
        f"The largest pressure angle is {angle.max:.4g} deg, at {angle.at_deg:.4g} deg; the "
        f"roller {lift}."
    )


def _list_results(result: Cam) -> Iterator[Block]:
    table = result.table()
    yield Keys({"kind": result.kind, "files": ", ".join(result.files)})
    for group in ("roller", "pressure_angle_deg", "lift_off", "contour"):
        if table[group] is not None:
            yield Table(
                ("quantity", "value"),
                [(format_label(key), value) for key, value in table[group].items()],
                format_label(group),
            )
    if result.lift_off is None:
        yield Text(
            "The roller does not lift off at any speed in the searched range, or no contact force "
            "was given.",
            "note",
        )


def _describe_columns(cam: CamOutput) -> Iterator[str]:
    result = cam.part.result
    roller = f"{result.kind} cam for a roller of a radius of {result.roller.radius_mm:g} mm"
    meanings = (f"{entry['name']}: {entry['meaning']}" for entry in cam.entries)
    yield from files.list_comments(cam.machine, "cam", (roller, *meanings))


def _build_figures(cam: CamOutput) -> dict[str, Figure]:
    plots = {"contour": plot_contour(cam.part), "limits": plot_limits(cam.part)}
    if cam.push is not None:
        lift_off = cam.part.result.lift_off
        share = 0.0 if lift_off is None else lift_off.speed_rpm / lift_off.own_speed_rpm
        plots["lifting"] = plot_lift_off(cam.push, cam.machine_speed, share * cam.machine_speed)
    return plots


ROLLERS = 12
"""Number of rollers in the figure of the contour."""
_TURN = np.linspace(0, 2 * np.pi, 2 * SAMPLES + 1)
_CHORD = 1e-5


@style.with_style
def plot_contour(part: CamPart) -> Figure:
    """Plot the outline, the pitch curve, and the roller at equal steps of the cam's angle."""
    from matplotlib.patches import Circle

    profile = part.profile
    figure = style.new_figure(6.0 if profile.closed else 2.6)
    axes = figure.subplots()
    for line in part.lines:
        points = line.arcs.points(_CHORD) * 1e3
        closing = points[:1] if line.arcs.closed else points[:0]
        x, y = np.vstack([points, closing]).T
        thin = line.layer in ("PITCH", "CENTRE")
        axes.plot(
            x,
            y,
            color=style.BLUE if line.layer == "PITCH" else style.SOFT if thin else style.INK,
            linewidth=0.7 if thin else 1.3,
            linestyle=(0, (5, 3)) if thin else "-",
        )
    centres = profile.course(2 * np.pi * np.arange(ROLLERS) / ROLLERS)
    for x, y in zip(*(centres[name] * 1e3 for name in profile.pitch), strict=True):
        axes.add_patch(
            Circle(
                (x, y), profile.roller * 1e3, fill=False, edgecolor=style.VERMILION, linewidth=0.7
            )
        )
    style.drawing_board(
        axes, *(("x / mm", "y / mm") if profile.closed else ("along / mm", "height / mm"))
    )
    axes.autoscale_view()
    return figure


@style.with_style
def plot_limits(part: CamPart) -> Figure:
    """Plot pressure angle and margin against undercutting by the roller over a turn of the cam."""
    columns = part.profile.course(_TURN)
    figure = style.new_figure(3.8)
    upper, lower = figure.subplots(2, 1, sharex=True)
    _plot_curve(upper, np.degrees(columns["pressure"]), "pressure angle / deg")
    _plot_curve(lower, columns["room"], "margin against\nundercut")
    lower.axhline(0, color=style.VERMILION, linewidth=0.8)
    lower.set_xlabel("cam angle / deg")
    return figure


@style.with_style
def plot_lift_off(push: Push, machine_speed: float, lift_off_speed: float) -> Figure:
    """Plot the force between cam and roller over a turn, at the machine's speed and the lift-off
    speed [rad/s], 0 without one.
    """
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    speeds = {"machine speed": machine_speed}
    if lift_off_speed:
        speeds["lift-off"] = lift_off_speed
    ends = []
    for index, (name, speed) in enumerate(speeds.items()):
        force, shade = push(_TURN, speed), style.curve_colour(name, index)
        _plot_curve(axes, force, "force on the roller / N", shade)
        ends.append((float(force[-1]), f"{name},\n{speed * 30 / np.pi:.4g} r/min", shade))
    axes.axhline(0, color=style.SOFT, linewidth=0.6)
    axes.set_xlabel("angle of the mechanism / deg")
    style.label_ends(axes, ends, 0.16)
    return figure


def _plot_curve(axes: Axes, values: Array, label: str, shade: str = style.BLUE) -> None:
    style.over_a_turn(axes, label=False)
    axes.plot(np.degrees(_TURN), values, color=shade, linewidth=1.2)
    axes.set_ylabel(label)
