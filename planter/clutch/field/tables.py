"""Tables of a field test's evaluation, for the console and the report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from planter.clutch.field.goals import ResponseGoal, order_combinations
from planter.clutch.results.field import Compared, FieldTest
from planter.terminal.console import Console

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
