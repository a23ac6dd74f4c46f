"""Figures of a pair that dwells, and the pair in motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.gearing.teeth.incomplete.proof import FREE, Turn
from planter.gearing.teeth.incomplete.rows import SIDES
from planter.gears.parts import Placed
from planter.gears.report.figures import assembly
from planter.gears.report.scene import MOMENTS, SECONDS, drawn
from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.report import style
from planter.view.scene import Body, Curve, Event, Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MM = 1e3
_SIDES = ("flanks that drive", "flanks that hold back")
_HIGH = 5.0
"""Loose motion that is drawn [deg]; what is larger leaves the figure."""


def figures(turn: Turn, gears: Sequence[Placed]) -> dict[str, Figure]:
    """All figures by the names of their files."""
    return {"assembly": assembly(gears), "dwell": dwell(turn), "loose": loose(turn), "lands": lands(turn)}


@style.drawn
def dwell(turn: Turn) -> Figure:
    """Both gears about the line of centres where the dwell begins, in its middle, and where it ends."""
    figure = style.new_figure(4.2)
    found, rolling = turn.gears, turn.gears.rolling
    shown = {
        "the dwell begins": rolling.places(np.array([rolling.length])),
        "the middle of the dwell": rolling.held(np.array([0.5])),
        "the dwell ends": rolling.places(np.zeros(1)),
    }
    for axes, (title, where) in zip(figure.subplots(1, 3, sharey=True), shown.items(), strict=True):
        for gear, place, shade in zip(found.gears, where, (style.BLUE, style.VERMILION), strict=True):
            outline = np.vstack([gear.points, gear.points[:1]])
            line = outline @ np.array([1, 1j]) * np.exp(1j * place[0]) + place[1]
            axes.fill(_MM * line.real, _MM * line.imag, facecolor=shade, alpha=0.12, edgecolor="none")
            axes.plot(_MM * line.real, _MM * line.imag, color=shade, linewidth=0.8, label=gear.name)
        axes.set_aspect("equal")
        axes.set_xlim(_MM * found.radius - 12, _MM * found.radius + 12)
        axes.set_ylim(-_MM * found.radius, _MM * found.radius)
        axes.set_title(title)
    figure.axes[0].legend(loc="upper left", frameon=False)
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure


@style.drawn
def loose(turn: Turn) -> Figure:
    """Over a turn: how many flanks touch, and how far the driven gear can turn from where its law has it."""
    figure = style.new_figure(4.6)
    above, below = figure.subplots(2, 1, sharex=True)
    rolling, found = turn.gears.rolling, turn.loose
    at = np.degrees(-rolling.places(turn.rolled)[0][0])
    for side, label, shade, width in zip(SIDES, _SIDES, (style.BLUE, style.ORANGE), (2.2, 0.9), strict=True):
        above.step(at, turn.mesh.touching(turn.rolled, side).sum(axis=1), where="mid", label=label, color=shade,
                   linewidth=width)  # fmt: skip
    above.set_ylabel("flanks in contact")
    above.set_yticks(range(4))
    above.set_ylim(-0.2, 3.6)
    above.legend(loc="upper left", frameon=False, ncols=2)
    for values, label, shade in ((-found.behind, "behind its law", style.BLUE), (found.ahead, "ahead", style.ORANGE)):
        stopped = np.abs(values) < FREE
        below.plot(np.degrees(found.at), np.degrees(np.where(stopped, values, np.nan)), ".-", label=label, color=shade,
                   linewidth=0.8, markersize=3)  # fmt: skip
        below.plot(np.degrees(found.at[~stopped]), np.full((~stopped).sum(), 0.88 * _HIGH), "^", color=shade,
                   label="as far as it likes" if not stopped.all() else None)  # fmt: skip
    below.axvspan(
        *np.degrees([rolling.over[1], rolling.over[1] + rolling.dwell]),
        color=style.FAINT,
        alpha=0.4,
        linewidth=0,
        label="dwell",
    )
    below.set_ylim(-_HIGH, _HIGH)
    below.set_ylabel("loose motion / deg")
    below.set_xlabel(f"polar angle of {turn.gears.gear.name} / deg")
    below.legend(loc="upper center", frameon=False, ncols=2, fontsize=7)
    return figure


@style.drawn
def lands(turn: Turn) -> Figure:
    """Of each tooth as the rack leaves it: the margin of both flanks against undercut, and the top land."""
    figure = style.new_figure(4.2)
    above, below = figure.subplots(2, 1)
    for gear, shade in zip(turn.gears.gears, (style.BLUE, style.VERMILION), strict=True):
        flanks, teeth = gear.row.flanks, np.arange(gear.z)
        for side, mark in zip(SIDES, (":", "-"), strict=True):
            label = f"{gear.name}, {'begin' if side < 0 else 'end'} a tooth"
            above.plot(teeth, flanks.margins[flanks.side == side], mark, color=shade, label=label)
        below.plot(teeth, gear.row.top_lands / gear.rack.module, color=shade, label=gear.name)
    above.axhline(0, color=style.INK, linewidth=0.6)
    above.set_ylabel("margin against\nundercut")
    below.set_ylim(0, 1)
    below.set_ylabel("top land / module")
    below.set_xlabel("tooth")
    above.legend(frameon=False, ncols=2, fontsize=7)
    below.legend(frameon=False, ncols=2)
    return figure


def scene(turn: Turn) -> Scene:
    """A turn of the driving gear, from where the dwell ends."""
    rolling = turn.gears.rolling
    first, last = rolling.over
    at = first + np.arange(MOMENTS) * TURN / MOMENTS
    on_teeth = at <= last
    mate: Array = np.hstack([
        rolling.places(rolling.rolled(at[on_teeth]))[1], rolling.held((at[~on_teeth] - last) / rolling.dwell)[1],
    ])  # fmt: skip
    angles = -np.degrees(at), np.degrees(np.unwrap(mate[0]))
    axes = (0.0, 0.0), (_MM * rolling.pair.distance, 0.0)
    bodies = [
        Body(gear.name, (drawn(gear.points, gear.rack.module, shade),), axis, angle)
        for shade, (gear, axis, angle) in enumerate(zip(turn.gears.gears, axes, angles, strict=True))
    ]
    turned = np.degrees(at - first)
    return Scene(
        title=" and ".join(gear.name for gear in turn.gears.gears),
        place=f"rotation of {turn.gears.gear.name} from the end of the dwell",
        unit="deg",
        places=turned,
        seconds=SECONDS,
        bodies=bodies,
        curves=(Curve(f"rotation of {turn.gears.mate.name}", "deg", np.abs(angles[1] - angles[1][0])),),
        events=[Event("the dwell begins", float(np.degrees(last - first)))],
    )
