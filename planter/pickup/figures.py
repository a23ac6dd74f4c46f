"""Figures of the seedling pick-up: path with tray, pitch curves with locking arcs, contact ratio,
motion, law.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.numerics.arrays import TURN
from planter.pickup.gears import Locking, compute_locking_arcs
from planter.pickup.requirements import find_push
from planter.pickup.spline import PathSpline
from planter.pickup.tray import Cell, CellEntry
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.pickup.file import Pickup
    from planter.pickup.model import PickupTrain

DENSE = 1441
ADDENDA = (1.0, 1.1, 1.2, 1.3)
"""Addendum coefficients of the first part of Fig. 9 [-]."""
MODULES_MM = (1.5, 2.0, 2.5, 3.0)
"""Modules of its second part."""
_DASHED = (0, (4, 3))


@style.with_style
def draw_path(machine: Pickup, train: PickupTrain, before: Array | None = None) -> Figure:
    """Path of the tip with value points, linkage, tray and needle; `before` (n, 2) [m] is a path to
    compare with.

    Beside it the pick in the frame of the cell, with needles on their way in and out.
    """
    figure = style.new_figure(4.4)
    overview, detail = figure.subplots(1, 2, width_ratios=[1.7, 1])
    _whole_path(overview, machine, train, before)
    _pick(detail, machine, train)
    return figure


def _whole_path(axes: Axes, machine: Pickup, train: PickupTrain, before: Array | None) -> None:
    entry = CellEntry(train, Cell.from_pickup(machine))
    t = np.linspace(0, TURN, DENSE)
    tip = train.tip(t) * 1000
    if before is not None:
        spline = PathSpline(before * 1000)
        axes.plot(
            *spline(np.linspace(0, spline.length, DENSE)).T,
            color=style.FAINT,
            linewidth=1.0,
            label="before",
        )
    axes.plot(*tip.T, color=style.BLUE, label="tip")
    style.draw_tubes(axes, machine.tip_path.points_mm if machine.tip_path else ())
    locked = train.is_locked(t)
    if locked.any():
        axes.plot(
            *np.where(locked[:, None], tip, np.nan).T,
            color=style.VERMILION,
            linewidth=2.2,
            label="in the dwell",
        )
    steps = np.arange(machine.spline.value_points) * TURN / machine.spline.value_points
    points = (
        train.tip(steps) if machine.points is None or before is not None else machine.points
    ) * 1000
    if len(points) <= 60:
        axes.plot(
            *points.T,
            "o",
            color=style.PAPER,
            markeredgecolor=style.BLUE,
            markersize=3,
            label="value points",
        )
    for part in _parts(entry.cell):
        axes.fill(
            *(entry.to_frame(part / 1000) * 1000).T,
            facecolor=style.FAINT,
            alpha=0.5,
            edgecolor=style.SOFT,
        )
    where = find_push(train)[0]
    for angle, name in ((0.0, "pick"), (where, "push")):
        corners = entry.to_frame(entry.needle(angle)) * 1000
        axes.fill(*corners.T, facecolor=style.GREEN, alpha=0.35, edgecolor=style.GREEN)
        needle_axis = corners[2:].mean(axis=0) - corners[:2].mean(axis=0)
        across = 15 * np.array([-needle_axis[1], needle_axis[0]]) / np.hypot(*needle_axis)
        axes.annotate(
            name,
            _xy(corners.mean(axis=0)),
            _xy(across * np.sign(across[1] or 1)),
            textcoords="offset points",
            ha="center",
            va="center",
            color=style.GREEN,
        )
    _linkage(axes, train, where)
    _level(axes, machine, entry)
    style.drawing_board(axes)
    axes.set_aspect("equal", adjustable="box")
    axes.legend(loc="upper left", frameon=False)


def _xy(point: Array) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _linkage(axes: Axes, train: PickupTrain, t: float) -> None:
    points = {
        name: float(value[0]) * 1000
        for name, value in train.motion(np.array([t])).items()
        if name[0] in "xy"
    }
    chain = np.array([[0, 0], *([points[f"x_{p}"], points[f"y_{p}"]] for p in ("M1", "O1", "S"))])
    axes.plot(*chain.T, color=style.INK, linewidth=0.8, marker="o", markersize=2.5, zorder=3)
    for name, point in zip(("O", "M1", "O1"), chain, strict=False):
        axes.annotate(
            name,
            (float(point[0]), float(point[1])),
            (-3, -11),
            textcoords="offset points",
            ha="center",
        )


def _level(axes: Axes, machine: Pickup, entry: CellEntry) -> None:
    """The horizontal that the tray box's inclination implies: the axis of a cell points down by the
    pick angle.
    """
    down = entry.axis() + np.radians(90 - machine.tray.box_inclination_deg)
    line = np.array([[-45, 0], [45, 0]]) @ np.array(
        [[np.cos(down), np.sin(down)], [-np.sin(down), np.cos(down)]]
    )
    place = np.array([axes.get_xlim()[1] - 30, axes.get_ylim()[0] + 45])
    axes.plot(*(line + place).T, color=style.SOFT, linewidth=0.8, linestyle=_DASHED)
    axes.annotate("level", _xy(place), (4, 6), textcoords="offset points", color=style.SOFT)


def _parts(cell: Cell) -> list[Array]:
    """Outlines of what the tray fills [mm], in the frame of the cell."""
    walls = cell.walls()
    return [np.asarray(part.exterior.coords) for part in getattr(walls, "geoms", [walls])]


def _pick(axes: Axes, machine: Pickup, train: PickupTrain) -> None:
    entry = CellEntry(train, Cell.from_pickup(machine))
    for part in _parts(entry.cell):
        axes.fill(part[:, 1], -part[:, 0], facecolor=style.FAINT, alpha=0.5, edgecolor=style.SOFT)
    for degrees in (-60, -45, -30, -15, 0, 15, 30, 45, 60):
        corners = entry.needle(float(np.radians(degrees))) * 1000
        shade = style.GREEN if degrees == 0 else style.SKY if degrees < 0 else style.ORANGE
        axes.fill(
            corners[:, 1],
            -corners[:, 0],
            facecolor=shade,
            alpha=0.12,
            edgecolor=shade,
            linewidth=0.7,
        )
    t = np.radians(np.linspace(-85, 85, DENSE))
    place = entry.place(t) * 1000
    for sign, shade, name in ((-1, style.SKY, "in"), (1, style.ORANGE, "out")):
        side = place[sign * t >= 0]
        axes.plot(side[:, 1], -side[:, 0], color=shade, label=f"tip on its way {name}")
    axes.set_xlim(-40, 40)
    axes.set_ylim(-50, 90)
    axes.set_aspect("equal")
    axes.set_xlabel("across the cell / mm")
    axes.set_ylabel("above the tray / mm")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, ncols=2)


@style.with_style
def draw_pitch_curves(train: PickupTrain) -> Figure:
    """Pitch curves in mesh where the tip is farthest, with the locking arcs in the dwell; and both
    while they lock.
    """
    figure = style.new_figure(4.2)
    parts = figure.subplots(1, 2)
    arcs, dwell = compute_locking_arcs(train), train.law.dwell
    moments = [(0.0, "tip farthest, t = 0°")]
    if dwell is not None:
        middle = (dwell.start + dwell.end) / 2
        moments.append((middle, f"in the dwell, t = {np.degrees(middle):.4g}°"))
    for axes, (t, title) in zip(parts, moments, strict=False):
        _gears(axes, train, t, arcs)
        axes.set_title(title)
    for axes in parts[len(moments) :]:
        axes.set_axis_off()
    figure.legend(
        *parts[0].get_legend_handles_labels(), loc="outside lower center", frameon=False, ncols=2
    )
    return figure


def _gears(axes: Axes, train: PickupTrain, t: float, arcs: Locking | None) -> None:
    """Both gears in the carrier's frame, x along the centre line from the sun's centre."""
    curves = train.pitch(train.samples(DENSE))
    sun = _turned(np.array([curves["x1"], curves["y1"]]) * 1000, -t)
    turned = float(train.law.arm(np.array([t]))[0]) - np.pi
    middle = _turned(np.array([curves["x2"], curves["y2"]]) * 1000, np.pi + turned)
    middle[0] += train.geometry.a1 * 1000
    for curve, shade, name in (
        (sun, style.BLUE, "sun"),
        (middle, style.VERMILION, "intermediate gear"),
    ):
        axes.plot(*curve, color=shade, label=f"{name}, toothed")
    if arcs is not None and train.law.dwell is not None:
        convex, concave = locking_arcs(train, arcs)
        axes.plot(
            *_turned(convex * 1000, -t),
            color=style.BLUE,
            linewidth=2.6,
            alpha=0.5,
            label="convex locking arc",
        )
        arc = _turned(concave * 1000, np.pi + turned)
        arc[0] += train.geometry.a1 * 1000
        axes.plot(
            *arc, color=style.VERMILION, linewidth=2.6, alpha=0.5, label="concave locking arc"
        )
    axes.plot(
        [0, train.geometry.a1 * 1000], [0, 0], "+-", color=style.INK, linewidth=0.6, markersize=7
    )
    style.drawing_board(axes)


def locking_arcs(train: PickupTrain, arcs: Locking) -> tuple[Array, Array]:
    """Convex arc in the sun's frame and concave one in the intermediate gear's, each (2, n) [m].

    In the dwell both lie on one circle about the sun's centre; the concave one reaches to its
    gear's tips.
    """
    dwell = train.law.dwell
    assert dwell is not None
    convex, concave = (
        np.linspace(dwell.start, dwell.end, 181),
        np.linspace(-arcs.reaches[0], arcs.reaches[1], 121),
    )
    seen = arcs.radius * np.array([np.cos(concave), np.sin(concave)]) - np.array(
        [[train.geometry.a1], [0.0]]
    )
    arm_angle = float(train.law.arm(np.array([dwell.start]))[0])
    return arcs.radius * np.array([np.cos(convex), np.sin(convex)]), _turned(seen, -arm_angle)


def _turned(points: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * points[0] - s * points[1], s * points[0] + c * points[1]])


@style.with_style
def draw_contact_ratio(train: PickupTrain) -> Figure:
    """Contact ratio of the non-circular pair along the turn, for several addenda and for several
    modules (Fig. 9).
    """
    figure = style.new_figure(4.6)
    upper, lower = figure.subplots(2, 1, sharex=True)
    t = train.samples(DENSE)
    for axes, title, series in (
        (
            upper,
            f"module {train.teeth[0] * 1000:g} mm, by addendum coefficient",
            [(f"{ha:g}", train.contact_ratio(t, addendum=ha)) for ha in ADDENDA],
        ),
        (
            lower,
            f"addendum coefficient {train.teeth[1]:g}, by module / mm",
            [(f"{m:g}", train.contact_ratio(t, module=m / 1000)) for m in MODULES_MM],
        ),
    ):
        ends = []
        for index, (label, values) in enumerate(series):
            axes.plot(*_over_turn(train, t, values), color=style.PALETTE[index], label=label)
            finite = np.flatnonzero(np.isfinite(values))
            if len(finite):
                end = finite[np.argmin(np.abs(t[finite]))]
                ends.append((float(values[end]), label, style.PALETTE[index]))
        axes.autoscale_view()
        style.label_ends(axes, ends, gap=0.08)
        axes.set_title(title)
        axes.set_ylabel("contact ratio")
        _over_t(axes, train, label=axes is lower)
    return figure


def _over_turn(train: PickupTrain, t: Array, values: Array) -> tuple[Array, Array]:
    """A curve over the teeth, cut where the turn begins and left out in the dwell."""
    wrap_angle = np.degrees(t % TURN)
    order = np.argsort(wrap_angle, kind="stable")
    x, y = wrap_angle[order], values[order].astype(float)
    if train.law.dwell is not None:
        gap = int(np.searchsorted(x, np.degrees(train.law.dwell.start) + 1e-9))
        x, y = np.insert(x, gap, x[gap - 1]), np.insert(y, gap, np.nan)
    return x, y


def _over_t(axes: Axes, train: PickupTrain, label: bool = True) -> None:
    style.over_a_turn(axes, label=False)
    if train.law.dwell is not None:
        axes.axvspan(
            *np.degrees([train.law.dwell.start, train.law.dwell.end]),
            color=style.FAINT,
            alpha=0.25,
            lw=0,
        )
    if label:
        axes.set_xlabel("carrier angle t from the farthest tip / deg")


@style.with_style
def draw_motion(train: PickupTrain) -> Figure:
    """Displacement and speed of the tip along x and y over a turn (Fig. 13)."""
    figure = style.new_figure(4.6)
    upper, lower = figure.subplots(2, 1, sharex=True)
    t = np.linspace(0, TURN, DENSE)
    state = train.motion(t)
    for axes, names, unit in (
        (upper, ("x_S", "y_S"), "displacement / mm"),
        (lower, ("vx_S", "vy_S"), "speed / (mm/s)"),
    ):
        ends = []
        for index, name in enumerate(names):
            values = state[name] * 1000
            axes.plot(np.degrees(t), values, color=style.PALETTE[index])
            ends.append((float(values[-1]), "xy"[index], style.PALETTE[index]))
        axes.autoscale_view()
        style.label_ends(axes, ends, gap=0.08)
        axes.set_ylabel(unit)
        _over_t(axes, train, label=axes is lower)
    upper.set_title(f"needle's tip at {np.degrees(train.omega):g}°/s of the carrier; grey: dwell")
    return figure


@style.with_style
def draw_law(train: PickupTrain, before: PickupTrain | None = None) -> Figure:
    """Angle of the arm, its slope over the carrier's angle, and the total ratio where teeth have
    one.
    """
    figure = style.new_figure(5.6)
    parts = figure.subplots(3, 1, sharex=True)
    for variant, shade, name in (
        (before, style.FAINT, "before"),
        (train, style.BLUE, "after" if before else None),
    ):
        if variant is None:
            continue
        t, turn, driven = (
            variant.samples(DENSE),
            np.linspace(0, TURN, DENSE),
            np.linspace(*variant.driven, DENSE),
        )
        parts[0].plot(
            np.degrees(turn), np.degrees(variant.law.arm(turn) - turn), color=shade, label=name
        )
        parts[1].plot(*_over_turn(variant, driven, variant.law.slopes(driven)[0]), color=shade)
        parts[2].plot(*_over_turn(variant, t, 1 / variant.law.slopes(t)[0]), color=shade)
    parts[0].set_ylabel("φ₁ \N{MINUS SIGN} t / deg")
    parts[1].set_ylabel("dφ₁/dφ₅")
    parts[2].set_ylabel("total ratio")
    parts[1].axhline(1, color=style.SOFT, linewidth=0.6, linestyle=_DASHED)
    for axes in parts:
        _over_t(axes, train, label=axes is parts[2])
    if before is not None:
        parts[0].legend(frameon=False)
    return figure
