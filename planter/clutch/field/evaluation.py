"""A field test evaluated: everything that is computed from it, under the keys of the command's result."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.clutch.field import comparison, trial
from planter.clutch.field.analysis import Effects, Model, first_least, is_orthogonal, range_analysis
from planter.clutch.field.comparison import Sample
from planter.clutch.field.trial import Columns, Trial
from planter.files import examples

PAPER, PAPER_COMPARISON = "shi2021-field", "shi2021-comparison"
LISTED = 20_000
"""Combinations of levels that are listed at most."""
SEARCHED = 2_000_000
"""Combinations of levels among which the best is looked for at most."""


@dataclass(frozen=True)
class Evaluation:
    """The trial, its effects per response, the samples compared, and the result as the command gives it."""

    trial: Trial
    effects: dict[str, Effects]
    samples: tuple[Sample, ...]
    result: dict[str, Any]


def evaluate(source: str = PAPER, columns: Columns | None = None, compared: str | None = None) -> Evaluation:
    """Evaluates the field test in a CSV file, or the built-in one of that name, and compares clutches.

    `compared` is the CSV file, or built-in, of the clutches' summary statistics; the paper's own runs bring theirs.

    Raises InputError for data that cannot be evaluated.
    """
    read = trial.read(examples.text(source, "clutch", ".csv"), source, columns)
    compared = PAPER_COMPARISON if compared is None and source == PAPER else compared
    samples = comparison.read(examples.text(compared, "clutch", ".csv"), compared) if compared else []
    return of(read, samples)


def of(read: Trial, samples: Sequence[Sample] = ()) -> Evaluation:
    """Evaluates a field test that is in hand."""
    model = Model(read)
    orthogonal = is_orthogonal(read.factors)
    effects = {response.name: model.effects(response) for response in read.responses}
    anova = {response.name: model.anova(response) for response in read.responses}
    combinations = math.prod(len(factor.levels) for factor in read.factors)
    main, others = comparison.compare(samples)
    result = {
        "source": read.source,
        "runs": read.runs,
        "factors": {f.name: {"label": f.label, "levels": list(f.levels), "values": f.values} for f in read.factors},
        "responses": {response.name: {"label": response.label} for response in read.responses},
        "blank": [blank.name for blank in read.blanks],
        "orthogonal": orthogonal,
        "sums_of_squares": "types I, II and III agree" if orthogonal else "type II",
        **_ranges(read, orthogonal),
        "anova": anova,
        "best": _best(read, effects) if combinations <= SEARCHED else None,
        "prediction": list(_predictions(read, effects)) if combinations <= LISTED else [],
        "comparison": main,
        "other_comparisons": others,
        "warnings": list(_warnings(read, model, anova, orthogonal, combinations)),
    }
    return Evaluation(read, effects, tuple(samples), result)


def _ranges(read: Trial, orthogonal: bool) -> dict[str, Any]:
    """Range analysis, the order of the factors' influence, and the level with the mean closest to zero of each factor.

    There is an order only among factors of as many levels: the range grows with them.
    """
    if not orthogonal:
        return {"range": None, "order": None, "range_best": None}
    found = {response.name: range_analysis(read, response) for response in read.responses}
    comparable = len({len(factor.levels) for factor in read.factors}) == 1
    order = {name: sorted(of, key=lambda factor: -of[factor]["R"]) for name, of in found.items()}
    best = {name: [f.levels[first_least(np.abs(of[f.name]["k"]))] for f in read.factors] for name, of in found.items()}
    return {"range": found, "order": order if comparable else None, "range_best": best}


def _best(read: Trial, effects: dict[str, Effects]) -> dict[str, list[trial.Level]]:
    """Levels with the smallest predicted |Y| of each response, and with the smallest sum of them over all responses."""
    sizes = {name: np.abs(effect.predicted()) for name, effect in effects.items()}
    scores = sizes | {"both": np.sum(list(sizes.values()), axis=0)}
    shape = [len(factor.levels) for factor in read.factors]
    places = {name: np.unravel_index(first_least(score), shape) for name, score in scores.items()}
    return {
        name: [f.levels[int(i)] for f, i in zip(read.factors, place, strict=True)] for name, place in places.items()
    }


def _predictions(read: Trial, effects: dict[str, Effects]) -> Iterator[dict[str, Any]]:
    predicted = [effect.predicted().tolist() for effect in effects.values()]
    for levels, *values in zip(itertools.product(*(f.levels for f in read.factors)), *predicted, strict=True):
        yield {"levels": list(levels), **dict(zip(effects, values, strict=True))}


def _warnings(read: Trial, model: Model, anova: dict[str, Any], orthogonal: bool, combinations: int) -> Iterator[str]:
    if not orthogonal:
        yield (
            "the design is not orthogonal, so there is no range analysis, and sums of squares are of type II (each "
            "factor over all others), which do not add up to the total"
        )
    blanks = [b.name for b in read.blanks if orthogonal and not is_orthogonal([*read.factors, b])]
    if blanks:
        yield f"effects of factors show in the blank column {' and '.join(blanks)}, which is not orthogonal to them"
    if model.freedom == 0:
        yield "the effects use up all degrees of freedom: without any left for the error there is no F and no p"
    else:
        exact = [name for name, table in anova.items() if next(iter(table.values()))["F"] is None]
        if exact:
            yield f"main effects explain {' and '.join(exact)} to the last digit: without any error there is no F, no p"
    if combinations > LISTED:
        yield (
            f"of {combinations} combinations of levels none is listed, and the best is "
            f"{'looked for all the same' if combinations <= SEARCHED else 'not looked for'}"
        )
