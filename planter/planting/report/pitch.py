"""Figure of the four pitch curves in mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.planting.report.gearing import Gearing

CENTRE_LINE = (0, (8, 2, 1, 2))
BEFORE = (0, (4, 2))


@style.drawn
def pitch_curves(gearing: Gearing, before: Gearing | None = None) -> Figure:
    """Both gear pairs of side 1 in mesh, with centres and pitch points; side 2, half a turn round, faintly.

    `before` is the gearing of the design that an optimisation started from, drawn pale and dashed beneath.
    """
    figure = style.new_figure(5.9)
    whole, near = figure.subplots(1, 2, width_ratios=[1, 1.35])
    for curve in gearing.curves[1:]:
        whole.plot(*-curve.points, color=style.FAINT, linewidth=0.7, gid="side 2")
    whole.plot(*-_centres(gearing), color=style.FAINT, linewidth=0.6, linestyle=CENTRE_LINE)
    for axes in (whole, near):
        for curve in before.curves if before is not None else ():
            axes.plot(*curve.points, color=style.ORANGE, linewidth=0.8, linestyle=BEFORE, alpha=0.8, gid="before")
        _curves(axes, gearing)
        style.drawing_board(axes)
    _name_curves(near, gearing)
    _name_points(near, gearing)
    whole.set_title(f"carrier angle φ = {gearing.phi_deg:g}°, grey: side 2")
    near.set_title("side 1" if before is None else "side 1, dashed: before the optimisation")
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
        axes.annotate(name, (x, y), (8, 0), textcoords="offset points", va="center", bbox=style.CLEAR)


def _name_curves(axes: Axes, gearing: Gearing) -> None:
    """Names each curve beside the point of it that is farthest from the other curves and from other names."""
    named: list[Array] = []
    for index, curve in enumerate(gearing.curves):
        others = np.hstack([c.points for i, c in enumerate(gearing.curves) if i != index])
        point = _loneliest(curve.points, others, named)
        named.append(point)
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


def _loneliest(points: Array, others: Array, named: list[Array]) -> Array:
    gaps = np.hypot(*(points[:, :, None] - others[:, None, :])).min(axis=1)
    for name in named:
        gaps[np.hypot(*(points - name[:, None])) < np.ptp(points[0]) / 2] = 0
    lonely: Array = points[:, int(np.argmax(gaps))]
    return lonely
