"""Figures, page and terminal tables of a field test."""

from __future__ import annotations

import hashlib
import itertools
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.field.analysis import Effects, Sample
from planter.clutch.field.evaluation import FieldEvaluation, ResponseGoal, order_combinations
from planter.clutch.field.trial import Factor, FieldResponse, Trial
from planter.clutch.results import Compared, FieldTest
from planter.files import csv_rows
from planter.progress import Listener
from planter.report import bundle, files, style
from planter.report.html import Block, Cell, FigureSvg, Folded, Items, Keys, Section, Table, Text, page
from planter.terminal.console import Console
from planter.version import __version__

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


TableRows = list[Sequence[Any]]
MOST_ROWS = 500
"""Combinations of levels that the page shows; prediction.csv holds all."""


def write_field_report(out: str | Path, evaluation: FieldEvaluation, progress: Listener | None = None) -> None:
    """Write all files into a folder, or none. Raises InputError if the folder cannot be written."""
    files.output_folder(out)
    summary = files.summary_text({**evaluation.result.table(), "provenance": build_provenance(evaluation)})
    listing = {
        f"{name}.csv": csv_rows.written([f"data: {evaluation.result.source}"], head, rows)
        for name, (head, rows) in list_tables(evaluation.result).items()
    }
    saved = bundle.drawn(draw_figures(evaluation), progress)
    report = render_page(evaluation, {name: figure.svg for name, figure in saved.items()})
    bundle.write(out, {"summary.json": summary, **listing, "report.html": report}, saved)


def build_provenance(evaluation: FieldEvaluation) -> dict[str, Any]:
    """Return versions, and a hash of all evaluated values."""
    trial = evaluation.trial
    values = [
        *((f.name, f.levels, f.codes.tolist()) for f in (*trial.factors, *trial.blanks)),
        *((response.name, response.values.tolist()) for response in trial.responses),
        *(vars(sample) for sample in evaluation.samples),
    ]
    versions = {name: metadata.version(name) for name in ("numpy", "scipy")}
    digest = hashlib.sha256(repr(values).encode("utf-8")).hexdigest()
    return {"planter": __version__, **versions, "python": platform.python_version(), "data_sha256": digest}


def list_tables(result: FieldTest) -> dict[str, tuple[Sequence[str], TableRows]]:
    """Return head and rows of every table."""
    factors, responses = result.factors, result.responses
    listing: dict[str, tuple[Sequence[str], TableRows]] = {}
    if result.range:
        listing["range"] = (("response", "factor", "level", "k", "R"), list(range_rows(result)))
    columns = ("response", "source", "ss", "df", "ms", "F", "p")
    listing["anova"] = (columns, [row[: len(columns)] for row in anova_rows(result)])
    predicted: TableRows = [(*row.levels, *(row.means[name] for name in responses)) for row in result.prediction]
    listing["prediction"] = ((*factors, *responses), predicted)
    pairs = [*result.comparison, *result.other_comparisons]
    if pairs:
        listing["comparison"] = (tuple(pairs[0].table()), [tuple(pair.table().values()) for pair in pairs])
    return listing


def draw_figures(evaluation: FieldEvaluation) -> dict[str, Figure]:
    """Return the figures by the names of their files."""
    trial = evaluation.trial
    order = order_factors(evaluation)
    labels = {response.name: response.label for response in trial.responses}
    plots = {"effects": draw_effects(evaluation, order)}
    if has_surface(order):
        for index, response in enumerate(trial.responses, 1):
            plots[surface_name(response.name, index)] = draw_response_surface(evaluation, response, order)
    if evaluation.samples:
        plots["comparison"] = draw_comparison(evaluation.samples, labels)
    return plots


def surface_name(response: str, index: int) -> str:
    """Return the name of a response's figure: the response's name if it is a valid file name.

    >>> surface_name("Y1", 1), surface_name("Y 1/2", 3)
    ('surface_Y1', 'surface_3')
    """
    return f"surface_{response}" if re.fullmatch(r"[A-Za-z]\w*", response, re.ASCII) else f"surface_{index}"


