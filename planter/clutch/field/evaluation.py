"""A field test evaluated: everything that is computed from it, under the keys of the command's result."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from planter.clutch.field import comparison, goals, trial
from planter.clutch.field.analysis import Effects, MainEffectsModel, index_of_minimum, is_orthogonal, range_analysis
from planter.clutch.field.comparison import Sample
from planter.clutch.field.goals import ResponseGoal
from planter.clutch.field.trial import FieldColumns, Trial
from planter.clutch.results.field import (
    Effect,
    FactorLevels,
    FieldTest,
    Level,
    LevelMeans,
    Predicted,
    ResponseLabel,
    Total,
)
from planter.files import examples

if TYPE_CHECKING:
    from planter.kernels import Array

PAPER, PAPER_COMPARISON = "shi2021-field", "shi2021-comparison"
LISTED = 20_000
"""Combinations of levels that are listed at most."""
SEARCHED = 2_000_000
"""Combinations of levels among which the best is looked for at most."""


@dataclass(frozen=True)
class FieldEvaluation:
    """The trial, its effects and goals per response, the samples compared, and the result as the command gives it."""

    trial: Trial
    effects: dict[str, Effects]
    goals: dict[str, ResponseGoal]
    samples: tuple[Sample, ...]
    result: FieldTest


def evaluate_field(
    source: str = PAPER,
    columns: FieldColumns | None = None,
    compared: str | None = None,
    requested: Mapping[str, ResponseGoal] | None = None,
) -> FieldEvaluation:
    """Evaluate the field test in a CSV file, or the built-in one of that name, and compares clutches.

    `compared` is the CSV file, or built-in, of the clutches' summary statistics; the paper's own runs bring theirs.
    `requested` are the goals of the responses; the paper's own are lags, for which the default is nearest to zero.

    Raises InputError for data that cannot be evaluated, and for responses without a goal.
    """
    read = trial.read_trial(examples.text(source, "clutch", ".csv"), source, columns)
    names = [response.name for response in read.responses]
    defaults = dict.fromkeys(names, goals.NEAREST_ZERO) if source == PAPER else {}
    assigned = {**defaults, **(requested or {})}
    goals.check_goals(assigned, names, source)
    compared = PAPER_COMPARISON if compared is None and source == PAPER else compared
    samples = comparison.read_samples(examples.text(compared, "clutch", ".csv"), compared) if compared else []
    return evaluate_trial(read, samples, assigned)


def evaluate_trial(
    test: Trial, samples: Sequence[Sample] = (), requested: Mapping[str, ResponseGoal] | None = None
) -> FieldEvaluation:
    """Evaluate a field test; without goals the result has no best levels."""
    assigned = {r.name: requested[r.name] for r in test.responses} if requested else {}
    model = MainEffectsModel(test)
    orthogonal = is_orthogonal(test.factors)
    effects = {response.name: model.effects(response) for response in test.responses}
    anova = {response.name: model.anova(response) for response in test.responses}
    combinations = math.prod(len(factor.levels) for factor in test.factors)
    main, remaining = comparison.compare_samples(samples)
    ranged = _ranges(test, assigned) if orthogonal else Ranges()
    result = FieldTest(
        source=test.source,
        runs=test.runs,
        factors={
            f.name: FactorLevels(f.label, list(f.levels), None if f.values is None else list(f.values))
            for f in test.factors
        },
        responses={response.name: ResponseLabel(response.label) for response in test.responses},
        blank=[blank.name for blank in test.blanks],
        orthogonal=orthogonal,
        sums_of_squares="types I, II and III agree" if orthogonal else "type II",
        goals={name: str(goal) for name, goal in assigned.items()},
        range=ranged.means,
        order=ranged.order,
        range_best=ranged.best,
        anova=anova,
        best=_best(test, effects, assigned) if assigned and combinations <= SEARCHED else None,
        prediction=list(_predictions(test, effects)) if combinations <= LISTED else [],
        comparison=main,
        other_comparisons=remaining,
        warnings=[
            *_warnings(test, model, anova, orthogonal, combinations),
            *(_ties(effects, assigned) if assigned and combinations <= SEARCHED else ()),
        ],
    )
    return FieldEvaluation(test, effects, assigned, tuple(samples), result)


class Ranges(NamedTuple):
    """Range analysis, the order of the factors' influence, and the level whose mean is best of each factor."""

    means: dict[str, dict[str, LevelMeans]] | None = None
    order: dict[str, list[str]] | None = None
    best: dict[str, list[Level]] | None = None


