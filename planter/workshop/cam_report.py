"""Files of `planter cam --out` (drawing, preview, table, figures, page, solid) and its tables for the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.files.document import Document
from planter.report import bundle, files, style
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.terminal.console import Console
from planter.workshop import drawing
from planter.workshop.cam import SAMPLES, CamPart, Push, tabulate_contour
from planter.workshop.cam_results import Cam
from planter.workshop.drawing import format_dxf

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

CAPTIONS = {
    "contour": "Contour, pitch curve, and the roller at every 30 deg of the cam.",
    "limits": "Pressure angle; 1 - roller / radius of curvature of the pitch curve, at zero the roller would cut in.",
    "lifting": "Force between cam and roller over a turn; the roller lifts off where it vanishes first.",
}


@dataclass(frozen=True)
class CamPageContent:
    """Context of a cam's page: machine, meanings of its inputs, sidecar of the generated functions, contact force or
    None, and the speed of the machine [rad/s]."""

    machine: Document
    meanings: Mapping[str, str]
    sidecar: Mapping[str, Any]
    push: Push | None
    machine_speed: float

    @property
    def entries(self) -> Sequence[dict[str, str]]:
        """Name, unit and meaning of each result of the contour's functions."""
        entries: Sequence[dict[str, str]] = self.sidecar["vectors"]["contour"]
        return entries


@dataclass(frozen=True)
class CamOutput:
    """A cam with the content of its page, and a function that builds its solid."""

    part: CamPart
    content: CamPageContent
    solid: Callable[[], bytes]


def write_cam(out: Path, cam: CamOutput, step: bool) -> Cam:
    """Write all files or none, and return the result with their names.

    Raises InputError if the folder cannot be written, or if a solid needs Open CASCADE and it is not installed.
    """
    files.output_folder(out)
    part, content = cam.part, cam.content
    rendered = bundle.drawn(_build_figures(part, content))
    provenance = files.provenance(content.machine)
    texts = {
        "contour.dxf": format_dxf(part.lines).decode(),
        "contour.svg": drawing.format_svg(part.lines, f"Cam of {content.machine.name}"),
        "contour.csv": files.cycle_csv(
            "contour.csv", _describe_columns(part, content), tabulate_contour(part.profile, content.entries)
        ),
        **({"cam.step": cam.solid().decode()} if step else {}),
    }
    result = replace(part.result, files=[*texts, "summary.json", "report.html"])
    texts["summary.json"] = files.summary_text(
        {**result.table(), "input": content.machine.table(), "provenance": provenance}
    )
    sections = [*_describe_results(result), *_describe_inputs(content, rendered, provenance)]
    texts["report.html"] = page(f"Cam of {content.machine.name}", sections, content.machine.description)
    bundle.write(out, texts, rendered)
    return result


def _build_figures(part: CamPart, content: CamPageContent) -> dict[str, Any]:
    plots = {"contour": plot_contour(part), "limits": plot_limits(part)}
    if content.push is not None:
        lift_off = part.result.lift_off
        speed = None if lift_off is None else lift_off.speed_rpm / lift_off.own_speed_rpm * content.machine_speed
        plots["lifting"] = plot_lift_off(content.push, content.machine_speed, speed)
    return plots


def _describe_columns(part: CamPart, content: CamPageContent) -> Iterator[str]:
    roller = f"{part.result.kind} cam for a roller of a radius of {part.result.roller.radius_mm:g} mm"
    meanings = (f"{entry['name']}: {entry['meaning']}" for entry in content.entries)
    yield from files.comments(content.machine, "cam", (roller, *meanings))


def _describe_results(result: Cam) -> Iterator[Section]:
    yield Section("Results", list(_list_results(result)))


def _list_results(result: Cam) -> Iterator[Block]:
    tabulate_contour = result.table()
    yield Keys({"kind": result.kind, "files": ", ".join(result.files)})
    for group in ("roller", "pressure_angle_deg", "lift_off", "contour"):
        if tabulate_contour[group] is not None:
            rows = [(label(key), value) for key, value in tabulate_contour[group].items()]
            yield Table(("quantity", "value"), rows, label(group))
    if result.lift_off is None:
        yield Text(
            "The roller does not lift off at any speed in the searched range, or no contact force was given.", "note"
        )


