"""The genetic algorithm: a binary code, tournaments, single-point crossover, bit flips and elitist reinsertion.

Each independent parameter is a binary number of `bits_per_variable` digits over its box. A generation draws
`selection_ratio` times the population as offspring, by binary tournament, single-point crossover and bit flips; they
replace all but the best individuals, which stay (elitist reinsertion). What Wang et al. (2017, 3.4) give are the
settings; the tournament, the single point and the plain binary code are our reading. The operators are textbook ones
(Goldberg 1989, Genetic Algorithms in Search, Optimization, and Machine Learning).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from planter.kernels import Array
from planter.optimise.problem import Problem
from planter.progress import Listener, ProgressPhase

Bits = NDArray[np.bool_]


class Settings(Protocol):
    """Size of the population, number of generations, digits of a parameter, shares and probabilities."""

    @property
    def individuals(self) -> int: ...
    @property
    def generations(self) -> int: ...
    @property
    def bits_per_variable(self) -> int: ...
    @property
    def selection_ratio(self) -> float: ...
    @property
    def crossover_probability(self) -> float: ...
    @property
    def mutation_probability(self) -> float: ...


@dataclass(frozen=True)
class Individual:
    """A point u (p,) of the last population and its objective."""

    u: Array
    objective: float


def search(problem: Problem, settings: Settings, seed: int, progress: Listener | None = None) -> list[Individual]:
    """Return the last population, best first. The same seed gives the same population, bit by bit.

    The best individual so far is in `problem.best` at any time, also after KeyboardInterrupt.
    """
    random = np.random.default_rng(seed)
    length = settings.bits_per_variable
    offspring = max(1, round(settings.selection_ratio * settings.individuals))
    phase = ProgressPhase("ga", "generation", settings.generations, progress)
    problem.heard = phase.report_if_slow
    chromosomes = random.random((settings.individuals, len(problem.independent) * length)) < 0.5
    merits = _evaluate(problem, chromosomes, length)
    phase.report(1, best=problem.least)
    for generation in range(2, settings.generations + 1):
        children = breed(random, chromosomes, merits, offspring, settings)
        elite = np.argsort(merits, kind="stable")[: settings.individuals - offspring]
        chromosomes = np.vstack([chromosomes[elite], children])
        merits = np.concatenate([merits[elite], _evaluate(problem, children, length)])
        phase.report(generation, best=problem.least)
    points = decode(problem, chromosomes, length)
    individuals = [Individual(u, float(merit)) for u, merit in zip(points, merits, strict=True)]
    return sorted(individuals, key=lambda individual: individual.objective)


def breed(random: np.random.Generator, chromosomes: Bits, merits: Array, count: int, settings: Settings) -> Bits:
    """Return chromosomes (count, bits) of the offspring of a population (n, bits) with merits (n,) to be minimised.

    Every parent is the better of two individuals drawn at random. Two parents exchange what follows a random digit,
    with the probability of crossover; then every digit flips with the probability of mutation.
    """
    pairs = (count + 1) // 2
    rivals = random.integers(len(chromosomes), size=(2, pairs, 2))
    winners = np.where(merits[rivals[..., 1]] < merits[rivals[..., 0]], rivals[..., 1], rivals[..., 0])
    first, second = chromosomes[winners[0]], chromosomes[winners[1]]
    bits = chromosomes.shape[1]
    cuts = random.integers(1, bits, size=(pairs, 1))
    crosses = random.random((pairs, 1)) < settings.crossover_probability
    exchanged = crosses & (np.arange(bits) >= cuts)
    children = np.vstack([np.where(exchanged, second, first), np.where(exchanged, first, second)])[:count]
    return children ^ (random.random(children.shape) < settings.mutation_probability)


def _evaluate(problem: Problem, chromosomes: Bits, length: int) -> Array:
    """Return the merits (n,) of chromosomes (n, independent * length)."""
    return np.array([problem.merit(u) for u in decode(problem, chromosomes, length)])


def decode(problem: Problem, bits: Bits, length: int) -> list[Array]:
    """Points u (p,) of chromosomes (n, independent * length): each gene a binary number, its highest digit first.

    They are taken onto the equations, if there are any, which no binary number would meet.
    """
    genes = bits.astype(float).reshape(len(bits), len(problem.independent), length)
    values = genes @ (2.0 ** np.arange(length - 1, -1, -1)) / (2.0**length - 1)
    return [problem.onto(problem.within(v)) for v in values]


def distinct(individuals: list[Individual], count: int, apart: float) -> list[Individual]:
    """The best individuals of which no two are closer than `apart` units of the box in every coordinate."""
    chosen: list[Individual] = []
    for individual in individuals:
        if len(chosen) < count and all(np.abs(individual.u - other.u).max() > apart for other in chosen):
            chosen.append(individual)
    return chosen
