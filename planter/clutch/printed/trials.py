"""Numbers of field trials: range analysis and analysis of variance as `planter clutch field` has them, and shares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from itertools import combinations

import numpy as np

from planter.audit.registry import Inputs, Value, formula
from planter.clutch.field import NEAREST_ZERO, Factor, FieldEvaluation, FieldResponse, Trial, comparison, evaluation
from planter.clutch.results.field import Level, LevelMeans


@formula("level mean")
def level_mean(inputs: Inputs) -> float:
    """Mean response of the runs at one level of a factor."""
    return _means(inputs).k[inputs["level"] - 1]


@formula("range of level means")
def level_range(inputs: Inputs) -> float:
    """Largest less least of a factor's level means: its influence in range analysis."""
    return _means(inputs).R


@formula("printed difference")
def printed_difference(inputs: Inputs) -> float:
    """Difference of two printed numbers, in size."""
    return abs(float(inputs["minuend"]) - float(inputs["subtrahend"]))


@formula("sum of squares")
def sum_of_squares(inputs: Inputs) -> Value:
    """Sum of squares of a factor, of the error or of all runs [square of the response's unit]."""
    return _variance(inputs, "ss")


@formula("degrees of freedom")
def degrees_of_freedom(inputs: Inputs) -> Value:
    """Levels less one, runs less one for the total, or what effects leave for the error."""
    return _variance(inputs, "df")


@formula("mean square")
def mean_square(inputs: Inputs) -> Value:
    """Sum of squares over its degrees of freedom."""
    return _variance(inputs, "ms")


@formula("variance ratio")
def variance_ratio(inputs: Inputs) -> Value:
    """F: mean square of a factor over that of the error, from unrounded sums."""
    return _variance(inputs, "F")


@formula("probability")
def probability(inputs: Inputs) -> Value:
    """Chance of a variance ratio at least as large if the factor has no effect."""
    return _variance(inputs, "p")


@formula("reduction")
def reduction(inputs: Inputs) -> float:
    """Reduction from one printed value to another [%]."""
    before, after = float(inputs["before"]), float(inputs["after"])
    return 100 * (before - after) / before


@formula("place in the order of influence")
def place(inputs: Inputs) -> float:
    """Place of a factor when the factors are put in the order of their ranges of level means, the largest first."""
    order = _trial(inputs).result.order or {}
    return 1.0 + order[inputs["response"]].index(inputs["factor"])


@formula("best level by level means")
def best_level(inputs: Inputs) -> float:
    """Level of a factor whose mean response is least in size."""
    best = _trial(inputs).result.range_best or {}
    return _level(inputs, best[inputs["response"]])


@formula("best level by ranks")
def best_ranked_level(inputs: Inputs) -> float:
    """Level of a factor whose worst rank among some responses is best; each ranks levels by the size of their means."""
    means = [_means(inputs, name).k for name in inputs["responses"]]
    ranks = [np.argsort(np.argsort(np.abs(k))) for k in means]
    return 1.0 + float(np.argmin(np.max(ranks, axis=0)))


@formula("freedom of interactions over what they take")
def interaction_freedom(inputs: Inputs) -> float:
    """Degrees of freedom that runs leave for interactions of two factors after main effects, less all that these have.

    Negative: some interactions cannot be separated from others or from the error (Montgomery, Design and Analysis of
    Experiments, chapter 8).
    """
    codes = [np.unique(inputs[f"column_{name}"], return_inverse=True)[1] for name in inputs["factors"]]
    contrasts = [np.eye(code.max() + 1)[code][:, 1:] for code in codes]
    pairs = [np.einsum("ri,rj->rij", a, b).reshape(len(a), -1) for a, b in combinations(contrasts, 2)]
    main = np.column_stack([np.ones(len(codes[0])), *contrasts])
    left = np.linalg.matrix_rank(np.column_stack([main, *pairs])) - np.linalg.matrix_rank(main)
    return float(left - sum(pair.shape[1] for pair in pairs))


