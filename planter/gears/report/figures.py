"""Figures of toothed pairs: teeth in mesh, contact ratio and margins round the gears."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.gearing.teeth.contacts import Contacts
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.incomplete.gear import IncompleteGear
from planter.gearing.teeth.making import Toothed
from planter.gearing.teeth.polygons import points
from planter.gears.parts import AnyGear, Placed
from planter.gears.report.friction import friction
from planter.gears.rubbing import Rubbing
from planter.kernels import Array
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1e3
_WINDOW = 2.2
"""Half the width of the look at the mesh, in pitches."""
_SIDES = ((-1, "begin a tooth"), (1, "end a tooth"))


@style.drawn
def assembly(gears: Sequence[Placed]) -> Figure:
    """All gears in their places, with the lines of their centres."""
    figure = style.new_figure(5.4)
    axes = figure.subplots()
    for index, placed in enumerate(gears):
        _gear(axes, placed.gear, placed.angle, placed.centre, style.PALETTE[index % len(style.PALETTE)])
    for pair in zip(gears[::2], gears[1::2], strict=True):
        axes.plot(*(_MM * np.array([placed.centre for placed in pair]).T), "-+", color=style.INK, lw=0.6, markersize=7)
    axes.legend(loc="upper left", frameon=False)
    style.drawing_board(axes)
    return figure


@style.drawn
def meshing(found: Toothed) -> Figure:
    """The teeth about the pitch point at four positions over a turn of the gear, with the flanks' contacts."""
    figure = style.new_figure(6.4)
    mesh, period = found.mesh, found.mesh.period
    for axes, quarter in zip(figure.subplots(2, 2).flat, range(4), strict=True):
        at = np.array([quarter * period * mesh.pitch / 4])
        own, mate = mesh.places(at)
        _gear(axes, mesh.gear, own[0, 0], (0.0, 0.0), style.BLUE)
        _gear(axes, mesh.mate, mate[0, 0], (mate[1, 0], mate[2, 0]), style.VERMILION)
        axes.plot(*(_MM * Contacts(mesh, mesh.facing(at)).points), ".", color=style.INK, markersize=4)
        radius = _MM * float(np.hypot(*mesh.gear.curve.at(mesh.pair.sense * at)[:2])[0])
        wide = _MM * _WINDOW * mesh.pitch
        axes.plot(radius, 0, "o", color=style.PAPER, markeredgecolor=style.INK, markersize=4)
        axes.set_aspect("equal")
        axes.set_xlim(radius - 0.7 * wide, radius + 0.7 * wide)
        axes.set_ylim(-wide, wide)
        axes.set_title(f"{quarter}/4 of a period")
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure


@style.drawn
def round_the_gear(found: Toothed) -> Figure:
    """Contact ratio of each pair of teeth, and of each gear's teeth the margin against undercut and the top land."""
    figure = style.new_figure(5.6)
    above, middle, below = figure.subplots(3, 1)
    mesh = found.mesh
    for side, told in _SIDES:
        which = mesh.pairs.side == side
        degrees = _turned(mesh.gear, mesh.pair.sense * mesh.pairs.at[which])
        order = np.argsort(degrees)
        label = f"flanks that {told}"
        above.plot(degrees[order], mesh.contact_ratios[which][order], ".-", label=label, linewidth=0.8)
    above.set_ylabel("contact ratio")
    above.legend(frameon=False, ncols=2)
    for index, gear in enumerate(found.gears):
        teeth = np.arange(gear.z)
        shade = style.PALETTE[index]
        for (side, told), mark in zip(_SIDES, (":", "-"), strict=True):
            margins = gear.flanks.margins[gear.flanks.side == side]
            middle.plot(teeth, margins, mark, color=shade, label=f"{gear.name}, {told}")
        below.plot(teeth, gear.top_lands / gear.rack.module, color=shade, label=gear.name)
    middle.axhline(0, color=style.INK, linewidth=0.6)
    middle.set_ylabel("margin against\nundercut")
    below.set_ylabel("top land / module")
    above.set_xlabel(f"polar angle of {mesh.gear.name} / deg")
    below.set_xlabel("tooth")
    middle.legend(frameon=False, ncols=2, fontsize=7)
    below.legend(frameon=False, ncols=2)
    return figure


@style.drawn
def play(found: Toothed) -> Figure:
    """Over a period: lost motion to either side and of both, gap of the polygons, errors of transmission."""
    figure = style.new_figure(4.6)
    above, middle, below = figure.subplots(3, 1, sharex=True)
    mesh = found.mesh
    share = mesh.positions / (mesh.period * mesh.pitch)
    lost = np.degrees(found.lost_motion)
    for values, label in ((lost[:, 1], "anticlockwise"), (lost[:, 0], "clockwise"), (lost.sum(axis=1), "both")):
        above.plot(share, values, label=label)
    above.set_ylim(bottom=0)
    above.set_ylabel("lost motion / deg")
    above.legend(frameon=False, ncols=3)
    middle.plot(share, 1e6 * found.polygon_gaps, color=style.GREEN)
    middle.set_ylabel("least gap of\npolygons / um")
    below.plot(found.contacts.faced.at / (mesh.period * mesh.pitch), found.contacts.errors, ".", markersize=2)
    below.set_ylabel("transmission\nerror / rad")
    below.set_xlabel("share of a period")
    return figure


def figures(found: Sequence[Toothed], gears: Sequence[Placed], rubbing: Rubbing | None = None) -> dict[str, Figure]:
    """All figures by the names of their files."""
    drawn = {"assembly": assembly(gears)}
    for number, one in enumerate(found, 1):
        drawn |= {
            f"stage{number}_mesh": meshing(one),
            f"stage{number}_teeth": round_the_gear(one),
            f"stage{number}_play": play(one),
        }
    return drawn | ({"friction": friction(rubbing)} if rubbing else {})


def _gear(axes: Axes, gear: AnyGear, angle: float, centre: tuple[float, float], shade: str) -> None:
    outline, pitch = (
        _MM * (_rotated(line, angle) + np.asarray(centre))
        for line in (_vertices(gear), gear.outline().pitch(np.linspace(0, 1, 361)))
    )
    axes.fill(*outline.T, facecolor=shade, alpha=0.12, edgecolor="none")
    axes.plot(*np.vstack([outline, outline[:1]]).T, color=shade, linewidth=0.8, label=gear.name)
    axes.plot(*pitch.T, color=shade, linewidth=0.5, linestyle=(0, (6, 3)))


def _vertices(gear: AnyGear) -> Array:
    return gear.points if isinstance(gear, IncompleteGear) else points(gear)


def _rotated(line: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(line @ np.array([[c, s], [-s, c]]))


def _turned(gear: Gear, s: Array) -> Array:
    return np.asarray(np.mod(np.degrees(gear.curve.at(s)[5]), 360))
