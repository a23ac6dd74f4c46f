"""Tables of machine files that say how to search, for every kind of machine: limits on measures of a
cycle, and settings of the genetic algorithm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field

from planter.engine.measures import Limit, parse_limit
from planter.files.fields import FileSection, Line, Probability, Share, Whole

HOLD = "requirements.hold"
"""Path of the limits in files."""
LEAST = "objective.least"
"""Path of the sum of measures in files."""
HOLD_MEANING = (
    "limits on measures of the cycle, such as 'abs F_Ax <= 300 N': every search satisfies them"
)
Holds = Annotated[list[Line], Field(min_length=1, description=HOLD_MEANING)]


class LimitsSection(FileSection):
    """Limits on measures of a cycle."""

    hold: Holds


def parse_holds(section: Any, source: str) -> tuple[Limit, ...]:
    """Return the limits of a file's [requirements], none if it has none.

    Raises InputError if one cannot be parsed.
    """
    texts: Sequence[str] = (None if section is None else section.hold) or ()
    return tuple(
        parse_limit(text, f"{source}: {HOLD}[{index}] =") for index, text in enumerate(texts)
    )


def with_whole_limits(
    table: Mapping[str, Any], limits: Sequence[Limit], source: str
) -> dict[str, Any]:
    """Return the table of a file with whole paths of the curves in its limits, for a file in any
    folder.
    """
    if not limits:
        return dict(table)
    texts = [
        str(replace(limit, measure=limit.measure.with_whole_paths(source))) for limit in limits
    ]
    return {**table, "requirements": {**table["requirements"], "hold": texts}}


class GeneticAlgorithm(FileSection):
    """Settings of the genetic algorithm."""

    individuals: Annotated[Whole, Field(ge=4, le=10_000)]
    """size of the population"""
    generations: Annotated[Whole, Field(ge=1, le=100_000)]
    """number of generations"""
    bits_per_variable: Annotated[Whole, Field(ge=2, le=52)]
    """bits of the code of a variable"""
    selection_ratio: Share
    """share of the population that is selected as parents"""
    crossover_probability: Probability
    """probability that a pair of parents is crossed"""
    mutation_probability: Probability
    """probability that a bit is flipped"""
    selection: Literal["tournament", "ranking"] | None = None
    """how parents are chosen: "tournament" of two, the default, or "ranking", linear ranks with
    stochastic universal sampling"""


DEFAULT_GENETIC = GeneticAlgorithm(
    individuals=40,
    generations=200,
    bits_per_variable=20,
    selection_ratio=0.8,
    crossover_probability=0.75,
    mutation_probability=0.01,
)
"""Settings for a file that has none."""