@formula("best level by prediction")
def best_predicted_level(inputs: Inputs) -> float:
    """Level of a factor where the sum of the sizes of some predicted responses is least, over all combinations."""
    best = _trial(inputs, inputs["responses"]).result.best or {}
    return _level(inputs, best["both"])


@formula("excess of a predicted response")
def excess(inputs: Inputs) -> float:
    """Size of a predicted response at some levels less its size at others."""
    name = inputs["response"]
    sizes = {tuple(row.levels): abs(row.means[name]) for row in _trial(inputs).result.prediction}
    size, reference = (sizes[tuple(inputs[key])] for key in ("levels", "against"))
    return float(size - reference)


@formula("chance that two means differ so")
def welch(inputs: Inputs) -> Value:
    """Two-sided chance of a difference of two means at least as large for equal means, from printed mean, SD, count.

    Welch, Biometrika 34, 1947.
    """
    first, second = (_sample(inputs, name) for name in ("first", "second"))
    return comparison.welch_probability(first, second)


@formula("mean of two")
def mean_of_two(inputs: Inputs) -> float:
    """Mean of two printed numbers."""
    return (float(inputs["first"]) + float(inputs["second"])) / 2


@formula("product of counts")
def product_of_counts(inputs: Inputs) -> float:
    """Product of printed counts, over a printed divisor."""
    return math.prod(float(inputs[name]) for name in inputs["factors"]) / float(inputs[inputs["divisor"]])


@formula("sum of counts")
def sum_of_counts(inputs: Inputs) -> float:
    """Sum of printed counts."""
    return sum(float(inputs[name]) for name in inputs["terms"])


@formula("not computed")
def not_computed(inputs: Inputs) -> None:
    """Stands for a number that rests on inputs that are not disclosed."""


def _trial(inputs: Inputs, responses: Sequence[str] | None = None) -> FieldEvaluation:
    """The evaluated trial of the paper's columns with some responses, `response` unless said otherwise."""
    names = inputs["factors"]
    columns = {name: tuple(inputs[f"column_{name}"]) for name in names}
    runs = {name: tuple(inputs[name]) for name in responses or [inputs["response"]]}
    return _evaluated(tuple(columns.items()), tuple(runs.items()))


@cache
def _evaluated(
    columns: tuple[tuple[str, tuple[int, ...]], ...], responses: tuple[tuple[str, tuple[float, ...]], ...]
) -> FieldEvaluation:
    factors = []
    for name, column in columns:
        levels, codes = np.unique(column, return_inverse=True)
        factors.append(Factor(name, tuple(levels.tolist()), codes))
    measured = tuple(FieldResponse(name, np.array(values)) for name, values in responses)
    goals = dict.fromkeys((name for name, _ in responses), NEAREST_ZERO)
    return evaluation.evaluate_trial(Trial("printed runs", tuple(factors), measured), requested=goals)


def _sample(inputs: Inputs, name: str) -> comparison.Sample:
    mean, sd = inputs[name]
    return comparison.Sample(name, speed_m_s=0.0, measure="", mean=mean, sd=sd, n=inputs["repeats"])


def _variance(inputs: Inputs, part: str) -> Value:
    """An entry of the table of the analysis of variance."""
    entry: Value = getattr(_trial(inputs).result.anova[inputs["response"]][inputs["source"]], part)
    return None if entry is None else float(entry)


def _means(inputs: Inputs, response: str | None = None) -> LevelMeans:
    """Means of the runs at each level of a factor."""
    name = response or inputs["response"]
    ranges = _trial(inputs, [name]).result.range or {}
    return ranges[name][inputs["factor"]]


def _level(inputs: Inputs, levels: Sequence[Level]) -> float:
    return float(levels[inputs["factors"].index(inputs["factor"])])
