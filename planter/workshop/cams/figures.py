"""Figures of a cam: contour and pitch curve with the roller on its way, what limits it, when the roller lifts off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.report import style
from planter.workshop.cams.lifting import Push
from planter.workshop.cams.part import Part
from planter.workshop.cams.profile import SAMPLES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

ROLLERS = 12
"""Rollers that are drawn along the contour."""
_TURN = np.linspace(0, 2 * np.pi, 2 * SAMPLES + 1)
_CHORD = 1e-5


@style.drawn
def contour(part: Part) -> Figure:
    """The outline as drawn, the pitch curve, and the roller at equal steps of the cam's angle."""
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
    at = profile.course(2 * np.pi * np.arange(ROLLERS) / ROLLERS)
    for x, y in zip(*(at[name] * 1e3 for name in profile.pitch), strict=True):
        axes.add_patch(Circle((x, y), profile.roller * 1e3, fill=False, edgecolor=style.VERMILION, linewidth=0.7))
    style.drawing_board(axes, *(("x / mm", "y / mm") if profile.closed else ("along / mm", "height / mm")))
    axes.autoscale_view()
    return figure


@style.drawn
def limits(part: Part) -> Figure:
    """Pressure angle, and how far the roller is from cutting off the contour, over a turn of the cam."""
    found = part.profile.course(_TURN)
    figure = style.new_figure(3.8)
    upper, lower = figure.subplots(2, 1, sharex=True)
    _curve(upper, np.degrees(found["pressure"]), "pressure angle / deg")
    _curve(lower, found["room"], "undercut margin (negative: undercut)")
    lower.axhline(0, color=style.VERMILION, linewidth=0.8)
    lower.set_xlabel("cam angle / deg")
    return figure


@style.drawn
def lifting(push: Push, own_speed: float, lifted: float | None) -> Figure:
    """The force between cam and roller over a turn, at the own speed and at that where the roller lifts off [rad/s]."""
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    speeds = {"own speed": own_speed} | ({} if not lifted else {"lift-off": lifted})
    ends = []
    for index, (name, speed) in enumerate(speeds.items()):
        force, shade = push(_TURN, speed), style.colour(name, index)
        _curve(axes, force, "force on the roller / N", shade)
        ends.append((float(force[-1]), f"{name},\n{speed * 30 / np.pi:.4g} r/min", shade))
    axes.axhline(0, color=style.SOFT, linewidth=0.6)
    axes.set_xlabel("angle of the mechanism / deg")
    style.label_ends(axes, ends, 0.16)
    return figure


def _curve(axes: Axes, values: Array, label: str, shade: str = style.BLUE) -> None:
    style.over_a_turn(axes, label=False)
    axes.plot(np.degrees(_TURN), values, color=shade, linewidth=1.2)
    axes.set_ylabel(label)
