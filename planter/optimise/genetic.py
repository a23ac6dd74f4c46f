"""The genetic algorithm, with pymoo's operators.

Each free parameter is a binary number of `bits_per_variable` digits over its box. A generation draws `selection_ratio`
times the population as offspring, by binary tournament, single-point crossover and bit flips; they replace all but the
best individuals, which stay (elitist reinsertion). What Wang et al. (2017, 3.4) give are the settings; the tournament,
the single point and the plain binary code are our reading.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from planter.kernels import Array
from planter.optimise.problem import Problem
from planter.progress import Listener, Phase

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.population import Population


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
    """The last population, best first. The same seed gives the same population, bit by bit.

    The best individual so far is in `problem.best` at any time, also after KeyboardInterrupt.
    """
    algorithm = _algorithm(problem, settings, seed)
    phase = Phase("ga", "generation", settings.generations, progress)
    problem.heard = phase.under_way
    for generation in range(1, settings.generations + 1):
        infills = algorithm.ask()
        points = decode(problem, infills.get("X"), settings.bits_per_variable)
        infills.set("F", np.array([[problem.merit(u)] for u in points]))
        algorithm.tell(infills=infills)
        phase.reached(generation, best=problem.least)
    return _individuals(problem, algorithm.pop, settings.bits_per_variable)


def decode(problem: Problem, bits: Array, length: int) -> list[Array]:
    """Points u (p,) of chromosomes (n, free * length): each gene a binary number, its highest digit first.

    They are taken onto the equations, if there are any, which no binary number would meet.
    """
    genes = bits.astype(float).reshape(len(bits), len(problem.free), length)
    values = genes @ (2.0 ** np.arange(length - 1, -1, -1)) / (2.0**length - 1)
    return [problem.onto(problem.within(v)) for v in values]


def distinct(individuals: list[Individual], count: int, apart: float) -> list[Individual]:
    """The best individuals of which no two are closer than `apart` units of the box in every coordinate."""
    chosen: list[Individual] = []
    for one in individuals:
        if len(chosen) < count and all(np.abs(one.u - other.u).max() > apart for other in chosen):
            chosen.append(one)
    return chosen


def _individuals(problem: Problem, population: Population, length: int) -> list[Individual]:
    points = decode(problem, population.get("X"), length)
    found = [Individual(u, float(f)) for u, f in zip(points, population.get("F")[:, 0], strict=True)]
    return sorted(found, key=lambda individual: individual.objective)


def _algorithm(problem: Problem, settings: Settings, seed: int) -> Algorithm:
    """pymoo's algorithm, set up to be asked for individuals and told their objectives."""
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.config import Config
    from pymoo.core.problem import Problem as Search
    from pymoo.operators.crossover.pntx import SinglePointCrossover
    from pymoo.operators.mutation.bitflip import BitflipMutation
    from pymoo.operators.sampling.rnd import BinaryRandomSampling

    Config.warnings["not_compiled"] = False
    offspring = max(1, round(settings.selection_ratio * settings.individuals))
    algorithm = GA(
        pop_size=settings.individuals,
        n_offsprings=offspring,
        sampling=BinaryRandomSampling(),
        crossover=SinglePointCrossover(prob=settings.crossover_probability),
        mutation=BitflipMutation(prob=1.0, prob_var=settings.mutation_probability),
        survival=_reinsertion(settings.individuals - offspring),
        eliminate_duplicates=False,
    )
    bits = len(problem.free) * settings.bits_per_variable
    space = Search(n_var=bits, n_obj=1, xl=0, xu=1, vtype=bool)
    algorithm.setup(space, termination=("n_gen", settings.generations), seed=seed, verbose=False)
    return algorithm


def _reinsertion(elite: int) -> Any:
    """Survival of all offspring and of the `elite` best parents; pymoo merges parents before offspring."""
    from pymoo.algorithms.soo.nonconvex.ga import FitnessSurvival
    from pymoo.core.population import Population

    class Reinsertion(FitnessSurvival):
        def _do(self, problem: Any, pop: Any, n_survive: int | None = None, **rest: Any) -> Any:
            parents, offspring = pop[:n_survive], pop[n_survive:]
            if len(offspring):
                stay = super()._do(problem, parents, n_survive=elite, **rest)
                pop = Population.merge(stay, offspring)
            return super()._do(problem, pop, n_survive=n_survive, **rest)

    return Reinsertion()
