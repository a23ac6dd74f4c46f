"""The presentation of a field test: what the terminal prints and the folder contains."""

from __future__ import annotations

import hashlib
import itertools
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from planter.clutch.field.analysis import Effects, Sample
from planter.clutch.field.evaluation import FieldEvaluation, ResponseGoal, order_combinations
from planter.clutch.field.trial import Factor, FieldResponse, Trial
from planter.clutch.results import FactorLevels, FieldTest, Level, ResponseLabel
from planter.files import csv_rows
from planter.report import style
from planter.report.html import Block, Cell, Folded, Items, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import count_things, format_label, format_name
from planter.report.presentation import ResultPresentation
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

BEST_ROWS, PAGE_ROWS = 5, 500
"""Combinations of levels among the results, and in the listing of the page; prediction.csv has
all.
"""
SURFACE_CAPTION = (
    "Additive prediction over pairs of factors, the others at their middle level; contours below."
)
MOST_FACTORS = 6
"""Maximum number of factors in a figure of effects."""
SURFACE_FACTORS = 3
"""Factors whose pairs have a response surface each."""
COLOURS = "viridis"
WITHOUT_SCALE = 0.94
"""Share of a figure's width that the surfaces take; the rest is for the colour scale."""
GRID = 31
"""Points along each side of a response surface."""


def present_field_test(evaluation: FieldEvaluation) -> ResultPresentation:
    """Return the presentation: effects, analysis of variance, prediction, and comparison of
    clutches.
    """
    result = evaluation.result
    effects_caption = (
        "Predicted mean at each level (blue), single runs (grey), mean of all runs (dashed)"
    )
    if result.best:
        effects_caption += ", the levels that are best by the response's goal (green)"
    surfaces = (_surface_name(name, index) for index, name in enumerate(result.responses, 1))
    return ResultPresentation(
        title=f"Field test {result.source}",
        conclusion=_conclude(result),
        record=result,
        key_figures=list(_list_field_figures(result)),
        sections=list(_list_sections(evaluation)),
        figures=partial(_draw_figures, evaluation),
        captions={
            "effects": effects_caption + ".",
            "comparison": "Mean and standard deviation of each clutch.",
            **dict.fromkeys(surfaces, SURFACE_CAPTION),
        },
        details=partial(_list_combinations, result),
        texts=partial(_format_tables, result),
        provenance=_list_sources(evaluation),
    )


def _list_field_figures(result: FieldTest) -> Iterator[KeyFigure]:
    """Yield the number of runs, and the strongest effect on each of the first two responses."""
    yield KeyFigure(str(result.runs), "", "runs")
    for response, sources in list(result.anova.items())[:2]:
        tests = {
            name: p for name, row in sources.items() if (p := getattr(row, "p", None)) is not None
        }
        if tests:
            name = min(tests, key=lambda source: tests[source])
            meaning = (
                f"p of {_name(result.factors, name)}, the strongest effect on "
                f"{_name(result.responses, response)}"
            )
            yield KeyFigure(f"{tests[name]:.2g}", "", meaning)


def _conclude(result: FieldTest) -> str:
    effects = []
    for response, sources in result.anova.items():
        tests = {
            name: p for name, row in sources.items() if (p := getattr(row, "p", None)) is not None
        }
        names = [_name(result.factors, name) for name, p in tests.items() if p < 0.05]
        outcome = ", ".join(names) or ("none" if tests else "not testable")
        effects.append(f"{outcome} on {_name(result.responses, response)}")
    return f"Effects with p < 0.05 in {count_things(result.runs, 'run')}: {'; '.join(effects)}."


def _name(columns: Mapping[str, FactorLevels | ResponseLabel], name: str) -> str:
    """Return the meaning of a column without its unit, or its name if it has none."""
    label = columns[name].label if name in columns else ""
    return label.partition(" / ")[0] or format_name(name)


def _label(columns: Mapping[str, FactorLevels | ResponseLabel], name: str) -> str:
    """Return the meaning of a column with its unit, and its name in brackets."""
    label = columns[name].label if name in columns else ""
    words, stroke, unit = label.partition(" / ")
    return f"{words} ({name}){stroke}{unit}" if words else format_label(name)


def _format_level(factor: FactorLevels, level: Level) -> str:
    """Return the value that a level stands for, or the level if it is one itself."""
    return str(level) if factor.values is None else f"{factor.values[factor.levels.index(level)]:g}"