def _ranges(test: Trial, assigned: Mapping[str, ResponseGoal]) -> Ranges:
    """Return the ranges of an orthogonal design; factors have an order only if all have as many levels."""
    means = {response.name: range_analysis(test, response) for response in test.responses}
    comparable = len({len(factor.levels) for factor in test.factors}) == 1
    order = {name: sorted(factors, key=lambda factor: -factors[factor].R) for name, factors in means.items()}
    best = {
        name: [f.levels[index_of_minimum(goal.loss(np.array(means[name][f.name].k)))] for f in test.factors]
        for name, goal in assigned.items()
    }
    return Ranges(means, order if comparable else None, best or None)


def _losses(effects: Mapping[str, Effects], assigned: Mapping[str, ResponseGoal]) -> dict[str, Array]:
    """Return the distance of every combination's prediction from the goal, by response."""
    return {name: goal.loss(effects[name].predict()) for name, goal in assigned.items()}


def _best(test: Trial, effects: dict[str, Effects], assigned: Mapping[str, ResponseGoal]) -> dict[str, list[Level]]:
    """Levels whose prediction is best by each response's goal, and by the mean of the ranks over all responses."""
    losses = _losses(effects, assigned)
    first = {name: index_of_minimum(loss) for name, loss in losses.items()}
    first["both"] = int(goals.order_combinations(list(losses.values()))[0])
    shape = [len(factor.levels) for factor in test.factors]
    places = {name: np.unravel_index(index, shape) for name, index in first.items()}
    return {
        name: [f.levels[int(i)] for f, i in zip(test.factors, place, strict=True)] for name, place in places.items()
    }


def _ties(effects: Mapping[str, Effects], assigned: Mapping[str, ResponseGoal]) -> Iterator[str]:
    """That several combinations are equally good by all goals together, where the goals are at odds."""
    equal = goals.count_ties(list(_losses(effects, assigned).values()))
    if equal > 1:
        yield (
            f"{equal} combinations of levels share the best mean rank: the result names the first "
            f"of those whose worst rank is smallest"
        )


def _predictions(test: Trial, effects: dict[str, Effects]) -> Iterator[Predicted]:
    predicted = [effect.predict().tolist() for effect in effects.values()]
    for levels, *values in zip(itertools.product(*(f.levels for f in test.factors)), *predicted, strict=True):
        yield Predicted(list(levels), dict(zip(effects, values, strict=True)))


def _warnings(
    test: Trial, model: MainEffectsModel, anova: Mapping[str, Mapping[str, Total]], orthogonal: bool, combinations: int
) -> Iterator[str]:
    if not orthogonal:
        yield (
            "the design is not orthogonal, so there is no range analysis, and sums of squares are of type II (each "
            "factor over all others), which do not add up to the total"
        )
    blanks = [b.name for b in test.blanks if orthogonal and not is_orthogonal([*test.factors, b])]
    if blanks:
        yield f"effects of factors show in the blank column {' and '.join(blanks)}, which is not orthogonal to them"
    if model.freedom == 0:
        yield "the effects use up all degrees of freedom: without any left for the error there is no F and no p"
    else:
        exact = [
            name for name, table in anova.items() if any(isinstance(s, Effect) and s.F is None for s in table.values())
        ]
        if exact:
            yield f"main effects explain {' and '.join(exact)} to the last digit: without any error there is no F, no p"
    if combinations > LISTED:
        yield (
            f"of {combinations} combinations of levels none is listed, and the best is "
            f"{'looked for all the same' if combinations <= SEARCHED else 'not looked for'}"
        )
