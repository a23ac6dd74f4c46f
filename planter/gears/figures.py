"""Figures and animated scenes of toothed pairs."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.cutting import ToothedPair
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.intermittent_gears import IncompleteGear
from planter.gears.geometry.intermittent_proof import FREE_ANGLE, IncompleteGearCycle
from planter.gears.geometry.mesh import SIDES
from planter.gears.geometry.polygons import build_polygon
from planter.gears.parts import PlacedGear
from planter.gears.results import FrictionCurves
from planter.kernels import Array
from planter.numerics.arrays import TURN, rotation_matrix
from planter.report import style
from planter.report.labels import clean_zero
from planter.report.scene import Body, Curve, Event, Outline, Scene, refine_places, simplify_outline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1e3
_WINDOW = 2.2
"""Half the width of the view of the mesh, in pitches."""
_SIDES = ((-1, "begin a tooth"), (1, "end a tooth"))


@style.with_style
def plot_assembly(gears: Sequence[PlacedGear]) -> Figure:
    """Plot all gears in their mounting positions, with the lines of their centres."""
    figure = style.new_figure(5.4)
    axes = figure.subplots()
    for index, placed in enumerate(gears):
        _draw_gear(
            axes,
            placed.gear,
            placed.angle,
            placed.centre,
            style.PALETTE[index % len(style.PALETTE)],
        )
    for pair in zip(gears[::2], gears[1::2], strict=True):
        axes.plot(
            *(_MM * np.array([placed.centre for placed in pair]).T),
            "-+",
            color=style.INK,
            lw=0.6,
            markersize=7,
        )
    axes.legend(loc="upper left", frameon=False)
    style.drawing_board(axes)
    return figure


@style.with_style
def plot_mesh(pair: ToothedPair) -> Figure:
    """Plot the teeth about the pitch point at four positions over a period, with the contacts of
    the flanks.
    """
    figure = style.new_figure(6.4)
    mesh, period = pair.mesh, pair.mesh.period
    for axes, quarter in zip(figure.subplots(2, 2).flat, range(4), strict=True):
        contact_arc = np.array([quarter * period * mesh.pitch / 4])
        _draw_pair(axes, mesh.gears, mesh.places(contact_arc))
        axes.plot(
            *(_MM * Contacts(mesh, mesh.facing(contact_arc)).points),
            ".",
            color=style.INK,
            markersize=4,
        )
        radius = _MM * float(np.hypot(*mesh.gear.curve.at(mesh.pair.sense * contact_arc)[:2])[0])
        width = _MM * _WINDOW * mesh.pitch
        axes.plot(radius, 0, "o", color=style.PAPER, markeredgecolor=style.INK, markersize=4)
        axes.set_xlim(radius - 0.7 * width, radius + 0.7 * width)
        axes.set_ylim(-width, width)
        axes.set_title(f"{quarter}/4 of a period")
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure


@style.with_style
def plot_teeth(pair: ToothedPair) -> Figure:
    """Plot the contact ratio of each tooth pair, and the undercut margin and top land of each
    tooth.
    """
    figure = style.new_figure(5.6)
    above, middle, below = figure.subplots(3, 1)
    mesh = pair.mesh
    for side, label in _SIDES:
        on_side = mesh.pairs.side == side
        degrees = _polar_angles(mesh.gear, mesh.pair.sense * mesh.pairs.at[on_side])
        order = np.argsort(degrees)
        label = f"flanks that {label}"
        above.plot(
            degrees[order], mesh.contact_ratios[on_side][order], ".-", label=label, linewidth=0.8
        )
    above.set_ylabel("contact ratio")
    above.margins(y=0.2)
    above.legend(frameon=False, ncols=2, loc="upper left")
    above.set_xlabel(f"polar angle of {mesh.gear.name} / deg")
    _plot_lands(middle, below, pair.gears)
    return figure


def _plot_lands(above: Axes, below: Axes, gears: Sequence[Gear]) -> None:
    """Plot margins against undercut and top lands by the number of the tooth."""
    for index, gear in enumerate(gears):
        teeth = np.arange(gear.z)
        shade = style.PALETTE[index]
        for (side, label), mark in zip(_SIDES, (":", "-"), strict=True):
            margins = gear.flanks.margins[gear.flanks.side == side]
            above.plot(teeth, margins, mark, color=shade, label=f"{gear.name}, {label}")
        below.plot(teeth, gear.top_lands / gear.rack.module, color=shade, label=gear.name)
    above.axhline(0, color=style.INK, linewidth=0.6)
    above.set_ylabel("margin against\nundercut")
    below.set_ylabel("top land / module")
    below.set_xlabel("tooth")
    above.legend(frameon=False, ncols=2, fontsize=7)
    below.legend(frameon=False, ncols=2)


@style.with_style
def plot_play(pair: ToothedPair) -> Figure:
    """Plot lost motion to either side and of both, polygon gap and transmission error over a
    period.

    What is zero everywhere is named instead of drawn.
    """
    mesh = pair.mesh
    share = mesh.positions / (mesh.period * mesh.pitch)
    lost, errors = clean_zero(np.degrees(pair.lost_motion)), clean_zero(pair.contacts.errors)
    panels = {
        "lost motion": bool(lost.any()),
        "gap": True,
        "transmission error": bool(errors.any()),
    }
    names = [name for name, is_drawn in panels.items() if is_drawn]
    figure = style.new_figure(0.4 + 1.4 * len(names))
    rows = dict(
        zip(names, figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0], strict=True)
    )
    if axes := rows.get("lost motion"):
        for values, label in (
            (lost[:, 1], "anticlockwise"),
            (lost[:, 0], "clockwise"),
            (lost.sum(axis=1), "both"),
        ):
            axes.plot(share, values, label=label)
        axes.set_ylim(bottom=0)
        axes.set_ylabel("lost motion / deg")
        axes.legend(frameon=False, ncols=3)
    rows["gap"].plot(share, 1e6 * pair.polygon_gaps, color=style.GREEN)
    rows["gap"].set_ylabel("least gap of\npolygons / um")
    if axes := rows.get("transmission error"):
        axes.plot(pair.contacts.faced.at / (mesh.period * mesh.pitch), errors, ".", markersize=2)
        axes.set_ylabel("transmission\nerror / rad")
    if absent := [f"no {name}" for name, is_drawn in panels.items() if not is_drawn]:
        rows[names[0]].set_title(f"{' and '.join(absent)} at any position")
    rows[names[-1]].set_xlabel("share of a period")
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


def _draw_pair(axes: Axes, gears: Sequence[Gear], places: Sequence[Array]) -> None:
    """Draw both gears at positions (3, 1): angle [rad] and axis [m]."""
    for gear, place, shade in zip(gears, places, (style.BLUE, style.VERMILION), strict=True):
        angle, x, y = place[:, 0]
        _draw_gear(axes, gear, angle, (x, y), shade)
    axes.set_aspect("equal")


def _draw_gear(
    axes: Axes, gear: Gear, angle: float, centre: tuple[float, float], shade: str
) -> None:
    outline, pitch = (
        _MM * (line @ rotation_matrix(-angle) + np.asarray(centre))
        for line in (_find_vertices(gear), gear.pitch_line.at(np.linspace(0, 1, 361)))
    )
    axes.fill(*outline.T, facecolor=shade, alpha=0.12, edgecolor="none")
    axes.plot(*np.vstack([outline, outline[:1]]).T, color=shade, linewidth=0.8, label=gear.name)
    axes.plot(*pitch.T, color=shade, linewidth=0.5, linestyle=(0, (6, 3)))


def _find_vertices(gear: Gear) -> Array:
    return gear.points if isinstance(gear, IncompleteGear) else build_polygon(gear)


def _polar_angles(gear: Gear, s: Array) -> Array:
    return np.mod(np.degrees(gear.curve.at(s)[5]), 360)


_COLUMNS = 2
TITLE_WIDTH = 45
"""Characters of a line of a panel's title."""
_HEIGHT = 1.7
"""Height of a row of axes [inch]."""
_SHADES = {"convention": style.VERMILION, "sliding": style.BLUE}


