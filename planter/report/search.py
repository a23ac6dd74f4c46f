"""Figures of an optimisation: convergence of the search, and the Pareto front."""

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

POLISH = "polish"
"""Name of the local searches from the best individuals of the genetic algorithm."""
NARROW = 0.1
"""Share of the designs' extent below which the Pareto front is also drawn enlarged."""
STEEP = 30.0
"""Ratio of worst to best objective above which the scale is logarithmic."""


@style.with_style
def draw_convergence(history: Mapping[str, Sequence[tuple[int, float]]], unit: str = "") -> Figure:
    """Draw the best objective so far against the number of evaluations, as a step curve for each search.

    `history` has (evaluations, best objective) pairs by label; labels that agree up to a comma (`ipopt, start 3`)
    belong to one method, share a colour and are named once. Evaluations are counted from the start of the method.
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
        axes.step(count, best, where="post", color=shade, linewidth=1.4 if single else 0.8, label=label)
        axes.plot(count[-1], best[-1], "o", color=shade, markersize=3 if single else 2)
        if method not in ends or best[-1] < ends[method][0]:
            ends[method] = (float(best[-1]), _end(method, history, float(best[-1])), shade)
    if history:
        _scales(axes, history)
    axes.set_xlabel("evaluations of the objective")
    axes.set_ylabel("best objective" + (f" / {unit}" if unit else ""))
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
    """Draw range against variance of the support force: designs (n, 2) [N, N2], their Pareto front, and named designs.

    `weights` are those of the objective; the line of equal objective through the best mark is drawn for them.
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
        axes.plot(*middle, "s", color=style.BLUE, markersize=13, fillstyle="none", markeredgewidth=0.8)
        axes.annotate("front", tuple(middle), (11, -8), textcoords="offset points", color=style.BLUE)
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


def _front(axes: Axes, front: Array, marks: Mapping[str, tuple[float, float]], is_detail: bool = False) -> None:
    axes.plot(*front.T, "o-", color=style.BLUE, markersize=3.2, linewidth=0.9, label="front")
    for index, (label, (x, y)) in enumerate(marks.items(), 1):
        if is_detail and not _close(np.array((x, y)), front):
            continue
        shade = style.PALETTE[index % len(style.PALETTE)]
        axes.plot(x, y, "D", color=shade, markeredgecolor=style.PAPER, markersize=6, label=label, zorder=4)
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
    level = axes.axline(mark, slope=slope, color=style.SOFT, linewidth=0.7, linestyle=(0, (4, 3)), label=label)
    axes.set_xlim(limits[0])
    axes.set_ylim(limits[1])
    return level


def find_nondominated(points: Array) -> NDArray[np.bool_]:
    """Return which of the points (n, 2) are not dominated by another point, (n,) of bool; both values are minimised."""
    dominated = [bool(((points <= p).all(axis=1) & (points < p).any(axis=1)).any()) for p in points]
    return ~np.array(dominated, dtype=bool)
