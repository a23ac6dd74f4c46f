"""Evaluation of a field test: goals of its responses, effects, best levels."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from planter.clutch.field import analysis, trial
from planter.clutch.field.analysis import (
    Effects,
    MainEffectsModel,
    Sample,
    index_of_minimum,
    is_orthogonal,
    range_analysis,
)
from planter.clutch.field.trial import FieldColumns, Trial
from planter.clutch.results import (
    Effect,
    FactorLevels,
    FieldTest,
    Level,
    LevelMeans,
    Predicted,
    ResponseLabel,
    Total,
)
from planter.errors import InputError
from planter.files import csv_rows, examples

if TYPE_CHECKING:
    from planter.kernels import Array

ALLOWED = "larger, smaller, zero, or a number for a target value"
_SAME = 1e-12
"""Share of the largest loss by which losses may differ that count as equal."""


@dataclass(frozen=True)
class ResponseGoal:
    """The goal of a response: larger, smaller, or near `value`."""

    sense: Literal["larger", "smaller", "near"]
    value: float = 0.0

    @classmethod
    def parse(cls, text: str) -> ResponseGoal:
        """Return the goal of a text as users write it, or as results print it.

        Raises InputError for anything else.

        >>> [str(ResponseGoal.parse(text)) for text in ("larger", "zero", "12.5", "target 3")]
        ['larger', 'nearest 0', 'target 12.5', 'target 3']
        """
        plain = text.strip().lower()
        if plain == "larger":
            return cls("larger")
        if plain == "smaller":
            return cls("smaller")
        value = "0" if plain in ("zero", "nearest 0") else plain.removeprefix("target").strip()
        if not csv_rows.is_finite_number(value) or abs(float(value)) > csv_rows.LARGEST:
            raise InputError(f"goal {csv_rows.shorten_text(text)}: must be {ALLOWED}")
        return cls("near", float(value))

    def __str__(self) -> str:
        if self.sense != "near":
            return self.sense
        return f"target {self.value:.10g}" if self.value else "nearest 0"

    def loss(self, values: Array) -> Array:
        """Return the distances of values (n,) from the goal: less is better."""
        signs = {"larger": -1.0, "smaller": 1.0}
        return np.abs(values - self.value) if self.sense == "near" else signs[self.sense] * values


NEAREST_ZERO = ResponseGoal("near", 0.0)


def parse_goals(texts: Sequence[str]) -> dict[str, ResponseGoal]:
    """Return goals by response from texts NAME=GOAL.

    Raises InputError for other texts, or two goals of a response.
    """
    goals: dict[str, ResponseGoal] = {}
    for text in texts:
        name, equals, goal = (part.strip() for part in text.rpartition("="))
        if not equals or not name:
            raise InputError(f"--goal {text}: must be NAME=GOAL, a goal being {ALLOWED}")
        if name in goals:
            raise InputError(f"--goal {text}: {name} has a goal already, but it must have one")
        try:
            goals[name] = ResponseGoal.parse(goal)
        except InputError as error:
            raise InputError(f"--goal {text}: {error}") from None
    return goals


def check_goals(goals: Mapping[str, ResponseGoal], responses: Sequence[str], source: str) -> None:
    """Raise InputError unless every response has a goal, and every goal a response."""
    for name, goal in goals.items():
        if name not in responses:
            raise InputError(
                f"--goal {name}={goal}: {source} has no such response, it must be one of "
                f"{', '.join(responses)}"
            )
    missing = [name for name in responses if name not in goals]
    if missing:
        options = " ".join(f"--goal {name}=larger" for name in missing)
        raise InputError(
            f"{source}: nothing says what is good of {' and '.join(missing)}: each response must "
            f"have its goal, as in "
            f"{options} ({ALLOWED})"
        )


def rank_losses(losses: Array) -> Array:
    """Return ranks (n,) of losses from 1 for the smallest; equal losses, up to rounding, share
    their mean rank.
    """
    step = _SAME * float(np.max(np.abs(losses)))
    return np.asarray(scipy.stats.rankdata(np.round(losses / step) if step else losses))


def order_combinations(losses: Sequence[Array]) -> NDArray[np.intp]:
    """Return indices (n,) of combinations, the best first: by mean rank over all responses, then by
    worst rank.
    """
    rank_table = np.array([rank_losses(loss) for loss in losses])
    return np.lexsort((rank_table.max(axis=0), rank_table.mean(axis=0)))


def count_ties(losses: Sequence[Array]) -> int:
    """Return the number of combinations that share the best mean rank."""
    means = np.mean([rank_losses(loss) for loss in losses], axis=0)
    return int(np.sum(means <= means.min() + 1e-9))


PAPER, PAPER_COMPARISON = "shi2021-field", "shi2021-comparison"
LISTED = 20_000
"""Combinations of levels that are listed at most."""
SEARCHED = 2_000_000
"""Combinations of levels among which the best is looked for at most."""


@dataclass(frozen=True)
class FieldEvaluation:
    """The trial, its effects and goals per response, the samples compared, and the result as the
    command gives it.
    """

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
    """Evaluate the field test in a CSV file, or the built-in one of that name, and compares
    clutches.

    `compared` is the CSV file, or built-in, of the clutches' summary statistics; the paper's own
    runs bring theirs. `requested` are the goals of the responses; the paper's own are lags, for
    which the default is nearest to zero.

    Raises InputError for data that cannot be evaluated, and for responses without a goal.
    """
    read = trial.read_trial(examples.read_source(source, "clutch", ".csv"), source, columns)
    names = [response.name for response in read.responses]
    defaults = dict.fromkeys(names, NEAREST_ZERO) if source == PAPER else {}
    assigned = {**defaults, **(requested or {})}
    check_goals(assigned, names, source)
    compared = PAPER_COMPARISON if compared is None and source == PAPER else compared
    samples = (
        analysis.read_samples(examples.read_source(compared, "clutch", ".csv"), compared)
        if compared
        else []
    )
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
    main, remaining = analysis.compare_samples(samples)
    ranged = _ranges(test, assigned) if orthogonal else Ranges()
    result = FieldTest(
        source=test.source,
        runs=test.runs,
        factors={
            f.name: FactorLevels(
                f.label, list(f.levels), None if f.values is None else list(f.values)
            )
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
    """Range analysis, the order of the factors' influence, and the level whose mean is best of each
    factor.
    """

    means: dict[str, dict[str, LevelMeans]] | None = None
    order: dict[str, list[str]] | None = None
    best: dict[str, list[Level]] | None = None


def _ranges(test: Trial, assigned: Mapping[str, ResponseGoal]) -> Ranges:
    """Return the ranges of an orthogonal design; factors have an order only if all have as many
    levels.
    """
    means = {response.name: range_analysis(test, response) for response in test.responses}
    comparable = len({len(factor.levels) for factor in test.factors}) == 1
    order = {
        name: sorted(factors, key=lambda factor: -factors[factor].R)
        for name, factors in means.items()
    }
    best = {
        name: [
            f.levels[index_of_minimum(goal.loss(np.array(means[name][f.name].k)))]
            for f in test.factors
        ]
        for name, goal in assigned.items()
    }
    return Ranges(means, order if comparable else None, best or None)


def _losses(
    effects: Mapping[str, Effects], assigned: Mapping[str, ResponseGoal]
) -> dict[str, Array]:
    """Return the distance of every combination's prediction from the goal, by response."""
    return {name: goal.loss(effects[name].predict()) for name, goal in assigned.items()}


