"""A field test's evaluation as tables that a person likes to read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from planter.clutch.field.goals import Goal, order
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


def show(console: Console, result: FieldTest) -> None:
    """Everything but the long list of predictions, of which the best are shown."""
    print(f"{result.source}: {result.runs} runs, factors {', '.join(result.factors)}\n")
    if result.range:
        console.table("Range analysis", RANGE, ranges(result))
    console.table(f"Analysis of variance, sums of squares: {result.sums_of_squares}", ANOVA, anova(result))
    factors = tuple(result.factors)
    if result.best:
        console.table("Best levels", BEST + factors, best(result))
    head = (*factors, *result.responses)
    title = "Additive prediction, best first" if result.goals else "Additive prediction"
    console.table(title, head, list(predictions(result))[:SHOWN])
    _comparisons(console, [*result.comparison, *result.other_comparisons])
    for warning in result.warnings:
        print(f"Note: {warning}.")


def ranges(result: FieldTest) -> Rows:
    """Level means, the range beside the first of each factor."""
    for response, factors in (result.range or {}).items():
        for name, found in factors.items():
            for index, (level, mean) in enumerate(zip(result.factors[name].levels, found.k, strict=True)):
                yield response, name, str(level), mean, None if index else found.R


def anova(result: FieldTest) -> Rows:
    """Rows of all responses, with the usual stars: two for p < 0.01, one for p < 0.05."""
    for response, sources in result.anova.items():
        for name, row in sources.items():
            mean, ratio, p = (getattr(row, key, None) for key in ("ms", "F", "p"))
            stars = "" if p is None else "**" if p < 0.01 else "*" if p < 0.05 else ""
            yield response, name, row.ss, row.df, mean, ratio, p, stars


def best(result: FieldTest) -> Rows:
    """Levels with the best prediction by the goal of each response, and of all together."""
    for name, levels in (result.best or {}).items():
        goal = ("all together", "least mean rank") if name == "both" else (name, result.goals[name])
        yield (*goal, *(str(level) for level in levels))


def predictions(result: FieldTest) -> Rows:
    """Combinations of levels, the best by the goals of all responses first; in their own order where there are none."""
    rows, goals = result.prediction, result.goals
    losses = [Goal.of(goal).loss(np.array([row.means[name] for row in rows])) for name, goal in goals.items()]
    for index in order(losses) if rows and losses else range(len(rows)):
        row = rows[index]
        yield (*(str(level) for level in row.levels), *(row.means[name] for name in result.responses))


def comparisons(found: Sequence[Compared]) -> Rows:
    """Rows under the heads of `COMPARISON`."""
    for row in found:
        yield tuple(getattr(row, key) for key in PAIR)


def _comparisons(console: Console, found: Sequence[Compared]) -> None:
    """A table for each pair of clutches: narrow enough for a terminal."""
    for pair in dict.fromkeys((row.clutch, row.reference) for row in found):
        mine = [row for row in found if (row.clutch, row.reference) == pair]
        rows = [(measure, speed, *rest) for measure, speed, _, _, *rest in comparisons(mine)]
        console.table(f"{pair[0]} against {pair[1]} (Welch)", (*COMPARISON[:2], *COMPARISON[4:]), rows)
