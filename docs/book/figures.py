"""Figures of the theory, drawn from the project's own numbers: gears that roll, teeth as envelopes, peaks of a turn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planter import Device, load_machine, simulate
from planter.gears.geometry.cutting import ToothOrder, cut_teeth
from planter.gears.geometry.pitch_curves import build_circle_pair
from planter.gears.geometry.polygons import build_polygon
from planter.papers.planting.report.scene import build_scene, list_nozzle_changes
from planter.papers.planting.toothed import locate_pitch_curves
from planter.report import style
from planter.report.animation import draw_stills
from planter.report.scene import Body, Outline, Scene
from planter.report.sheet import Length, Sheet, draw_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEETH, RADIUS = 20, 20.0
"""Teeth and pitch radius [mm] of the gear that shows how a flank comes about."""
SAMPLES = 24
"""Angles of a turn among which a peak is missed."""


def rolling() -> Figure:
    """The first stage of the built-in device at an angle: radii along the line of centres add up to its length."""
    device = Device(load_machine("wang2017"), "exact")
    found = locate_pitch_curves(device, device.design, 40.0)
    (sun, gear), (o, a1, p) = (
        found.curves[:2],
        (found.centres["O"], found.centres["A1"], found.contacts["P"]),
    )
    bodies = [
        Body(curve.name, (Outline(curve.points.T, "gear", shade=k),))
        for k, curve in enumerate((sun, gear))
    ]
    line = Body("line of centres", (Outline(np.array([o, a1]), "frame", closed=False),))
    scene = Scene("stage 1", "", "", np.zeros(1), 1.0, [*bodies, line])
    return draw_figure(
        Sheet(
            "rolling",
            "",
            scene,
            [Length(("r",), o, p), Length(("a - r",), p, a1), Length(("a",), o, a1, 0.9)],
        )
    )


@style.with_style
def envelope() -> Figure:
    """A rack's flank at steps of its roll on a pitch circle, and the tooth that planter cuts there."""
    module = 2 * RADIUS / TEETH
    found = cut_teeth(
        build_circle_pair(1e-3 * RADIUS, 1e-3 * RADIUS),
        ToothOrder(teeth=TEETH),
        "circle",
        ("gear", "mate"),
    )
    outline = 1e3 * build_polygon(found.mesh.gears[0])
    drawing = style.new_figure(4.6, 4.0)
    axes = drawing.subplots()
    turn = np.linspace(-0.35, 0.35, 121)
    axes.plot(
        RADIUS * np.cos(turn),
        RADIUS * np.sin(turn),
        color=style.SOFT,
        linestyle=(0, (8, 2, 1, 2)),
        label="pitch circle",
    )
    for side in (1, -1):
        for s in np.linspace(-4.5, 4.5, 15):
            axes.plot(*flank(s, side, module).T, color=style.VERMILION, linewidth=0.5)
    axes.plot(*outline.T, color=style.BLUE, label="tooth as cut")
    axes.plot([], [], color=style.VERMILION, linewidth=0.5, label="flanks of the rack")
    style.drawing_board(axes)
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlim=(RADIUS - 4, RADIUS + 4), ylim=(-4, 4))
    axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return drawing


def flank(s: float, side: int, module: float) -> np.ndarray:
    """A straight flank (2, 2) of the rack [mm] where it has rolled along an arc s of the circle, for the tooth at 0."""
    angle = s / RADIUS
    normal, tangent = (
        np.array([np.cos(angle), np.sin(angle)]),
        np.array([-np.sin(angle), np.cos(angle)]),
    )
    at = RADIUS * normal + (side * np.pi * module / 4 - s) * tangent
    along = (
        np.cos(ToothOrder().pressure_angle) * normal
        - side * np.sin(ToothOrder().pressure_angle) * tangent
    )
    reach = module / np.cos(ToothOrder().pressure_angle)
    return np.array([at - reach * along, at + reach * along])


@style.with_style
def peaks() -> Figure:
    """The support force over a turn, some samples of it, and its true extremes."""
    device = Device(load_machine("wang2017"), "exact")
    fine, coarse = simulate(device, samples=720), simulate(device, samples=SAMPLES)
    drawing = style.new_figure(2.6)
    axes = drawing.subplots()
    axes.plot(*_turn(fine), color=style.BLUE, label="force")
    axes.plot(*_turn(coarse), "o", color=style.VERMILION, markersize=3, label=f"{SAMPLES} samples")
    found, sampled = coarse.result.refined, coarse.result.support_force
    for extreme, near in ((found.max_N, sampled.max_N), (found.min_N, sampled.min_N)):
        axes.axhline(extreme, color=style.GREEN, linewidth=0.8)
        axes.axhline(near, color=style.VERMILION, linewidth=0.6, linestyle=(0, (4, 3)))
    axes.plot([], [], color=style.GREEN, linewidth=0.8, label="true extremes")
    axes.set_ylabel("support force / N")
    style.over_a_turn(axes)
    axes.legend(frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return drawing


def _turn(found: object) -> tuple[object, object]:
    table = found.to_frame()
    return table["phi_deg"], table["support_N"]


def changes() -> Figure:
    """The built-in device where its nozzles begin to close and to open, the tip of that nozzle marked."""
    device = Device(load_machine("wang2017"), "exact")
    scene = build_scene(device, device.design)
    seen = replace(scene, bodies=scene.bodies[:2], labels=())
    found, stills = list_nozzle_changes(device, device.design), {}
    for number, change in enumerate(found, 1):
        words = "opens" if change.opens else "closes"
        angle = f"{change.angle_deg:.1f}\N{DEGREE SIGN}"
        title = f"{number}: {angle}\nnozzle {change.side} {words}"
        stills[title] = seen, round(change.angle_deg) % scene.moments
    drawing = draw_stills(stills, 3.0)
    for axes, change, (_, moment) in zip(drawing.axes, found, stills.values(), strict=True):
        tip = scene.points[change.side - 1]
        at = np.array([tip.x, tip.y])[:, moment]
        axes.plot(*at, "o", color=style.VERMILION, markersize=5)
        axes.set_ylabel("y / mm" if axes is drawing.axes[0] else "")
        axes.locator_params(nbins=4)
    return drawing


FIGURES = {"changes": changes, "rolling": rolling, "envelope": envelope, "peaks": peaks}


def draw(folder: Path) -> None:
    """Writes every figure."""
    for name, make in FIGURES.items():
        (folder / f"theory-{name}.svg").write_text(style.render_svg(make()), encoding="utf-8")
