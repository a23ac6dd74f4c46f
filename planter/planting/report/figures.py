"""Figures of a planting device's motion, and all its figures by name.

Each takes data in display units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.planting.report.forces import draw_support_force
from planter.report import style
from planter.report.style import render_svg, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.planting.toothed import Gearing

Columns = Mapping[str, "Array"]

ARROWS = 6
"""Arrows along a path."""
POSES = 12
"""Carrier angles at which the nozzle is drawn."""
# The machine file does not say how wide the nozzle is: half widths at shares of its length, to look
# like one.
_OUTLINE = ((-0.10, 0.055), (0.12, 0.085), (0.45, 0.062), (1.0, 0.0))


@style.with_style
def draw_tip_path(
    turn: Columns,
    before: Columns | None = None,
    soil_mm: float | None = None,
    points: Sequence[Sequence[float]] = (),
) -> Figure:
    """Path of the tip of side 1 relative to the machine, with the nozzle at 12 carrier angles;
    arrows run with it.

    `before` is a turn of the design that an optimisation started from, drawn pale; `soil_mm` the
    level of the soil, `points` are those that the tip must pass (x, y) with the radii of their
    tubes [mm].

    `turn` holds columns of a whole turn under the names of `simulate` (`phi_deg`, `theta1_deg`,
    `x_A1_mm`, `x_B1_mm`, `tip_x_mm` and their y, `tip_machine_x_mm`). If the machine travels,
    second axes show the path over ground.
    """
    tip = np.array([turn["tip_machine_x_mm"], turn["tip_y_mm"]])
    travels = bool(np.abs(turn["tip_x_mm"] - tip[0]).max() > 1e-6)
    figure = style.new_figure(6.6 if not travels else 9.2)
    ratios = [2, 1] if travels else [1]
    axes, *ground = figure.subplots(len(ratios), 1, height_ratios=ratios, squeeze=False)[:, 0]
    if before is not None:
        old = _closed(np.array([before["tip_machine_x_mm"], before["tip_y_mm"]]))
        axes.plot(
            *old, color=style.ORANGE, linewidth=1.0, alpha=0.7, label="tip, before", zorder=1.5
        )
    if soil_mm is not None:
        axes.axhline(
            soil_mm, color=style.GREEN, linewidth=0.8, linestyle=(0, (6, 2)), label="soil", zorder=1
        )
    style.draw_tubes(axes, points)
    _poses(axes, turn, tip)
    style.drawing_board(axes)
    if travels:
        axes.set_title("relative to the machine")
        _path(ground[0], np.array([turn["tip_x_mm"], turn["tip_y_mm"]]), turn["theta1_deg"])
        style.drawing_board(ground[0])
        ground[0].set_title("over the ground")
    return figure


def _path(axes: Axes, tip: Array, swing: Array) -> None:
    """The path, drawn stronger where the nozzle is open."""
    x, y = tip
    axes.plot(x, y, color=style.BLUE, linewidth=1.4, label="tip, closed")
    opened = np.where(swing > 1e-9, 1.0, np.nan)
    axes.plot(x * opened, y * opened, color=style.VERMILION, linewidth=2.0, label="tip, open")
    for i in np.linspace(0, len(x), ARROWS, endpoint=False).astype(int) + len(x) // (2 * ARROWS):
        shade = style.VERMILION if swing[i] > 1e-9 else style.BLUE
        axes.annotate(
            "",
            (x[i + 1], y[i + 1]),
            (x[i], y[i]),
            arrowprops={
                "arrowstyle": "-|>",
                "color": shade,
                "mutation_scale": 11,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )


def _poses(axes: Axes, turn: Columns, tip: Array) -> None:
    a1, b1 = (np.array([turn[f"x_{point}_mm"], turn[f"y_{point}_mm"]]) for point in ("A1", "B1"))
    axes.plot(*_closed(b1), color=style.SOFT, linestyle=(0, (4, 3)), linewidth=0.7, label="B1")
    middle = tip.mean(axis=1)
    for angle in range(0, 360, 360 // POSES):
        i = int(np.argmin(np.abs(turn["phi_deg"] - angle)))
        carrier = np.array([np.zeros(2), a1[:, i], b1[:, i]]).T
        axes.plot(
            *carrier,
            color=style.FAINT,
            linewidth=0.7,
            marker="o",
            markersize=1.8,
            label="carrier, O\N{EN DASH}A1\N{EN DASH}B1" if angle == 0 else None,
        )
        is_open = turn["theta1_deg"][i] > 1e-9
        _nozzle(axes, b1[:, i], tip[:, i], style.VERMILION if is_open else style.SOFT)
        _name_pose(axes, tip[:, i], middle, angle)
    _path(axes, _closed(tip), _closed(turn["theta1_deg"]))
    axes.plot(0, 0, "o", color=style.INK, markersize=3.5)
    axes.annotate("O", (0, 0), (5, 4), textcoords="offset points")
    axes.legend(loc="upper right", frameon=False)


def _closed(turn: Array) -> Array:
    """The samples (..., n) of a turn with the first one again at the end."""
    return np.concatenate([turn, turn[..., :1]], axis=-1)


def _nozzle(axes: Axes, root: Array, tip: Array, shade: str) -> None:
    axis = tip - root
    across = np.array([-axis[1], axis[0]])
    left = [root + share * axis + width * across for share, width in _OUTLINE]
    right = [root + share * axis - width * across for share, width in reversed(_OUTLINE[:-1])]
    outline = np.array(left + right)
    axes.fill(*outline.T, facecolor=shade, alpha=0.07, edgecolor="none")
    axes.fill(*outline.T, fill=False, edgecolor=shade, linewidth=0.7, alpha=0.8, gid="nozzle")


def _name_pose(axes: Axes, tip: Array, middle: Array, angle: int) -> None:
    away = tip - middle
    offset = 13 * away / np.hypot(*away)
    axes.annotate(
        f"{angle}°",
        (float(tip[0]), float(tip[1])),
        (float(offset[0]), float(offset[1])),
        textcoords="offset points",
        ha="center",
        va="center",
        bbox=style.CLEAR,
    )


CENTRE_LINE = (0, (8, 2, 1, 2))
BEFORE = (0, (4, 2))


@style.with_style
def draw_pitch_curves(gearing: Gearing, before: Gearing | None = None) -> Figure:
    """Both gear pairs of side 1 in mesh, with centres and pitch points; side 2, half a turn round,
    faintly.

    `before` is the gearing of the design that an optimisation started from, drawn pale and dashed
    beneath.
    """
    figure = style.new_figure(5.9)
    overview, detail = figure.subplots(1, 2, width_ratios=[1, 1.35])
    for curve in gearing.curves[1:]:
        overview.plot(*-curve.points, color=style.FAINT, linewidth=0.7, gid="side 2")
    overview.plot(*-_centres(gearing), color=style.FAINT, linewidth=0.6, linestyle=CENTRE_LINE)
    for axes in (overview, detail):
        for curve in before.curves if before is not None else ():
            axes.plot(
                *curve.points,
                color=style.ORANGE,
                linewidth=0.8,
                linestyle=BEFORE,
                alpha=0.8,
                gid="before",
            )
        _curves(axes, gearing)
        style.drawing_board(axes)
    _name_curves(detail, gearing)
    _name_points(detail, gearing)
    overview.set_title(f"carrier angle φ = {gearing.phi_deg:g}°, grey: side 2")
    detail.set_title("side 1" if before is None else "side 1, dashed: before the optimisation")
    return figure


def _centres(gearing: Gearing) -> Array:
    return np.array(list(gearing.centres.values())).T


def _curves(axes: Axes, gearing: Gearing) -> None:
    for index, curve in enumerate(gearing.curves):
        shade = style.PALETTE[index]
        axes.fill(*curve.points, facecolor=shade, alpha=0.06, edgecolor="none")
        axes.plot(*curve.points, color=shade, label=curve.name)
    axes.plot(*_centres(gearing), color=style.INK, linewidth=0.7, linestyle=CENTRE_LINE, zorder=3)
    axes.plot(*_centres(gearing), "+", color=style.INK, markersize=7, zorder=4)


def _name_points(axes: Axes, gearing: Gearing) -> None:
    for point in gearing.contacts.values():
        axes.plot(*point, "o", color=style.PAPER, markeredgecolor=style.INK, markersize=4, zorder=4)
    for name, point in (gearing.centres | gearing.contacts).items():
        x, y = map(float, point)
        axes.annotate(
            name, (x, y), (8, 0), textcoords="offset points", va="center", bbox=style.CLEAR
        )


def _name_curves(axes: Axes, gearing: Gearing) -> None:
    """Write the name of each curve next to its point that is farthest from the other curves and
    from other names.
    """
    labelled_points: list[Array] = []
    for index, curve in enumerate(gearing.curves):
        other_points = np.hstack([c.points for i, c in enumerate(gearing.curves) if i != index])
        point = _loneliest(curve.points, other_points, labelled_points)
        labelled_points.append(point)
        away = point - curve.centre
        offset = 9 * away / np.hypot(*away)
        axes.annotate(
            curve.name,
            (float(point[0]), float(point[1])),
            (float(offset[0]), float(offset[1])),
            textcoords="offset points",
            color=style.PALETTE[index],
            ha="left" if away[0] > 0 else "right",
            va="center",
        )


def _loneliest(points: Array, other_points: Array, labelled_points: list[Array]) -> Array:
    gaps = np.hypot(*(points[:, :, None] - other_points[:, None, :])).min(axis=1)
    for name in labelled_points:
        gaps[np.hypot(*(points - name[:, None])) < np.ptp(points[0]) / 2] = 0
    loneliest: Array = points[:, int(np.argmax(gaps))]
    return loneliest


__all__ = [
    "DRAWN",
    "draw_pitch_curves",
    "draw_support_force",
    "draw_tip_path",
    "render_svg",
    "save_figure",
]

_TIP = ("tip_x_mm", "tip_y_mm", "tip_machine_x_mm", "theta1_deg")
_PLACES = ("x_A1_mm", "y_A1_mm", "x_B1_mm", "y_B1_mm")
DRAWN = {
    "support_force": ("phi_deg", "support_N"),
    "tip_path": ("phi_deg", *_TIP, *_PLACES),
}
"""Columns of a turn that each figure draws."""
