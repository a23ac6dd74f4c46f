"""Figures of toothed pairs: teeth in mesh, contact ratio and margins round the gears."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.gear_geometry.contacts import Contacts
from planter.gear_geometry.cutting import ToothedPair
from planter.gear_geometry.gear import Gear
from planter.gear_geometry.intermittent_gears import IncompleteGear
from planter.gear_geometry.polygons import build_polygon
from planter.gears.friction import FrictionCurves
from planter.gears.parts import AnyGear, PlacedGear
from planter.kernels import Array
from planter.report import style
from planter.view.scene import Body, Curve, Outline, Scene, refine_places, simplify_outline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1e3
_WINDOW = 2.2
"""Half the width of the view of the mesh, in pitches."""
_SIDES = ((-1, "begin a tooth"), (1, "end a tooth"))


@style.drawn
def plot_assembly(gears: Sequence[PlacedGear]) -> Figure:
    """Plot all gears in their mounting positions, with the lines of their centres."""
    figure = style.new_figure(5.4)
    axes = figure.subplots()
    for index, placed in enumerate(gears):
        _draw_gear(axes, placed.gear, placed.angle, placed.centre, style.PALETTE[index % len(style.PALETTE)])
    for pair in zip(gears[::2], gears[1::2], strict=True):
        axes.plot(*(_MM * np.array([placed.centre for placed in pair]).T), "-+", color=style.INK, lw=0.6, markersize=7)
    axes.legend(loc="upper left", frameon=False)
    style.drawing_board(axes)
    return figure


@style.drawn
def plot_mesh(pair: ToothedPair) -> Figure:
    """Plot the teeth about the pitch point at four positions over a period, with the contacts of the flanks."""
    figure = style.new_figure(6.4)
    mesh, period = pair.mesh, pair.mesh.period
    for axes, quarter in zip(figure.subplots(2, 2).flat, range(4), strict=True):
        contact_arc = np.array([quarter * period * mesh.pitch / 4])
        gear, mate = mesh.places(contact_arc)
        _draw_gear(axes, mesh.gear, gear[0, 0], (0.0, 0.0), style.BLUE)
        _draw_gear(axes, mesh.mate, mate[0, 0], (mate[1, 0], mate[2, 0]), style.VERMILION)
        axes.plot(*(_MM * Contacts(mesh, mesh.facing(contact_arc)).points), ".", color=style.INK, markersize=4)
        radius = _MM * float(np.hypot(*mesh.gear.curve.at(mesh.pair.sense * contact_arc)[:2])[0])
        width = _MM * _WINDOW * mesh.pitch
        axes.plot(radius, 0, "o", color=style.PAPER, markeredgecolor=style.INK, markersize=4)
        axes.set_aspect("equal")
        axes.set_xlim(radius - 0.7 * width, radius + 0.7 * width)
        axes.set_ylim(-width, width)
        axes.set_title(f"{quarter}/4 of a period")
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure


@style.drawn
def plot_teeth(pair: ToothedPair) -> Figure:
    """Plot the contact ratio of each tooth pair, and the undercut margin and top land of each tooth."""
    figure = style.new_figure(5.6)
    above, middle, below = figure.subplots(3, 1)
    mesh = pair.mesh
    for side, label in _SIDES:
        on_side = mesh.pairs.side == side
        degrees = _polar_angles(mesh.gear, mesh.pair.sense * mesh.pairs.at[on_side])
        order = np.argsort(degrees)
        label = f"flanks that {label}"
        above.plot(degrees[order], mesh.contact_ratios[on_side][order], ".-", label=label, linewidth=0.8)
    above.set_ylabel("contact ratio")
    above.legend(frameon=False, ncols=2)
    for index, gear in enumerate(pair.gears):
        teeth = np.arange(gear.z)
        shade = style.PALETTE[index]
        for (side, label), mark in zip(_SIDES, (":", "-"), strict=True):
            margins = gear.flanks.margins[gear.flanks.side == side]
            middle.plot(teeth, margins, mark, color=shade, label=f"{gear.name}, {label}")
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
def plot_play(pair: ToothedPair) -> Figure:
    """Plot lost motion to either side and of both, polygon gap and transmission error over a period."""
    figure = style.new_figure(4.6)
    above, middle, below = figure.subplots(3, 1, sharex=True)
    mesh = pair.mesh
    share = mesh.positions / (mesh.period * mesh.pitch)
    lost = np.degrees(pair.lost_motion)
    for values, label in ((lost[:, 1], "anticlockwise"), (lost[:, 0], "clockwise"), (lost.sum(axis=1), "both")):
        above.plot(share, values, label=label)
    above.set_ylim(bottom=0)
    above.set_ylabel("lost motion / deg")
    above.legend(frameon=False, ncols=3)
    middle.plot(share, 1e6 * pair.polygon_gaps, color=style.GREEN)
    middle.set_ylabel("least gap of\npolygons / um")
    below.plot(pair.contacts.faced.at / (mesh.period * mesh.pitch), pair.contacts.errors, ".", markersize=2)
    below.set_ylabel("transmission\nerror / rad")
    below.set_xlabel("share of a period")
    return figure


def build_figures(
    pairs: Sequence[ToothedPair], gears: Sequence[PlacedGear], rubbing: FrictionCurves | None = None
) -> dict[str, Figure]:
    """Return all figures by the names of their files."""
    plots = {"assembly": plot_assembly(gears)}
    for number, pair in enumerate(pairs, 1):
        plots |= {
            f"stage{number}_mesh": plot_mesh(pair),
            f"stage{number}_teeth": plot_teeth(pair),
            f"stage{number}_play": plot_play(pair),
        }
    return plots | ({"friction": plot_friction(rubbing)} if rubbing else {})


def _draw_gear(axes: Axes, gear: AnyGear, angle: float, centre: tuple[float, float], shade: str) -> None:
    outline, pitch = (
        _MM * (_rotate(line, angle) + np.asarray(centre))
        for line in (_find_vertices(gear), gear.outline().pitch(np.linspace(0, 1, 361)))
    )
    axes.fill(*outline.T, facecolor=shade, alpha=0.12, edgecolor="none")
    axes.plot(*np.vstack([outline, outline[:1]]).T, color=shade, linewidth=0.8, label=gear.name)
    axes.plot(*pitch.T, color=shade, linewidth=0.5, linestyle=(0, (6, 3)))


def _find_vertices(gear: AnyGear) -> Array:
    return gear.points if isinstance(gear, IncompleteGear) else build_polygon(gear)


def _rotate(line: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(line @ np.array([[c, s], [-s, c]]))


def _polar_angles(gear: Gear, s: Array) -> Array:
    return np.asarray(np.mod(np.degrees(gear.curve.at(s)[5]), 360))


_COLUMNS = 2
_HEIGHT = 1.6
"""Height of a row of axes [inch]."""
_SHADES = {"convention": style.VERMILION, "sliding": style.BLUE}


@style.drawn
def plot_friction(curves: FrictionCurves) -> Figure:
    """Plot the change of each quantity by friction, by the convention and against the sliding."""
    count = -(-len(curves.curves) // _COLUMNS)
    figure = style.new_figure(_HEIGHT * count)
    all_axes = list(figure.subplots(count, _COLUMNS, squeeze=False).flat)
    for spare in all_axes[len(curves.curves) :]:
        spare.set_visible(False)
    for axes, (key, kinds) in zip(all_axes, curves.curves.items(), strict=False):
        for kind, shade in _SHADES.items():
            axes.plot(curves.phi_deg, kinds[kind] - kinds["without"], color=shade, label=kind, linewidth=0.8)
        unit = units.suffix(key)
        axes.set_title(f"{key.removesuffix(unit)} / {units.unit(key)}")
        style.over_a_turn(axes, label=False)
    figure.legend(*all_axes[0].get_legend_handles_labels(), loc="outside upper right", frameon=False, ncols=2)
    figure.supxlabel("carrier angle φ / deg", fontsize=8.5)
    figure.supylabel("change by friction of the teeth", fontsize=8.5)
    return figure


MOMENTS = 240
SECONDS = 12.0
"""Duration of a turn in the animation; the mesh does not depend on speed."""
OUTLINE_TOLERANCE = 0.01
"""Largest deviation of the drawn outline from the teeth, in modules."""
_MM = 1e3


def build_scene(pair: ToothedPair) -> Scene:
    """Return the scene of a period of the mesh over the rotation of the gear."""
    mesh = pair.mesh

    def turned_at(at: Array) -> list[Array]:
        """Angles of both gears [deg], (n,) each."""
        return [np.degrees(np.unwrap(place[0])) for place in mesh.places(at)]

    end = mesh.period * mesh.pitch
    at = refine_places(turned_at, np.linspace(0, end, MOMENTS + 1))[:-1]
    angles = turned_at(at)
    axes = [(0.0, 0.0), (_MM * mesh.pair.distance, 0.0)]
    bodies = [
        Body(gear.name, (build_outline(build_polygon(gear), gear.rack.module, shade),), axis, angle)
        for shade, (gear, axis, angle) in enumerate(zip(mesh.gears, axes, angles, strict=True))
    ]
    turned = np.abs(angles[0] - angles[0][0])
    return Scene(
        title=f"{mesh.gear.name} and {mesh.mate.name}",
        place=f"rotation of {mesh.gear.name}",
        unit="deg",
        places=turned,
        seconds=SECONDS,
        bodies=bodies,
        curves=(Curve(f"rotation of {mesh.mate.name}", "deg", np.abs(angles[1] - angles[1][0])),),
        shares=at / end,
    )


def build_outline(vertices: Array, module: float, shade: int) -> Outline:
    """Return a gear's outline (n, 2) [m], simplified to `OUTLINE_TOLERANCE` modules."""
    return Outline(_MM * simplify_outline(vertices, OUTLINE_TOLERANCE * module), "gear", shade=shade)