def _describe_inputs(
    content: CamPageContent, rendered: Mapping[str, bundle.Drawn], provenance: Mapping[str, Any]
) -> Iterator[Section]:
    yield Section("Figures", [FigureSvg(figure.svg, CAPTIONS[name]) for name, figure in rendered.items()])
    title = Text(f"{content.sidecar['title']} ({content.sidecar['source']}). Assumptions:")
    yield Section("Model", [title, Items(content.sidecar["assumptions"])])
    yield Section("Inputs", list(inputs(content.machine, content.meanings)))
    yield provenance_section(provenance)


ROLLERS = 12
"""Number of rollers in the figure of the contour."""
_TURN = np.linspace(0, 2 * np.pi, 2 * SAMPLES + 1)
_CHORD = 1e-5


@style.drawn
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
        axes.plot(x, y, color=style.BLUE if line.layer == "PITCH" else style.SOFT if thin else style.INK,
                  linewidth=0.7 if thin else 1.3, linestyle=(0, (5, 3)) if thin else "-")  # fmt: skip
    centres = profile.course(2 * np.pi * np.arange(ROLLERS) / ROLLERS)
    for x, y in zip(*(centres[name] * 1e3 for name in profile.pitch), strict=True):
        axes.add_patch(Circle((x, y), profile.roller * 1e3, fill=False, edgecolor=style.VERMILION, linewidth=0.7))
    style.drawing_board(axes, *(("x / mm", "y / mm") if profile.closed else ("along / mm", "height / mm")))
    axes.autoscale_view()
    return figure


@style.drawn
def plot_limits(part: CamPart) -> Figure:
    """Plot pressure angle and margin against undercutting by the roller over a turn of the cam."""
    columns = part.profile.course(_TURN)
    figure = style.new_figure(3.8)
    upper, lower = figure.subplots(2, 1, sharex=True)
    _plot_curve(upper, np.degrees(columns["pressure"]), "pressure angle / deg")
    _plot_curve(lower, columns["room"], "undercut margin (negative: undercut)")
    lower.axhline(0, color=style.VERMILION, linewidth=0.8)
    lower.set_xlabel("cam angle / deg")
    return figure


@style.drawn
def plot_lift_off(push: Push, machine_speed: float, lift_off_speed: float | None) -> Figure:
    """Plot the force between cam and roller over a turn, at the machine's speed and the lift-off speed [rad/s]."""
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    speeds = {"machine speed": machine_speed} | ({} if not lift_off_speed else {"lift-off": lift_off_speed})
    ends = []
    for index, (name, speed) in enumerate(speeds.items()):
        force, shade = push(_TURN, speed), style.colour(name, index)
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


def show_cam(console: Console, result: Cam) -> None:
    """Print roller, pressure angle, lift-off, contour and files."""
    roller, pressure, lift_off = result.roller, result.pressure_angle_deg, result.lift_off
    rows: list[tuple[str, float | None, str, float | None]] = [
        ("radius of the roller", roller.radius_mm, "mm", None),
        ("smallest concave radius of the pitch curve", roller.least_curvature_radius_mm, "mm", roller.at_deg),
        ("1 - roller radius / that radius", roller.margin, "", None),
        ("largest pressure angle", pressure.max, "deg", pressure.at_deg),
        ("length of the contour", result.contour.length_mm, "mm", None),
        ("arcs of the contour", result.contour.arcs, "", None),
        ("largest deviation of the arcs", result.contour.deviation_um, "um", None),
    ]
    console.table(f"{result.machine}: {result.kind} cam", ("quantity", "value", "unit", "cam angle / deg"), rows)
    if lift_off is not None:
        speeds = [
            ("lifts off at", lift_off.speed_rpm, lift_off.angle_deg),
            ("machine speed", lift_off.own_speed_rpm, None),
        ]
        console.table("Roller", ("", "r/min", "angle / deg"), speeds)
    if result.files:
        console.table("Files", ("name",), [(name,) for name in result.files])
