"""Numbers of field trials: range analysis, analysis of variance of an orthogonal array, differences and shares.

Montgomery, Design and Analysis of Experiments, chapters 3 (sums of squares) and 8 (fractional designs).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy import stats

from planter.audit.registry import Inputs, formula
from planter.kernels import Array


@formula("level mean")
def level_mean(inputs: Inputs) -> float:
    """Mean response of the runs at one level of a factor."""
    return float(_means(inputs, inputs["factor"])[inputs["level"] - 1])


@formula("range of level means")
def level_range(inputs: Inputs) -> float:
    """Largest less least of a factor's level means: its influence in range analysis."""
    return float(np.ptp(_means(inputs, inputs["factor"])))


@formula("printed difference")
def printed_difference(inputs: Inputs) -> float:
    """Difference of two printed numbers, in size."""
    return abs(float(inputs["minuend"]) - float(inputs["subtrahend"]))


@formula("sum of squares")
def sum_of_squares(inputs: Inputs) -> float:
    """Sum of squares of a factor, of the error (the blank column) or of all runs [square of the response's unit]."""
    source = inputs["source"]
    if source == "total":
        runs = _runs(inputs)
        return float(((runs - runs.mean()) ** 2).sum())
    means = _means(inputs, source)
    per_level = len(_runs(inputs)) / len(means)
    return float(per_level * ((means - means.mean()) ** 2).sum())


@formula("degrees of freedom")
def degrees_of_freedom(inputs: Inputs) -> float:
    """Levels less one, or runs less one for the total."""
    source = inputs["source"]
    return float((len(_runs(inputs)) if source == "total" else len(_means(inputs, source))) - 1)


@formula("mean square")
def mean_square(inputs: Inputs) -> float:
    """Sum of squares over its degrees of freedom."""
    return sum_of_squares(inputs) / degrees_of_freedom(inputs)


@formula("variance ratio")
def variance_ratio(inputs: Inputs) -> float:
    """F: mean square of a factor over that of the error, from unrounded sums."""
    return mean_square(inputs) / mean_square(_error(inputs))


@formula("probability")
def probability(inputs: Inputs) -> float:
    """Chance of a variance ratio at least as large if the factor has no effect."""
    freedom, rest = degrees_of_freedom(inputs), degrees_of_freedom(_error(inputs))
    return float(stats.f.sf(variance_ratio(inputs), freedom, rest))


@formula("reduction")
def reduction(inputs: Inputs) -> float:
    """Reduction from one printed value to another [%]."""
    before, after = float(inputs["before"]), float(inputs["after"])
    return 100 * (before - after) / before


@formula("place in the order of influence")
def place(inputs: Inputs) -> float:
    """Place of a factor when the factors are put in the order of their ranges of level means, the largest first."""
    ranges = [float(np.ptp(_means(inputs, name))) for name in inputs["factors"]]
    own = ranges[inputs["factors"].index(inputs["factor"])]
    return 1.0 + sum(other > own for other in ranges)


@formula("best level by level means")
def best_level(inputs: Inputs) -> float:
    """Level of a factor whose mean response is least in size."""
    return 1.0 + float(np.argmin(abs(_means(inputs, inputs["factor"]))))


@formula("best level by prediction")
def best_predicted_level(inputs: Inputs) -> float:
    """Level of a factor where the sum of the sizes of some predicted responses is least, over all combinations."""
    best = min(_combinations(inputs), key=lambda levels: sum(abs(_predicted(inputs, name, levels))
                                                             for name in inputs["responses"]))  # fmt: skip
    return float(best[inputs["factors"].index(inputs["factor"])])


@formula("excess of a predicted response")
def excess(inputs: Inputs) -> float:
    """Size of a predicted response at some levels less its size at others."""
    own, other = (_predicted(inputs, inputs["response"], inputs[name]) for name in ("levels", "against"))
    return abs(own) - abs(other)


@formula("chance that two means differ so")
def welch(inputs: Inputs) -> float:
    """Two-sided chance of a difference of two means at least as large if there is none, from printed mean, SD, count.

    Welch, Biometrika 34, 1947.
    """
    (first, first_sd), (second, second_sd) = inputs["first"], inputs["second"]
    runs = inputs["repeats"]
    found = stats.ttest_ind_from_stats(first, first_sd, runs, second, second_sd, runs, equal_var=False)
    return float(found.pvalue)


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


def _runs(inputs: Inputs) -> Array:
    return np.asarray(inputs[inputs["response"]], dtype=float)


def _means(inputs: Inputs, column: str) -> Array:
    levels, runs = np.asarray(inputs[f"column_{column}"]), _runs(inputs)
    return np.array([runs[levels == level].mean() for level in np.unique(levels)])


def _combinations(inputs: Inputs) -> Iterator[tuple[int, ...]]:
    return itertools.product(*(sorted(set(inputs[f"column_{name}"])) for name in inputs["factors"]))


def _predicted(inputs: Inputs, response: str, levels: Sequence[int]) -> float:
    runs = np.asarray(inputs[response], dtype=float)
    columns = [np.asarray(inputs[f"column_{name}"]) for name in inputs["factors"]]
    effects = (runs[column == level].mean() - runs.mean() for column, level in zip(columns, levels, strict=True))
    return float(runs.mean() + sum(effects))


def _error(inputs: Inputs) -> Inputs:
    names = ("response", inputs["response"], "column_error")
    return Inputs({name: inputs[name] for name in names} | {"source": "error"}, {}, {})