def _list_sections(evaluation: FieldEvaluation) -> Iterator[Section]:
    result = evaluation.result
    facts: dict[str, Cell] = {"runs": result.runs, "responses": ", ".join(result.responses)}
    facts |= {f"goal of {name}": goal for name, goal in result.goals.items()}
    factors = [
        (
            name,
            factor.label,
            ", ".join(map(str, factor.levels)),
            ", ".join(f"{v:g}" for v in factor.values or ()),
        )
        for name, factor in result.factors.items()
    ]
    warnings = (
        [Items([f"{warning}." for warning in result.warnings], "warning")]
        if result.warnings
        else []
    )
    table = Table(("factor", "meaning", "levels", "values"), factors, "Factors", ("values",))
    yield Section("Field test", [Keys(facts), *warnings, table])
    if result.range:
        yield Section(
            "Range analysis", [_tabulate_ranges(result, response) for response in result.range]
        )
    columns = ("response", "source", "sum of squares", "df", "mean square", "F", "p", "")
    rows = [
        (*row, "" if (p := row[-1]) is None else "*" * ((p < 0.05) + (p < 0.01)))
        for row in _list_variances(result)
    ]
    note = "** p < 0.01, * p < 0.05; mean squares and F from unrounded sums"
    caption = f"Sums of squares: {result.sums_of_squares}"
    yield Section("Analysis of variance", [Table(columns, rows, caption), Text(note, "note")])
    yield Section("Prediction", list(_describe_prediction(result)))
    if result.comparison or result.other_comparisons:
        note = "p: Welch's test of each difference; p (Holm): adjusted for all pairs together"
        yield Section(
            "Comparison of clutches", [*_tabulate_comparisons(result), Text(note, "note")]
        )


def _tabulate_ranges(result: FieldTest, response: str) -> Table:
    """Return the means of a response at the levels of the factors, which are named by their
    values.
    """
    rows = [
        (_label(result.factors, name), _format_level(result.factors[name], level), mean, width)
        for column, name, level, mean, width in _list_ranges(result)
        if column == response
    ]
    return Table(
        ("factor", "level", "mean", "range"),
        rows,
        f"Range analysis, {_label(result.responses, response)}",
    )


def _tabulate_comparisons(result: FieldTest) -> Iterator[Table]:
    """Yield a table for each pair of clutches."""
    keys = ("measure", "speed_m_s", "difference", "reduction_percent", "p_value", "p_holm")
    head = ("measure", "m/s", "difference", "reduction %", "p", "p (Holm)")
    pairs: dict[str, list[list[Cell]]] = {}
    for row in (*result.comparison, *result.other_comparisons):
        cells = [_label(result.responses, row.measure), *(getattr(row, key) for key in keys[1:])]
        pairs.setdefault(f"{row.clutch} against {row.reference}", []).append(cells)
    for caption, rows in pairs.items():
        yield Table(head, rows, caption)


def _describe_prediction(result: FieldTest) -> Iterator[Block]:
    if result.best:
        goals = result.goals | {"both": "least mean rank"}
        best = [
            (
                "all together" if name == "both" else _name(result.responses, name),
                goals[name],
                *map(_format_level, result.factors.values(), levels),
            )
            for name, levels in result.best.items()
        ]
        yield Table(
            ("response", "goal", *_list_heads(result)[: len(result.factors)]), best, "Best levels"
        )
    title = "Additive prediction, best first" if result.goals else "Additive prediction"
    yield Table(_list_heads(result), _order_predictions(result)[:BEST_ROWS], title)
    yield Text(
        "The prediction adds main effects: interactions are neither predicted nor tested.", "note"
    )


def _list_heads(result: FieldTest) -> list[str]:
    """Return factors and responses as heads of columns."""
    columns: Mapping[str, FactorLevels | ResponseLabel] = {**result.factors, **result.responses}
    return [_label(columns, name) for name in columns]


def _list_combinations(result: FieldTest) -> Iterator[Section]:
    rows = _order_predictions(result)
    order = ", best by mean rank first" if result.goals else ""
    title = f"{min(len(rows), PAGE_ROWS)} of {len(rows)} combinations{order}"
    table = Table(_list_heads(result), rows[:PAGE_ROWS])
    yield Section("Predictions", [Folded(title, [table])])


def _list_ranges(result: FieldTest) -> list[tuple[Any, ...]]:
    """Return response, factor, level and mean, with the range in the first row of each factor."""
    return [
        (response, name, level, mean, None if index else means.R)
        for response, factors in (result.range or {}).items()
        for name, means in factors.items()
        for index, (level, mean) in enumerate(
            zip(result.factors[name].levels, means.k, strict=True)
        )
    ]


def _list_variances(result: FieldTest) -> list[tuple[Any, ...]]:
    """Return response, source, sum of squares, degrees of freedom, mean square, F and p."""
    return [
        (response, name, *(getattr(row, key, None) for key in ("ss", "df", "ms", "F", "p")))
        for response, sources in result.anova.items()
        for name, row in sources.items()
    ]