def order_factors(evaluation: FieldEvaluation) -> list[Factor]:
    """Return all factors in the order of the design, or if they are many, by their largest share of a variation."""
    factors = list(evaluation.trial.factors)
    if len(factors) <= SURFACE_FACTORS:
        return factors
    anova = evaluation.result.anova.values()
    share = {f.name: max(table[f.name].ss / (table["total"].ss or 1) for table in anova) for f in factors}
    return sorted(factors, key=lambda factor: -share[factor.name])


def render_page(evaluation: FieldEvaluation, svgs: Mapping[str, str]) -> str:
    """Return the page of an evaluation, with the SVG texts of its figures."""
    result = evaluation.result
    facts: dict[str, Cell] = {"runs": result.runs, "factors": ", ".join(result.factors)}
    facts |= {"responses": ", ".join(result.responses), "sums of squares": result.sums_of_squares}
    facts |= {f"goal of {name}": goal for name, goal in result.goals.items()}
    subtitle = "Main effects, prediction and comparison from the runs of a field test"
    first: list[Block] = [Keys(facts)]
    if result.warnings:
        first.append(Items([f"{warning}." for warning in result.warnings], "warning"))
    sections = [Section("The test", [*first, _meanings(evaluation)]), *_sections(result, svgs)]
    sections.append(Section("How this was computed", [Keys(build_provenance(evaluation))]))
    return page(f"Field test {result.source}", sections, subtitle)


def _meanings(evaluation: FieldEvaluation) -> Block:
    rows = [
        (f.name, f.label, ", ".join(map(str, f.levels)), ", ".join(f"{v:g}" for v in f.values) if f.values else None)
        for f in evaluation.trial.factors
    ]
    return Table(("factor", "meaning", "levels", "values"), rows)


def _sections(result: FieldTest, svgs: Mapping[str, str]) -> Iterator[Section]:
    caption = "Predicted mean at each level (blue), single runs (grey), mean of all runs (dashed)"
    if result.best:
        caption += ", the levels that are best by the response's goal (green)"
    effects: list[Block] = [FigureSvg(svgs["effects"], caption)]
    if result.range:
        effects.append(Table(RANGE, list(range_rows(result)), "Range analysis"))
    yield Section("Effects", effects)
    stars = "** p < 0.01, * p < 0.05; mean squares and F from unrounded sums"
    yield Section("Analysis of variance", [Table(ANOVA, list(anova_rows(result))), Text(stars, "note")])
    yield Section("Prediction", list(_prediction(result, svgs)))
    if result.comparison or result.other_comparisons:
        yield Section("Comparison of clutches", list(_comparison(result, svgs)))


def _prediction(result: FieldTest, svgs: Mapping[str, str]) -> Iterator[Block]:
    head = tuple(result.factors)
    if result.best:
        yield Table(BEST + head, list(best_rows(result)), "Best levels")
    note = "The prediction adds main effects: interactions, if there are any, are neither in it nor tested."
    yield Text(note, "note")
    surfaces = [name for name in svgs if name.startswith("surface")]
    for name in surfaces:
        caption = "Additive prediction over pairs of factors, the others at their middle level; contours below"
        yield FigureSvg(svgs[name], caption)
    rows = list(prediction_rows(result))
    ordered = ", best by mean rank first" if result.goals else ""
    title = f"{min(len(rows), MOST_ROWS)} of {len(rows)} combinations{ordered}"
    yield Folded(title, [Table((*head, *result.responses), rows[:MOST_ROWS])])


def _comparison(result: FieldTest, svgs: Mapping[str, str]) -> Iterator[Block]:
    yield FigureSvg(svgs["comparison"], "Mean and standard deviation")
    for pairs, title in ((result.comparison, "The first two clutches"), (result.other_comparisons, "Other pairs")):
        if pairs:
            yield Table(COMPARISON, list(comparison_rows(pairs)), title)
    yield Text("p: Welch's test; Holm: the same, held together over all pairs", "note")


