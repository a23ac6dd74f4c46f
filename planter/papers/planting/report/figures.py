"""Figures of a planting device's motion, and of a search.

Each takes data in display units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

    from planter.kernels import Array
    from planter.papers.planting.toothed import Gearing

POLISH = "polish"
"""Name of the local searches from the best individuals of the genetic algorithm."""
NARROW = 0.1
"""Share of the designs' extent below which the Pareto front is also drawn enlarged."""
STEEP = 30.0
"""Ratio of worst to best objective above which the scale is logarithmic."""


@style.with_style
def draw_convergence(history: Mapping[str, Sequence[tuple[int, float]]]) -> Figure:
    """Draw the best objective so far against the number of evaluations, as a step curve for each
    search.

    `history` has (evaluations, best objective) pairs by label; labels that agree up to a comma
    (`ipopt, start 3`) belong to one method, share a colour and are named once. Evaluations are
    counted from the start of the method.
    """
    figure = style.new_figure(3.6)
    axes = figure.subplots()
    history = {label: steps for label, steps in history.items() if steps}
    methods = list(dict.fromkeys(label.partition(",")[0] for label in history))
    ends: dict[str, tuple[float, str, str]] = {}
    for label, steps in history.items():
        method = label.partition(",")[0]
        shade = style.PALETTE[methods.index(method) % len(style.PALETTE)]
        count, best = np.array(steps, dtype=float).T
        single = "," not in label
        axes.step(
            count, best, where="post", color=shade, linewidth=1.4 if single else 0.8, label=label
        )
        axes.plot(count[-1], best[-1], "o", color=shade, markersize=3 if single else 2)
        if method not in ends or best[-1] < ends[method][0]:
            ends[method] = (float(best[-1]), _end(method, history, float(best[-1])), shade)
    if history:
        _scales(axes, history)
    axes.set_xlabel("evaluations of the objective")
    axes.set_ylabel("best objective")
    style.label_ends(axes, list(ends.values()), gap=0.17)
    return figure


def _end(method: str, history: Mapping[str, object], best: float) -> str:
    runs = sum(label.partition(",")[0] == method for label in history)
    notes = [f"{runs} starts"] if runs > 1 else []
    notes += ["from the best of ga"] if method == POLISH else []
    return f"{method}\n" + "".join(f"{note}\n" for note in notes) + f"{best:.6g}"


def _scales(axes: Axes, history: Mapping[str, Sequence[tuple[int, float]]]) -> None:
    counts = [count for steps in history.values() for count, _ in steps]
    values = [best for steps in history.values() for _, best in steps]
    if max(counts) > STEEP * max(1, min(counts)):
        axes.set_xscale("log" if min(counts) > 0 else "symlog")
    if min(values) > 0 and max(values) > STEEP * min(values):
        axes.set_yscale("log")


@style.with_style
def draw_pareto(
    points: Array,
    marks: Mapping[str, tuple[float, float]],
    weights: tuple[float, float] | None = None,
) -> Figure:
    """Draw range against variance of the support force: designs (n, 2) [N, N2], their Pareto front,
    and named designs.

    `weights` are those of the objective; the line of equal objective through the best mark is drawn
    for them.
    """
    dominated = ~find_nondominated(points)
    front = np.unique(points[~dominated], axis=0)
    extent = np.ptp(np.vstack([points, *marks.values()]), axis=0)
    narrow = len(front) > 1 and bool((np.ptp(front, axis=0) < NARROW * extent).any())
    figure = style.new_figure(4.2)
    axes, *enlarged = figure.subplots(1, 1 + narrow, squeeze=False)[0]
    if dominated.any():
        axes.plot(*points[dominated].T, "o", color=style.FAINT, markersize=2.5, label="designs")
    _front(axes, front, marks)
    handles, labels = axes.get_legend_handles_labels()
    if enlarged:
        middle = front.mean(axis=0)
        axes.plot(
            *middle, "s", color=style.BLUE, markersize=13, fillstyle="none", markeredgewidth=0.8
        )
        axes.annotate(
            "front", tuple(middle), (11, -8), textcoords="offset points", color=style.BLUE
        )
    for detail in enlarged:
        _front(detail, front, marks, is_detail=True)
        detail.set_title("the front, enlarged")
        axes.set_title("all designs")
    if weights and marks:
        best = min(marks.values(), key=lambda mark: np.dot(weights, mark))
        levels = [_level(each, best, weights) for each in (axes, *enlarged)]
        handles, labels = [*handles, levels[0]], [*labels, str(levels[0].get_label())]
    axes.set_ylabel("variance of the support force / N²")
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _front(
    axes: Axes, front: Array, marks: Mapping[str, tuple[float, float]], is_detail: bool = False
) -> None:
    axes.plot(*front.T, "o-", color=style.BLUE, markersize=3.2, linewidth=0.9, label="front")
    for index, (label, (x, y)) in enumerate(marks.items(), 1):
        if is_detail and not _close(np.array((x, y)), front):
            continue
        shade = style.PALETTE[index % len(style.PALETTE)]
        axes.plot(
            x, y, "D", color=shade, markeredgecolor=style.PAPER, markersize=6, label=label, zorder=4
        )
    axes.margins(0.08)
    axes.locator_params(nbins=6)
    axes.set_xlabel("range of the support force / N")


def _close(mark: Array, front: Array) -> bool:
    """Return whether a mark lies within twice the extent of the front around its middle."""
    low, high = front.min(axis=0), front.max(axis=0)
    return bool((np.abs(mark - (low + high) / 2) <= 2 * (high - low)).all())


def _level(axes: Axes, mark: tuple[float, float], weights: tuple[float, float]) -> Line2D:
    """Draw and return the line through the mark on which the weighted sum is constant."""
    limits = axes.get_xlim(), axes.get_ylim()
    slope = -weights[0] / weights[1]
    label = f"{weights[0]:g} range + {weights[1]:g} variance = {np.dot(weights, mark):.6g}"
    level = axes.axline(
        mark, slope=slope, color=style.SOFT, linewidth=0.7, linestyle=(0, (4, 3)), label=label
    )
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    return level


def find_nondominated(points: Array) -> NDArray[np.bool_]:
    """Return which of the points (n, 2) are not dominated by another point, (n,) of bool; both
    values are minimised.
    """
    dominated = [bool(((points <= p).all(axis=1) & (points < p).any(axis=1)).any()) for p in points]
    return ~np.array(dominated, dtype=bool)


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
