"""Figures of a field test: effects of the factors, response surfaces, clutches compared."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.field.analysis import Effects
from planter.clutch.field.comparison import Sample
from planter.clutch.field.evaluation import FieldEvaluation
from planter.clutch.field.trial import Factor, FieldResponse, Trial
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

MOST_FACTORS = 6
"""Factors that a figure of effects has room for."""
SURFACE_FACTORS = 3
"""Factors whose pairs have a response surface each."""
COLOURS = "viridis"
WITHOUT_SCALE = 0.94
"""Share of a figure's width that the surfaces have, beside the scale of their colours."""
GRID = 31
"""Points along each side of a response surface."""


@style.drawn
def draw_effects(evaluation: FieldEvaluation, order: Sequence[Factor]) -> Figure:
    """Draw predicted means at the levels of the first factors of an order, over the runs; circles mark best levels."""
    trial, chosen = evaluation.trial, order[:MOST_FACTORS]
    figure = style.new_figure(0.4 + 1.9 * len(trial.responses))
    grid = figure.subplots(len(trial.responses), len(chosen), sharey="row", squeeze=False)
    for row, response in zip(grid, trial.responses, strict=True):
        best = (evaluation.result.best or {}).get(response.name)
        for axes, factor in zip(row, chosen, strict=True):
            index = trial.factors.index(factor)
            estimate = evaluation.effects[response.name]
            _effect(axes, factor, response, estimate.mean + estimate.levels[index], best and best[index])
        row[0].set_ylabel(_with_goal(evaluation, response, "\n"))
    for axes, factor in zip(grid[-1], chosen, strict=True):
        axes.set_xlabel(_plain(factor.label))
    return figure


def _with_goal(evaluation: FieldEvaluation, response: FieldResponse, interpolate_effect: str) -> str:
    """Return the meaning of a response and its goal."""
    goal = evaluation.goals.get(response.name)
    return _plain(response.label) + (f"{interpolate_effect}goal: {goal}" if goal else "")


def _effect(axes: Axes, factor: Factor, response: FieldResponse, means: Array, best: Any) -> None:
    places = np.arange(len(factor.levels))
    axes.plot(factor.codes, response.values, "o", color=style.FAINT, markersize=3, label="runs")
    axes.plot(places, means, "o-", color=style.BLUE, markersize=4.5, label="effect")
    if best is not None:
        place = factor.levels.index(best)
        axes.plot(place, means[place], "o", color=style.GREEN, markersize=9, markerfacecolor="none", label="best")
    axes.axhline(float(response.values.mean()), color=style.SOFT, linewidth=0.6, linestyle=(0, (4, 3)))
    axes.set_xticks(places, _ticks(factor))
    axes.set_xlim(-0.4, len(places) - 0.6)


def _ticks(factor: Factor) -> list[str]:
    if factor.scale:
        return [f"{value:g}" for value in factor.scale]
    return [_plain(str(level)) for level in factor.levels]


def _plain(text: str) -> str:
    """Return a user's text with dollars escaped, which would set it as mathematics."""
    return text.replace("$", r"\$")


@style.drawn
def draw_response_surface(evaluation: FieldEvaluation, response: FieldResponse, order: Sequence[Factor]) -> Figure:
    """Draw a response over each pair of the first factors with numeric levels, the others at a middle level."""
    chosen = _drawable(order)
    pairs = list(itertools.combinations(chosen, 2))
    figure = style.new_figure(2.5)
    figure.set_layout_engine("none")
    width = WITHOUT_SCALE / max(len(pairs), 2)
    heights = [_height(evaluation.trial, evaluation.effects[response.name], pair) for pair in pairs]
    low, high = min(h.min() for *_, h in heights), max(h.max() for *_, h in heights)
    for index, (pair, (x, y, height)) in enumerate(zip(pairs, heights, strict=True)):
        axes = figure.add_axes((width * (index + 0.04), 0.06, width * 0.96, 0.98), projection="3d")
        _draw_surface(axes, x, y, height, (low, high))
        _name_sides(axes, pair)
    _colour_scale(figure, (low, high))
    figure.text(0.01, 0.93, _with_goal(evaluation, response, ";  "), fontsize=8.5)
    return figure


def _colour_scale(figure: Figure, limits: tuple[float, float]) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    bar = figure.colorbar(ScalarMappable(Normalize(*limits), COLOURS), figure.add_axes((0.945, 0.2, 0.012, 0.6)))
    bar.ax.tick_params(labelsize=6.5)
    bar.outline.set_visible(False)


def has_surface(order: Sequence[Factor]) -> bool:
    """Return whether a surface can be drawn over two factors."""
    return len(_drawable(order)) > 1


