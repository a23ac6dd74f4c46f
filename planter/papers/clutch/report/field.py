"""The presentation of a field test: what the terminal prints and the folder contains."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from planter.files import csv_rows
from planter.papers.clutch.field import FieldEvaluation
from planter.papers.clutch.results import FieldTest
from planter.report import style
from planter.report.html import Section, Table, Text
from planter.report.labels import format_name
from planter.report.presentation import ResultPresentation
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 5
"""Combinations among the results; prediction.csv has all."""
CAPTIONS = {
    "effects": "Mean at each level (blue), single runs (grey), mean of all runs (dashed).",
    "comparison": "Mean and standard deviation of each clutch.",
}
VARIANCE_HEAD = ("response", "source", "ss", "df", "ms", "F", "p")


def present_field_test(evaluation: FieldEvaluation) -> ResultPresentation:
    """Return the presentation: ranges, analysis of variance, prediction, comparison of clutches."""
    trial, result = evaluation.trial, evaluation.result
    tables = _build_tables(result)
    values = [(name, column.tolist()) for name, column in trial.responses.items()]
    values += [(name, factor.codes.tolist()) for name, factor in trial.factors.items()]
    return ResultPresentation(
        title=f"Field test {result.source}",
        conclusion=_conclude(result),
        record=result,
        sections=list(_list_sections(result, tables)),
        figures=lambda: _draw_figures(evaluation),
        captions=CAPTIONS,
        texts=lambda: {
            f"{name}.csv": csv_rows.format_csv(
                [f"data: {result.source}"], table.head, [_fill_cells(row) for row in table.rows]
            )
            for name, table in tables.items()
        },
        provenance={
            "planter": __version__,
            "data_sha256": hashlib.sha256(repr(values).encode("utf-8")).hexdigest(),
        },
    )


def _fill_cells(row: object) -> list[object]:
    return ["" if cell is None else cell for cell in row]  # type: ignore[attr-defined]


def _conclude(result: FieldTest) -> str:
    parts = []
    for response, sources in result.anova.items():
        chances = {name: getattr(row, "p", None) for name, row in sources.items()}
        strong = [name for name, p in chances.items() if p is not None and p < 0.05]
        parts.append(f"{', '.join(strong) or 'none'} on {response}")
    return f"Effects with p < 0.05 in {result.runs} runs: {'; '.join(parts)}."


def _build_tables(result: FieldTest) -> dict[str, Table]:
    """Return the tables by the names of their files."""
    ranges, variances = [], []
    for response, factors in result.range.items():
        for name, means in factors.items():
            ranges += [(response, name, i, k, means.R) for i, k in enumerate(means.k, 1)]
    for response, sources in result.anova.items():
        for name, row in sources.items():
            cells = (getattr(row, key, None) for key in VARIANCE_HEAD[2:])
            variances.append((response, name, *cells))
    factors = next(iter(result.range.values()))
    predicted = [(*row.levels, *row.means.values()) for row in result.prediction]
    tables = {
        "range": Table(("response", "factor", "level", "k", "R"), ranges),
        "anova": Table(VARIANCE_HEAD, variances),
        "prediction": Table((*factors, *result.goals), predicted),
    }
    if result.comparison:
        pairs = [pair.table() for pair in result.comparison]
        rows = [tuple(pair.values()) for pair in pairs]
        tables["comparison"] = Table(tuple(pairs[0]), rows)
    return tables


def _list_sections(result: FieldTest, tables: Mapping[str, Table]) -> Iterator[Section]:
    yield Section("Range analysis", [tables["range"]])
    yield Section("Analysis of variance", [tables["anova"]])
    goals = result.goals | {"both": "least mean rank"}
    factors = next(iter(result.range.values()))
    best = [(name, goals[name], *levels) for name, levels in result.best.items()]
    prediction = Table(tables["prediction"].head, tables["prediction"].rows[:SHOWN])
    note = "The prediction adds main effects: interactions are neither predicted nor tested."
    yield Section(
        "Prediction",
        [
            Table(("response", "goal", *factors), best, "Best levels"),
            prediction,
            Text(note, "note"),
        ],
    )
    if "comparison" in tables:
        note = "p: Welch's test of each difference"
        rows = [
            (pair.speed_m_s, format_name(pair.measure), pair.reduction_percent, pair.p_value)
            for pair in result.comparison
        ]
        table = Table(("speed / m/s", "measure", "reduction / %", "p"), rows)
        yield Section("Comparison of clutches", [table, Text(note, "note")])


def _draw_figures(evaluation: FieldEvaluation) -> dict[str, Figure]:
    figures = {"effects": draw_effects(evaluation)}
    if evaluation.samples:
        figures["comparison"] = draw_comparison(evaluation)
    return figures


def _escape(text: str) -> str:
    """Return a user's text with dollars escaped, which would set it as mathematics."""
    return text.replace("$", r"\$")


@style.with_style
def draw_effects(evaluation: FieldEvaluation) -> Figure:
    """Draw means at the levels of each factor over the runs, a row for each response."""
    trial, count = evaluation.trial, len(evaluation.trial.factors)
    figure = style.new_figure(0.4 + 1.9 * len(trial.responses))
    grid = figure.subplots(len(trial.responses), count, sharey="row", squeeze=False)
    for row, (response, values) in zip(grid, trial.responses.items(), strict=True):
        means = evaluation.result.range[response]
        for axes, (name, factor) in zip(row, trial.factors.items(), strict=True):
            places = np.arange(len(factor.levels))
            axes.plot(factor.codes, values, "o", color=style.FAINT, markersize=3)
            axes.plot(places, means[name].k, "o-", color=style.BLUE, markersize=4.5)
            axes.axhline(float(values.mean()), color=style.SOFT, linewidth=0.6, linestyle="--")
            axes.set_xticks(places, [_escape(str(level)) for level in factor.levels])
            axes.set_xlim(-0.4, len(places) - 0.6)
            axes.set_xlabel(_escape(trial.labels.get(name, name)))
        row[0].set_ylabel(_escape(trial.labels.get(response, response)))
    return figure


@style.with_style
def draw_comparison(evaluation: FieldEvaluation) -> Figure:
    """Draw mean and standard deviation of each clutch over speed, a panel for each measure."""
    samples = evaluation.samples
    measures = list(dict.fromkeys(sample.measure for sample in samples))
    figure = style.new_figure(2.6)
    for axes, measure in zip(
        figure.subplots(1, len(measures), squeeze=False)[0], measures, strict=True
    ):
        clutches = list(dict.fromkeys(sample.clutch for sample in samples))
        for index, clutch in enumerate(clutches):
            chosen = [s for s in samples if (s.clutch, s.measure) == (clutch, measure)]
            axes.errorbar(
                [s.speed_m_s for s in chosen],
                [s.mean for s in chosen],
                [s.sd for s in chosen],
                fmt="o",
                capsize=3,
                color=style.curve_colour(clutch, index),
                label=_escape(clutch),
            )
        axes.set_title(_escape(evaluation.trial.labels.get(measure, measure)))
        axes.set_xlabel("working speed / (m/s)")
        axes.margins(x=0.4)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure
