"""Figures of an intermittent pair, and its animated scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.gear_geometry.intermittent_proof import FREE_ANGLE, SIDES, IncompleteGearCycle
from planter.gears.parts import PlacedGear
from planter.gears.report.figures import MOMENTS, SECONDS, build_outline, plot_assembly
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.report import style
from planter.view.scene import Body, Curve, Event, Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MM = 1e3
_SIDES = ("flanks that drive", "flanks that hold back")
_HIGH = 5.0
"""Largest loose motion in the figure [deg]; larger values are clipped."""


def build_figures(turn: IncompleteGearCycle, gears: Sequence[PlacedGear]) -> dict[str, Figure]:
    """Return all figures by the names of their files."""
    return {
        "assembly": plot_assembly(gears),
        "dwell": plot_dwell(turn),
        "loose": plot_loose(turn),
        "lands": plot_lands(turn),
    }


@style.drawn
def plot_dwell(turn: IncompleteGearCycle) -> Figure:
    """Plot both gears about the line of centres at the beginning, middle and end of the dwell."""
    figure = style.new_figure(4.2)
    gears, rolling = turn.gears, turn.gears.rolling
    positions = {
        "the dwell begins": rolling.places(np.array([rolling.length])),
        "the middle of the dwell": rolling.dwell_positions(np.array([0.5])),
        "the dwell ends": rolling.places(np.zeros(1)),
    }
    for axes, (title, places) in zip(figure.subplots(1, 3, sharey=True), positions.items(), strict=True):
        for gear, place, shade in zip(gears.gears, places, (style.BLUE, style.VERMILION), strict=True):
            outline = np.vstack([gear.points, gear.points[:1]])
            line = outline @ np.array([1, 1j]) * np.exp(1j * place[0]) + place[1]
            axes.fill(_MM * line.real, _MM * line.imag, facecolor=shade, alpha=0.12, edgecolor="none")
            axes.plot(_MM * line.real, _MM * line.imag, color=shade, linewidth=0.8, label=gear.name)
        axes.set_aspect("equal")
        axes.set_xlim(_MM * gears.radius - 12, _MM * gears.radius + 12)
        axes.set_ylim(-_MM * gears.radius, _MM * gears.radius)
        axes.set_title(title)
    figure.axes[0].legend(loc="upper left", frameon=False)
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure


@style.drawn
def plot_loose(turn: IncompleteGearCycle) -> Figure:
    """Plot the number of flanks in contact and the loose motion of the driven gear over a turn."""
    figure = style.new_figure(4.6)
    above, below = figure.subplots(2, 1, sharex=True)
    rolling, motion = turn.gears.rolling, turn.loose
    angles = np.degrees(-rolling.places(turn.rolled)[0][0])
    for side, label, shade, width in zip(SIDES, _SIDES, (style.BLUE, style.ORANGE), (2.2, 0.9), strict=True):
        above.step(angles, turn.mesh.touching(turn.rolled, side).sum(axis=1), where="mid", label=label, color=shade,
                   linewidth=width)  # fmt: skip
    above.set_ylabel("flanks in contact")
    above.set_yticks(range(4))
    above.set_ylim(-0.2, 3.6)
    above.legend(loc="upper left", frameon=False, ncols=2)
    for values, label, shade in ((-motion.behind, "behind its law", style.BLUE), (motion.ahead, "ahead", style.ORANGE)):
        stopped = np.abs(values) < FREE_ANGLE
        below.plot(np.degrees(motion.at), np.degrees(np.where(stopped, values, np.nan)), ".-", label=label, color=shade,
                   linewidth=0.8, markersize=3)  # fmt: skip
        below.plot(np.degrees(motion.at[~stopped]), np.full((~stopped).sum(), 0.88 * _HIGH), "^", color=shade,
                   label="not limited" if not stopped.all() else None)  # fmt: skip
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
def plot_lands(turn: IncompleteGearCycle) -> Figure:
    """Plot the undercut margin of both flanks and the top land of each tooth as the rack cuts it."""
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


def build_scene(turn: IncompleteGearCycle) -> Scene:
    """Return the scene of a turn of the driving gear that starts at the end of the dwell."""
    rolling = turn.gears.rolling
    first, last = rolling.over
    moments = first + np.arange(MOMENTS) * TURN / MOMENTS
    on_teeth = moments <= last
    mate: Array = np.hstack(
        [
            rolling.places(rolling.rolled(moments[on_teeth]))[1],
            rolling.dwell_positions((moments[~on_teeth] - last) / rolling.dwell)[1],
        ]
    )
    angles = -np.degrees(moments), np.degrees(np.unwrap(mate[0]))
    axes = (0.0, 0.0), (_MM * rolling.pair.distance, 0.0)
    bodies = [
        Body(gear.name, (build_outline(gear.points, gear.rack.module, shade),), axis, angle)
        for shade, (gear, axis, angle) in enumerate(zip(turn.gears.gears, axes, angles, strict=True))
    ]
    turned = np.degrees(moments - first)
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