def _drawable(order: Sequence[Factor]) -> list[Factor]:
    return [factor for factor in order if factor.scale][:SURFACE_FACTORS]


def _draw_surface(axes: Any, x: Array, y: Array, height: Array, limits: tuple[float, float]) -> None:
    floor = limits[0] - 0.35 * (limits[1] - limits[0])
    colours = {"cmap": COLOURS, "vmin": limits[0], "vmax": limits[1]}
    axes.plot_surface(x, y, height, rcount=GRID, ccount=GRID, linewidth=0, antialiased=False, **colours)
    axes.contour(x, y, height, levels=8, zdir="z", offset=floor, linewidths=0.8, **colours)
    axes.set_zlim(floor, limits[1])
    axes.view_init(elev=24, azim=-128)
    axes.tick_params(labelsize=6.5, pad=-3)
    axes.locator_params(nbins=5)
    axes.set_box_aspect((1, 1, 0.85))
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.set_visible(False)


def _name_sides(axes: Any, pair: tuple[Factor, Factor]) -> None:
    for factor, name, ticks in zip(
        pair, (axes.set_xlabel, axes.set_ylabel), (axes.set_xticks, axes.set_yticks), strict=True
    ):
        name(_plain(factor.label), labelpad=-6, fontsize=7.5)
        if factor.scale and len(factor.levels) <= 5:
            ticks(factor.scale, _ticks(factor))


def _height(trial: Trial, estimate: Effects, pair: tuple[Factor, Factor]) -> tuple[Array, Array, Array]:
    """Return a grid of two factors' values, and the additive prediction over it."""
    levels = dict(zip((factor.name for factor in trial.factors), estimate.levels, strict=True))
    rest = sum(
        level[(len(level) - 1) // 2] for name, level in levels.items() if name not in (pair[0].name, pair[1].name)
    )
    axes_points, curves = [], []
    for factor in pair:
        knots = np.array(factor.scale)
        points = np.linspace(knots.min(), knots.max(), GRID)
        axes_points.append(points)
        curves.append(interpolate_effect(knots, levels[factor.name], points))
    x, y = np.meshgrid(*axes_points, indexing="ij")
    return x, y, estimate.mean + rest + curves[0][:, None] + curves[1][None, :]


def interpolate_effect(knots: Array, values: Array, points: Array) -> Array:
    """Return a factor's effect between its levels: line or parabola for two or three, else a monotone cubic.

    >>> interpolate_effect(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 4.0]), np.array([0.5])).round(12).tolist()
    [0.25]
    """
    from scipy.interpolate import KroghInterpolator, PchipInterpolator

    order = np.argsort(knots)
    curve = (KroghInterpolator if len(knots) <= 3 else PchipInterpolator)(knots[order], values[order])
    return np.asarray(curve(points), dtype=float)


@style.drawn
def draw_comparison(samples: Sequence[Sample], labels: Mapping[str, str]) -> Figure:
    """Draw the mean and standard deviation of each clutch over speed, one panel for each measure."""
    measures = list(dict.fromkeys(sample.measure for sample in samples))
    clutches = list(dict.fromkeys(sample.clutch for sample in samples))
    speeds = sorted({sample.speed_m_s for sample in samples})
    figure = style.new_figure(2.6)
    row = figure.subplots(1, len(measures), squeeze=False)[0]
    handles: dict[str, Any] = {}
    for axes, measure in zip(row, measures, strict=True):
        for index, clutch in enumerate(clutches):
            measured = [s for s in samples if (s.clutch, s.measure) == (clutch, measure)]
            if measured:
                offset = 0.16 * (index - (len(clutches) - 1) / 2)
                handles[clutch] = _errorbar(axes, measured, speeds, offset, style.colour(clutch, index))
        axes.set_title(_plain(labels.get(measure, measure)))
        axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
        axes.set_xlim(-0.5, len(speeds) - 0.5)
        axes.set_xlabel("working speed / (m/s)")
    named = {_plain(clutch): handles[clutch] for clutch in clutches}
    title = "mean; bars: one standard deviation up and down"
    figure.legend(named.values(), named.keys(), loc="outside upper left", ncols=len(clutches), frameon=False,
                  title=title, alignment="left")  # fmt: skip
    return figure


def _errorbar(axes: Axes, samples: Sequence[Sample], speeds: Sequence[float], offset: float, shade: str) -> Any:
    places = [speeds.index(sample.speed_m_s) + offset for sample in samples]
    means, spreads = [sample.mean for sample in samples], [sample.sd for sample in samples]
    return axes.errorbar(places, means, spreads, fmt="o", markersize=4.5, elinewidth=1, capsize=3, color=shade)