def _best(
    test: Trial, effects: dict[str, Effects], assigned: Mapping[str, ResponseGoal]
) -> dict[str, list[Level]]:
    """Levels whose prediction is best by each response's goal, and by the mean of the ranks over
    all responses.
    """
    losses = _losses(effects, assigned)
    first = {name: index_of_minimum(loss) for name, loss in losses.items()}
    first["both"] = int(order_combinations(list(losses.values()))[0])
    shape = [len(factor.levels) for factor in test.factors]
    places = {name: np.unravel_index(index, shape) for name, index in first.items()}
    return {
        name: [f.levels[int(i)] for f, i in zip(test.factors, place, strict=True)]
        for name, place in places.items()
    }


def _ties(effects: Mapping[str, Effects], assigned: Mapping[str, ResponseGoal]) -> Iterator[str]:
    """That several combinations are equally good by all goals together, where the goals are at
    odds.
    """
    equal = count_ties(list(_losses(effects, assigned).values()))
    if equal > 1:
        yield (
            f"{equal} combinations of levels share the best mean rank: the result names the first "
            f"of those whose worst rank is smallest"
        )


def _predictions(test: Trial, effects: dict[str, Effects]) -> Iterator[Predicted]:
    predicted = [effect.predict().tolist() for effect in effects.values()]
    for levels, *values in zip(
        itertools.product(*(f.levels for f in test.factors)), *predicted, strict=True
    ):
        yield Predicted(list(levels), dict(zip(effects, values, strict=True)))


def _warnings(
    test: Trial,
    model: MainEffectsModel,
    anova: Mapping[str, Mapping[str, Total]],
    orthogonal: bool,
    combinations: int,
) -> Iterator[str]:
    if not orthogonal:
        yield (
            "the design is not orthogonal, so there is no range analysis, and sums of squares are "
            "of type II (each "
            "factor over all others), which do not add up to the total"
        )
    blanks = [b.name for b in test.blanks if orthogonal and not is_orthogonal([*test.factors, b])]
    if blanks:
        yield (
            f"effects of factors show in the blank column {' and '.join(blanks)}, which is not "
            f"orthogonal to them"
        )
    if model.freedom == 0:
        yield (
            "the effects use up all degrees of freedom: without any left for the error there is "
            "no F and no p"
        )
    else:
        exact = [
            name
            for name, table in anova.items()
            if any(isinstance(s, Effect) and s.F is None for s in table.values())
        ]
        if exact:
            yield (
                f"main effects explain {' and '.join(exact)} to the last digit: without any "
                f"error there is no F, no p"
            )
    if combinations > LISTED:
        yield (
            f"of {combinations} combinations of levels none is listed, and the best is "
            f"{'looked for all the same' if combinations <= SEARCHED else 'not looked for'}"
        )
