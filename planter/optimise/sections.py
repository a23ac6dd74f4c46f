"""Tables of input files that say how to search."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from planter.files.fields import FileSection, Probability, Share, Whole


class GeneticAlgorithm(FileSection):
    """Settings of the genetic algorithm."""

    individuals: Annotated[Whole, Field(ge=4, le=10_000)]
    generations: Annotated[Whole, Field(ge=1, le=100_000)]
    bits_per_variable: Annotated[Whole, Field(ge=2, le=52)]
    selection_ratio: Share
    crossover_probability: Probability
    mutation_probability: Probability


DEFAULT_GENETIC = GeneticAlgorithm(
    individuals=40,
    generations=200,
    bits_per_variable=20,
    selection_ratio=0.8,
    crossover_probability=0.75,
    mutation_probability=0.01,
)
"""Settings for a file that has none."""
