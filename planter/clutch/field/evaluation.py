"""A field test evaluated: everything that is computed from it, under the keys of the command's result."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from planter.clutch.field import comparison, goals, trial
from planter.clutch.field.analysis import Effects, Model, first_least, is_orthogonal, range_analysis
from planter.clutch.field.comparison import Sample
from planter.clutch.field.goals import Goal
from planter.clutch.field.trial import Columns, Trial
from planter.clutch.results.field import Effect, FieldTest, Level, Levels, Means, Named, Predicted, Total
from planter.files import examples

if TYPE_CHECKING:
    from planter.kernels import Array

PAPER, PAPER_COMPARISON = "shi2021-field", "shi2021-comparison"
LISTED = 20_000
"""Combinations of levels that are listed at most."""
SEARCHED = 2_000_000
"""Combinations of levels among which the best is looked for at most."""


@dataclass(frozen=True)
class Evaluation:
    """The trial, its effects and goals per response, the samples compared, and the result as the command gives it."""

    trial: Trial
    effects: dict[str, Effects]
    goals: dict[str, Goal]
    samples: tuple[Sample, ...]
    result: FieldTest


def evaluate(
    source: str = PAPER,
    columns: Columns | None = None,
    compared: str | None = None,
    wanted: Mapping[str, Goal] | None = None,
) -> Evaluation:
    """Evaluates the field test in a CSV file, or the built-in one of that name, and compares clutches.

    `compared` is the CSV file, or built-in, of the clutches' summary statistics; the paper's own runs bring theirs.
    `wanted` are the goals of the responses; the paper's own are lags, for which the default is nearest to zero.

    Raises InputError for data that cannot be evaluated, and for responses without a goal.
    """
    read = trial.read(examples.text(source, "clutch", ".csv"), source, columns)
    names = [response.name for response in read.responses]
    own = dict.fromkeys(names, goals.NEAREST_ZERO) if source == PAPER else {}
    chosen = {**own, **(wanted or {})}
    goals.check(chosen, names, source)
    compared = PAPER_COMPARISON if compared is None and source == PAPER else compared
    samples = comparison.read(examples.text(compared, "clutch", ".csv"), compared) if compared else []
    return evaluated(read, samples, chosen)


def evaluated(read: Trial, samples: Sequence[Sample] = (), wanted: Mapping[str, Goal] | None = None) -> Evaluation:
    """Evaluates a field test that is in hand; without goals nothing is called the best."""
    chosen = {r.name: wanted[r.name] for r in read.responses} if wanted else {}
    model = Model(read)
    orthogonal = is_orthogonal(read.factors)
    effects = {response.name: model.effects(response) for response in read.responses}
    anova = {response.name: model.anova(response) for response in read.responses}
    combinations = math.prod(len(factor.levels) for factor in read.factors)
    main, others = comparison.compare(samples)
    ranged = _ranges(read, chosen) if orthogonal else Ranges()
    result = FieldTest(
        source=read.source,
        runs=read.runs,
        factors={
            f.name: Levels(f.label, list(f.levels), None if f.values is None else list(f.values)) for f in read.factors
        },
        responses={response.name: Named(response.label) for response in read.responses},
        blank=[blank.name for blank in read.blanks],
        orthogonal=orthogonal,
        sums_of_squares="types I, II and III agree" if orthogonal else "type II",
        goals={name: str(goal) for name, goal in chosen.items()},
        range=ranged.means,
        order=ranged.order,
        range_best=ranged.best,
        anova=anova,
        best=_best(read, effects, chosen) if chosen and combinations <= SEARCHED else None,
        prediction=list(_predictions(read, effects)) if combinations <= LISTED else [],
        comparison=main,
        other_comparisons=others,
        warnings=[
            *_warnings(read, model, anova, orthogonal, combinations),
            *(_ties(effects, chosen) if chosen and combinations <= SEARCHED else ()),
        ],
    )
    return Evaluation(read, effects, chosen, tuple(samples), result)


class Ranges(NamedTuple):
    """Range analysis, the order of the factors' influence, and the level whose mean is best of each factor."""

    means: dict[str, dict[str, Means]] | None = None
    order: dict[str, list[str]] | None = None
    best: dict[str, list[Level]] | None = None


def _ranges(read: Trial, chosen: Mapping[str, Goal]) -> Ranges:
    """Of an orthogonal design; there is an order only among factors of as many levels: the range grows with them."""
    found = {response.name: range_analysis(read, response) for response in read.responses}
    comparable = len({len(factor.levels) for factor in read.factors}) == 1
    order = {name: sorted(of, key=lambda factor: -of[factor].R) for name, of in found.items()}
    best = {
        name: [f.levels[first_least(goal.loss(np.array(found[name][f.name].k)))] for f in read.factors]
        for name, goal in chosen.items()
    }
    return Ranges(found, order if comparable else None, best or None)


def _losses(effects: Mapping[str, Effects], chosen: Mapping[str, Goal]) -> dict[str, Array]:
    """How far every combination's prediction is from what is wanted, by response."""
    return {name: goal.loss(effects[name].predicted()) for name, goal in chosen.items()}


def _best(read: Trial, effects: dict[str, Effects], chosen: Mapping[str, Goal]) -> dict[str, list[Level]]:
    """Levels whose prediction is best by each response's goal, and by the mean of the ranks over all responses."""
    losses = _losses(effects, chosen)
    first = {name: first_least(loss) for name, loss in losses.items()}
    first["both"] = int(goals.order(list(losses.values()))[0])
    shape = [len(factor.levels) for factor in read.factors]
    places = {name: np.unravel_index(index, shape) for name, index in first.items()}
    return {
        name: [f.levels[int(i)] for f, i in zip(read.factors, place, strict=True)] for name, place in places.items()
    }


def _ties(effects: Mapping[str, Effects], chosen: Mapping[str, Goal]) -> Iterator[str]:
    """That several combinations are equally good by all goals together, where the goals are at odds."""
    equal = goals.equally_good(list(_losses(effects, chosen).values()))
    if equal > 1:
        yield (
            f"{equal} combinations of levels share the best mean rank: of these the one is named whose worst rank is "
            f"least, and of several such the first"
        )


def _predictions(read: Trial, effects: dict[str, Effects]) -> Iterator[Predicted]:
    predicted = [effect.predicted().tolist() for effect in effects.values()]
    for levels, *values in zip(itertools.product(*(f.levels for f in read.factors)), *predicted, strict=True):
        yield Predicted(list(levels), dict(zip(effects, values, strict=True)))


def _warnings(
    read: Trial, model: Model, anova: Mapping[str, Mapping[str, Total]], orthogonal: bool, combinations: int
) -> Iterator[str]:
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
