"""Tables of input files that say how to search."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from planter.files.fields import FileSection, Probability, Share, Whole


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


DEFAULT_GENETIC = GeneticAlgorithm(
    individuals=40,
    generations=200,
    bits_per_variable=20,
    selection_ratio=0.8,
    crossover_probability=0.75,
    mutation_probability=0.01,
)
"""Settings for a file that has none."""