def _order_predictions(result: FieldTest) -> list[tuple[Any, ...]]:
    """Return levels and means of all combinations, best by all goals first, or in the design's
    order without goals.
    """
    rows = result.prediction
    losses = [
        ResponseGoal.parse(goal).loss(np.array([row.means[name] for row in rows]))
        for name, goal in result.goals.items()
    ]
    order = order_combinations(losses) if rows and losses else range(len(rows))
    factors = result.factors.values()
    return [
        (
            *map(_format_level, factors, rows[k].levels),
            *(rows[k].means[name] for name in result.responses),
        )
        for k in order
    ]


def _format_tables(result: FieldTest) -> dict[str, str]:
    """Return the CSV texts by file name."""
    responses = result.responses
    predicted = [
        (*row.levels, *(row.means[name] for name in responses)) for row in result.prediction
    ]
    tables: dict[str, tuple[Sequence[str], list[tuple[Any, ...]]]] = {
        "anova": (("response", "source", "ss", "df", "ms", "F", "p"), _list_variances(result)),
        "prediction": ((*result.factors, *responses), predicted),
    }
    if result.range:
        tables["range"] = (("response", "factor", "level", "k", "R"), _list_ranges(result))
    if pairs := [pair.table() for pair in (*result.comparison, *result.other_comparisons)]:
        tables["comparison"] = (tuple(pairs[0]), [tuple(pair.values()) for pair in pairs])
    comments = [f"data: {result.source}"]
    return {
        f"{name}.csv": csv_rows.format_csv(comments, head, rows)
        for name, (head, rows) in tables.items()
    }


def _list_sources(evaluation: FieldEvaluation) -> dict[str, Any]:
    """Return versions, and a hash of all evaluated values."""
    trial = evaluation.trial
    values = [
        *((f.name, f.levels, f.codes.tolist()) for f in (*trial.factors, *trial.blanks)),
        *((response.name, response.values.tolist()) for response in trial.responses),
        *(vars(sample) for sample in evaluation.samples),
    ]
    versions = {name: metadata.version(name) for name in ("numpy", "scipy")}
    digest = hashlib.sha256(repr(values).encode("utf-8")).hexdigest()
    return {
        "planter": __version__,
        **versions,
        "python": platform.python_version(),
        "data_sha256": digest,
    }


def _draw_figures(evaluation: FieldEvaluation) -> dict[str, Figure]:
    trial, order = evaluation.trial, _order_factors(evaluation)
    plots = {"effects": draw_effects(evaluation, order)}
    if len(_list_drawable(order)) > 1:
        for index, response in enumerate(trial.responses, 1):
            plots[_surface_name(response.name, index)] = draw_response_surface(
                evaluation, response, order
            )
    if evaluation.samples:
        labels = {response.name: response.label for response in trial.responses}
        plots["comparison"] = draw_comparison(evaluation.samples, labels)
    return plots


def _surface_name(response: str, index: int) -> str:
    """Return the name of a response's figure: the response's name if it is a valid file name.

    >>> _surface_name("Y1", 1), _surface_name("Y 1/2", 3)
    ('surface_Y1', 'surface_3')
    """
    return (
        f"surface_{response}"
        if re.fullmatch(r"[A-Za-z]\w*", response, re.ASCII)
        else f"surface_{index}"
    )


def _order_factors(evaluation: FieldEvaluation) -> list[Factor]:
    """Return all factors in the order of the design, or if they are many, by their largest share of
    a variation.
    """
    factors = list(evaluation.trial.factors)
    if len(factors) <= SURFACE_FACTORS:
        return factors
    anova = evaluation.result.anova.values()
    share = {
        f.name: max(table[f.name].ss / (table["total"].ss or 1) for table in anova) for f in factors
    }
    return sorted(factors, key=lambda factor: -share[factor.name])


@style.with_style
def draw_effects(evaluation: FieldEvaluation, order: Sequence[Factor]) -> Figure:
    """Draw predicted means at the levels of the first factors of an order, over the runs; circles
    mark best levels.
    """
    trial, chosen = evaluation.trial, order[:MOST_FACTORS]
    figure = style.new_figure(0.4 + 1.9 * len(trial.responses))
    grid = figure.subplots(len(trial.responses), len(chosen), sharey="row", squeeze=False)
    for row, response in zip(grid, trial.responses, strict=True):
        best = (evaluation.result.best or {}).get(response.name)
        for axes, factor in zip(row, chosen, strict=True):
            index = trial.factors.index(factor)
            estimate = evaluation.effects[response.name]
            _effect(
                axes, factor, response, estimate.mean + estimate.levels[index], best and best[index]
            )
        row[0].set_ylabel(_with_goal(evaluation, response, "\n"))
    for axes, factor in zip(grid[-1], chosen, strict=True):
        axes.set_xlabel(_plain(factor.label))
    return figure