Rows = Iterator[Sequence[Any]]

RANGE = ("response", "factor", "level", "mean", "range")
ANOVA = ("response", "source", "sum of squares", "df", "mean square", "F", "p", "")
BEST = ("response", "goal")
PAIR = ("measure", "speed_m_s", "clutch", "reference", "difference", "reduction_percent", "p_value", "p_holm")
COMPARISON = ("measure", "m/s", "clutch", "against", "difference", "reduction %", "p", "p (Holm)")
SHOWN = 5
"""Combinations of levels that the console shows, the best first."""


def print_field_test(console: Console, result: FieldTest) -> None:
    """Print all results, of the predictions only the best."""
    print(f"{result.source}: {result.runs} runs, factors {', '.join(result.factors)}\n")
    if result.range:
        console.table("Range analysis", RANGE, range_rows(result))
    console.table(f"Analysis of variance, sums of squares: {result.sums_of_squares}", ANOVA, anova_rows(result))
    factors = tuple(result.factors)
    if result.best:
        console.table("Best levels", BEST + factors, best_rows(result))
    head = (*factors, *result.responses)
    title = "Additive prediction, best first" if result.goals else "Additive prediction"
    console.table(title, head, list(prediction_rows(result))[:SHOWN])
    _comparisons(console, [*result.comparison, *result.other_comparisons])
    for warning in result.warnings:
        print(f"Note: {warning}.")


def range_rows(result: FieldTest) -> Rows:
    """Yield level means, with the range in the first row of each factor."""
    for response, factors in (result.range or {}).items():
        for name, means in factors.items():
            for index, (level, mean) in enumerate(zip(result.factors[name].levels, means.k, strict=True)):
                yield response, name, str(level), mean, None if index else means.R


def anova_rows(result: FieldTest) -> Rows:
    """Yield rows of all responses, with the usual stars: two for p < 0.01, one for p < 0.05."""
    for response, sources in result.anova.items():
        for name, row in sources.items():
            mean, ratio, p = (getattr(row, key, None) for key in ("ms", "F", "p"))
            stars = "" if p is None else "**" if p < 0.01 else "*" if p < 0.05 else ""
            yield response, name, row.ss, row.df, mean, ratio, p, stars


def best_rows(result: FieldTest) -> Rows:
    """Yield the levels with the best prediction by the goal of each response, and of all together."""
    for name, levels in (result.best or {}).items():
        goal = ("all together", "least mean rank") if name == "both" else (name, result.goals[name])
        yield (*goal, *(str(level) for level in levels))


def prediction_rows(result: FieldTest) -> Rows:
    """Yield combinations of levels, the best by all goals first; without goals in the order of the design."""
    rows, goals = result.prediction, result.goals
    losses = [
        ResponseGoal.parse(goal).loss(np.array([row.means[name] for row in rows])) for name, goal in goals.items()
    ]
    for index in order_combinations(losses) if rows and losses else range(len(rows)):
        row = rows[index]
        yield (*(str(level) for level in row.levels), *(row.means[name] for name in result.responses))


def comparison_rows(pairs: Sequence[Compared]) -> Rows:
    """Yield rows under the heads of `COMPARISON`."""
    for row in pairs:
        yield tuple(getattr(row, key) for key in PAIR)


def _comparisons(console: Console, pairs: Sequence[Compared]) -> None:
    """A table for each pair of clutches: narrow enough for a terminal."""
    for clutches in dict.fromkeys((row.clutch, row.reference) for row in pairs):
        same = [row for row in pairs if (row.clutch, row.reference) == clutches]
        rows = [(measure, speed, *rest) for measure, speed, _, _, *rest in comparison_rows(same)]
        console.table(f"{clutches[0]} against {clutches[1]} (Welch)", (*COMPARISON[:2], *COMPARISON[4:]), rows)