@style.with_style
def plot_friction(curves: FrictionCurves) -> Figure:
    """Plot the change of each quantity by friction, by the convention and against the sliding."""
    count = -(-len(curves.curves) // _COLUMNS)
    figure = style.new_figure(_HEIGHT * count)
    all_axes = list(figure.subplots(count, _COLUMNS, squeeze=False).flat)
    for spare in all_axes[len(curves.curves) :]:
        spare.set_visible(False)
    for axes, (key, kinds) in zip(all_axes, curves.curves.items(), strict=False):
        for kind, shade in _SHADES.items():
            axes.plot(
                curves.phi_deg,
                kinds[kind] - kinds["without"],
                color=shade,
                label=kind,
                linewidth=0.8,
            )
        unit = units.unit_suffix(key)
        name = textwrap.fill(curves.names.get(key, key.removesuffix(unit)), TITLE_WIDTH)
        axes.set_title(units.typeset_label(f"{name} / {units.display_unit(key)}"))
        style.over_a_turn(axes, label=False)
    figure.legend(
        *all_axes[0].get_legend_handles_labels(), loc="outside upper right", frameon=False, ncols=2
    )
    figure.supxlabel("carrier angle φ / deg", fontsize=8.5)
    figure.supylabel("change by friction of the teeth", fontsize=8.5)
    return figure


MOMENTS = 240
SECONDS = 12.0
"""Duration of a turn in the animation; the mesh does not depend on speed."""
OUTLINE_TOLERANCE = 0.01
"""Largest deviation of the drawn outline from the teeth, in modules."""


def build_scene(pair: ToothedPair) -> Scene:
    """Return the scene of a period of the mesh over the rotation of the gear."""
    mesh = pair.mesh

    def turned_at(at: Array) -> list[Array]:
        """Angles of both gears [deg], (n,) each."""
        return [np.degrees(np.unwrap(place[0])) for place in mesh.places(at)]

    end = mesh.period * mesh.pitch
    at = refine_places(turned_at, np.linspace(0, end, MOMENTS + 1))[:-1]
    angles = turned_at(at)
    place = f"rotation of {mesh.gear.name}"
    scene = _build_scene(mesh.gears, mesh.pair.distance, angles, place)
    return replace(scene, places=np.abs(angles[0] - angles[0][0]), shares=at / end)


def _build_scene(
    gears: Sequence[Gear], distance: float, angles: Sequence[Array], place: str
) -> Scene:
    """Return the scene of two gears at angles (n,) [deg], their axes at a distance [m]."""
    bodies = []
    for shade, gear in enumerate(gears):
        outline = build_outline(_find_vertices(gear), gear.rack.module, shade)
        bodies.append(Body(gear.name, (outline,), (_MM * distance * shade, 0.0), angles[shade]))
    turned = np.abs(angles[1] - angles[1][0])
    return Scene(
        title=" and ".join(gear.name for gear in gears),
        place=place,
        unit="deg",
        places=turned,
        seconds=SECONDS,
        bodies=bodies,
        curves=(Curve(f"rotation of {gears[1].name}", "deg", turned),),
    )


def build_outline(vertices: Array, module: float, shade: int) -> Outline:
    """Return a gear's outline (n, 2) [m], simplified to `OUTLINE_TOLERANCE` modules."""
    return Outline(
        _MM * simplify_outline(vertices, OUTLINE_TOLERANCE * module), "gear", shade=shade
    )


_DRIVE_SIDES = ("flanks that drive", "flanks that hold back")
_HIGH = 5.0
"""Largest loose motion in the figure [deg]; larger values are clipped."""


def build_dwell_figures(
    turn: IncompleteGearCycle, gears: Sequence[PlacedGear]
) -> dict[str, Figure]:
    """Return all figures by the names of their files."""
    return {
        "assembly": plot_assembly(gears),
        "dwell": plot_dwell(turn),
        "loose": plot_loose(turn),
        "lands": plot_lands(turn),
    }


@style.with_style
def plot_dwell(turn: IncompleteGearCycle) -> Figure:
    """Plot both gears about the line of centres at the beginning, middle and end of the dwell."""
    figure = style.new_figure(4.2)
    gears, rolling = turn.gears, turn.gears.rolling
    positions = {
        "the dwell begins": rolling.places(np.array([rolling.length])),
        "the middle of the dwell": rolling.dwell_positions(np.array([0.5])),
        "the dwell ends": rolling.places(np.zeros(1)),
    }
    for axes, (title, places) in zip(
        figure.subplots(1, 3, sharey=True), positions.items(), strict=True
    ):
        _draw_pair(axes, gears.gears, places)
        axes.set_xlim(_MM * gears.radius - 12, _MM * gears.radius + 12)
        axes.set_ylim(-_MM * gears.radius, _MM * gears.radius)
        axes.set_title(title)
    figure.axes[0].legend(loc="upper left", frameon=False)
    figure.supxlabel("along the line of centres / mm", fontsize=8.5)
    return figure


@style.with_style
def plot_loose(turn: IncompleteGearCycle) -> Figure:
    """Plot the number of flanks in contact and the loose motion of the driven gear over a turn."""
    figure = style.new_figure(4.6)
    above, below = figure.subplots(2, 1, sharex=True)
    rolling, motion = turn.gears.rolling, turn.loose
    angles = np.degrees(-rolling.places(turn.rolled)[0][0])
    for side, label, shade, width in zip(
        SIDES, _DRIVE_SIDES, (style.BLUE, style.ORANGE), (2.2, 0.9), strict=True
    ):
        above.step(
            angles,
            turn.mesh.touching(turn.rolled, side).sum(axis=1),
            where="mid",
            label=label,
            color=shade,
            linewidth=width,
        )
    above.set_ylabel("flanks in contact")
    above.set_yticks(range(4))
    above.set_ylim(-0.2, 3.6)
    above.legend(loc="upper left", frameon=False, ncols=2)
    for values, label, shade in (
        (-motion.behind, "behind its law", style.BLUE),
        (motion.ahead, "ahead", style.ORANGE),
    ):
        stopped = np.abs(values) < FREE_ANGLE
        below.plot(
            np.degrees(motion.at),
            np.degrees(np.where(stopped, values, np.nan)),
            ".-",
            label=label,
            color=shade,
            linewidth=0.8,
            markersize=3,
        )
        below.plot(
            np.degrees(motion.at[~stopped]),
            np.full((~stopped).sum(), 0.88 * _HIGH),
            "^",
            color=shade,
            label="not limited" if not stopped.all() else None,
        )
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


@style.with_style
def plot_lands(turn: IncompleteGearCycle) -> Figure:
    """Plot the undercut margin of both flanks and the top land of each tooth as the rack cuts
    it.
    """
    figure = style.new_figure(4.2)
    above, below = figure.subplots(2, 1)
    _plot_lands(above, below, turn.gears.gears)
    below.set_ylim(0, 1)
    return figure


def build_dwell_scene(turn: IncompleteGearCycle) -> Scene:
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
    place = f"rotation of {turn.gears.gear.name} from the end of the dwell"
    scene = _build_scene(turn.gears.gears, rolling.pair.distance, angles, place)
    events = [Event("the dwell begins", float(np.degrees(last - first)))]
    return replace(scene, places=np.degrees(moments - first), events=events)