def _with_goal(evaluation: FieldEvaluation, response: FieldResponse, separator: str) -> str:
    """Return the meaning of a response and its goal."""
    goal = evaluation.goals.get(response.name)
    return _plain(response.label) + (f"{separator}goal: {goal}" if goal else "")


def _effect(axes: Axes, factor: Factor, response: FieldResponse, means: Array, best: Any) -> None:
    places = np.arange(len(factor.levels))
    axes.plot(factor.codes, response.values, "o", color=style.FAINT, markersize=3, label="runs")
    axes.plot(places, means, "o-", color=style.BLUE, markersize=4.5, label="effect")
    if best is not None:
        place = factor.levels.index(best)
        axes.plot(
            place,
            means[place],
            "o",
            color=style.GREEN,
            markersize=9,
            markerfacecolor="none",
            label="best",
        )
    axes.axhline(
        float(response.values.mean()), color=style.SOFT, linewidth=0.6, linestyle=(0, (4, 3))
    )
    axes.set_xticks(places, _ticks(factor))
    axes.set_xlim(-0.4, len(places) - 0.6)


def _ticks(factor: Factor) -> list[str]:
    if factor.scale:
        return [f"{value:g}" for value in factor.scale]
    return [_plain(str(level)) for level in factor.levels]


def _plain(text: str) -> str:
    """Return a user's text with dollars escaped, which would set it as mathematics."""
    return text.replace("$", r"\$")


@style.with_style
def draw_response_surface(
    evaluation: FieldEvaluation, response: FieldResponse, order: Sequence[Factor]
) -> Figure:
    """Draw a response over each pair of the first factors with numeric levels, the others at a
    middle level.
    """
    chosen = _list_drawable(order)
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

    bar = figure.colorbar(
        ScalarMappable(Normalize(*limits), COLOURS), figure.add_axes((0.945, 0.2, 0.012, 0.6))
    )
    bar.ax.tick_params(labelsize=6.5)
    bar.outline.set_visible(False)


def _list_drawable(order: Sequence[Factor]) -> list[Factor]:
    return [factor for factor in order if factor.scale][:SURFACE_FACTORS]


def _draw_surface(
    axes: Any, x: Array, y: Array, height: Array, limits: tuple[float, float]
) -> None:
    floor = limits[0] - 0.35 * (limits[1] - limits[0])
    colours = {"cmap": COLOURS, "vmin": limits[0], "vmax": limits[1]}
    axes.plot_surface(
        x, y, height, rcount=GRID, ccount=GRID, linewidth=0, antialiased=False, **colours
    )
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


def _height(
    trial: Trial, estimate: Effects, pair: tuple[Factor, Factor]
) -> tuple[Array, Array, Array]:
    """Return a grid of two factors' values, and the additive prediction over it."""
    levels = dict(zip((factor.name for factor in trial.factors), estimate.levels, strict=True))
    rest = sum(
        level[(len(level) - 1) // 2]
        for name, level in levels.items()
        if name not in (pair[0].name, pair[1].name)
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
    """Return a factor's effect between its levels: line or parabola for two or three, else a
    monotone cubic.

    >>> interpolate_effect(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 4.0]), np.array([0.5])).round(12).tolist()
    [0.25]
    """
    order = np.argsort(knots)
    kind = (
        scipy.interpolate.KroghInterpolator
        if len(knots) <= 3
        else scipy.interpolate.PchipInterpolator
    )
    curve = kind(knots[order], values[order])
    return np.asarray(curve(points), dtype=float)


@style.with_style
def draw_comparison(samples: Sequence[Sample], labels: Mapping[str, str]) -> Figure:
    """Draw the mean and standard deviation of each clutch over speed, one panel for each
    measure.
    """
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
                handles[clutch] = _errorbar(
                    axes, measured, speeds, offset, style.curve_colour(clutch, index)
                )
        axes.set_title(_plain(labels.get(measure) or format_label(measure)))
        axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
        axes.set_xlim(-0.5, len(speeds) - 0.5)
        axes.set_xlabel("working speed / (m/s)")
    named = {_plain(clutch): handles[clutch] for clutch in clutches}
    title = "mean; bars: one standard deviation up and down"
    figure.legend(
        named.values(),
        named.keys(),
        loc="outside upper left",
        ncols=len(clutches),
        frameon=False,
        title=title,
        alignment="left",
    )
    return figure


def _errorbar(
    axes: Axes, samples: Sequence[Sample], speeds: Sequence[float], offset: float, shade: str
) -> Any:
    places = [speeds.index(sample.speed_m_s) + offset for sample in samples]
    means, spreads = [sample.mean for sample in samples], [sample.sd for sample in samples]
    return axes.errorbar(
        places, means, spreads, fmt="o", markersize=4.5, elinewidth=1, capsize=3, color=shade
    )
