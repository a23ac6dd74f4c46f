"""Genetic algorithm, local searches from several starts, and their combination.

The genetic algorithm encodes each independent parameter as a binary number of `bits_per_variable`
digits over its box. A generation has `selection_ratio` times the population as offspring, by
selection, single-point crossover and bit flips; these replace all but the best individuals (elitist
reinsertion). Wang et al. (2017, 3.4) publish the settings; the operators are our interpretation.
`selection` names how parents are chosen: by binary tournament, the default (Goldberg 1989, Genetic
Algorithms in Search, Optimization, and Machine Learning), or by linear ranking and stochastic
universal sampling (Baker 1987, Reducing bias and inefficiency in the selection algorithm), which
together with the other three are the usual operators of the toolboxes for MATLAB of the time.

The method `ga` is the genetic algorithm, `ipopt` runs local searches from several starts, and
`hybrid` runs both, adds local searches from the best individuals and returns the best point. With
the same seed, it is never worse than either. `auto` runs the local searches, and the rest of
`hybrid` only where fewer than a third of the starts agree on the optimum.

Under constraints, every method first looks for feasible points from all starts, with no regard to
the objective; where there is none, nothing else is run.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.feasibility import ViolationMinimum
from planter.engine.solvers.local_search import (
    AGREEMENT_TOLERANCE,
    DEFAULT_STARTS,
    Descent,
    LocalMinimum,
    find_minima,
    find_violation_minima,
    list_descents,
    sample_starts,
)
from planter.engine.solvers.problem import BestPoint, ClosestPoint, Problem
from planter.engine.solvers.result import (
    EvaluationCounts,
    NoFeasiblePointError,
    OptimiserResult,
    build_result,
)
from planter.errors import ComputationError
from planter.kernels import Array, Integers
from planter.progress import Listener, ProgressPhase
from planter.report.labels import count_things
from planter.task import AUTO, Means, Task

Bits = NDArray[np.bool_]


Selection = Literal["tournament", "ranking"]
"""How parents are chosen: the better of two drawn at random, or by stochastic universal sampling of
linear ranks.
"""
SELECTIVE_PRESSURE = 2.0
"""Expected number of offspring's parents that the best of a ranked population is, over the mean."""


class GeneticSettings(Protocol):
    """Size of the population, number of generations, digits of a parameter, shares, probabilities,
    and how parents are chosen (None: by tournament).
    """

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
    @property
    def selection(self) -> Selection | None: ...


@dataclass(frozen=True)
class Individual:
    """A point u (p,) of the last population and its objective."""

    u: Array
    objective: float


def search_genetically(
    problem: Problem, settings: GeneticSettings, seed: int, progress: Listener | None = None
) -> list[Individual]:
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
    phase.report(1, best=problem.best_objective)
    for generation in range(2, settings.generations + 1):
        children = breed_offspring(random, chromosomes, merits, offspring, settings)
        elite = np.argsort(merits, kind="stable")[: settings.individuals - offspring]
        chromosomes = np.vstack([chromosomes[elite], children])
        merits = np.concatenate([merits[elite], _evaluate(problem, children, length)])
        phase.report(generation, best=problem.best_objective)
    points = decode_points(problem, chromosomes, length)
    individuals = [Individual(u, float(merit)) for u, merit in zip(points, merits, strict=True)]
    return sorted(individuals, key=lambda individual: individual.objective)


def breed_offspring(
    random: np.random.Generator,
    chromosomes: Bits,
    merits: Array,
    count: int,
    settings: GeneticSettings,
) -> Bits:
    """Return chromosomes (count, bits) of the offspring of a population (n, bits) with merits (n,)
    to be minimised.

    Parents are chosen as the settings say. Two parents exchange what follows a random digit, with
    the probability of crossover; then every digit flips with the probability of mutation.
    """
    pairs = (count + 1) // 2
    select = sample_ranks if settings.selection == "ranking" else hold_tournaments
    parents = select(random, merits, 2 * pairs).reshape(2, pairs)
    first, second = chromosomes[parents[0]], chromosomes[parents[1]]
    bits = chromosomes.shape[1]
    cuts = random.integers(1, bits, size=(pairs, 1))
    crosses = random.random((pairs, 1)) < settings.crossover_probability
    exchanged = crosses & (np.arange(bits) >= cuts)
    children = np.vstack([np.where(exchanged, second, first), np.where(exchanged, first, second)])[
        :count
    ]
    return children ^ (random.random(children.shape) < settings.mutation_probability)


def hold_tournaments(random: np.random.Generator, merits: Array, count: int) -> Integers:
    """Return the indices (count,) of parents, each the better of two individuals drawn at random,
    for merits (n,) to be minimised.
    """
    rivals = random.integers(len(merits), size=(count, 2))
    return np.where(merits[rivals[:, 1]] < merits[rivals[:, 0]], rivals[:, 1], rivals[:, 0])


def sample_ranks(random: np.random.Generator, merits: Array, count: int) -> Integers:
    """Return the indices (count,) of parents in random order by stochastic universal sampling: the
    expected number of an individual falls linearly from its best to its worst merit (n,), and each
    is chosen as often as that, rounded down or up.
    """
    size = len(merits)
    ranks = np.empty(size)
    ranks[np.argsort(merits, kind="stable")] = np.linspace(
        SELECTIVE_PRESSURE, 2 - SELECTIVE_PRESSURE, size
    )
    ends = np.cumsum(ranks) * (count / size)
    pointers = random.random() + np.arange(count)
    chosen = np.minimum(np.searchsorted(ends, pointers, side="right"), size - 1)
    return random.permutation(chosen)


def _evaluate(problem: Problem, chromosomes: Bits, length: int) -> Array:
    """Return the merits (n,) of chromosomes (n, independent * length)."""
    return problem.merits(decode_points(problem, chromosomes, length))


def decode_points(problem: Problem, bits: Bits, length: int) -> list[Array]:
    """Return the points u (p,) of chromosomes (n, independent * length); genes are binary, high
    digit first.

    The points are projected onto the equality constraints, if there are any, since binary numbers
    miss these.
    """
    genes = bits.astype(float).reshape(len(bits), len(problem.independent), length)
    values = genes @ (2.0 ** np.arange(length - 1, -1, -1)) / (2.0**length - 1)
    return [problem.onto(problem.interpolate(v)) for v in values]


def select_distinct(
    individuals: list[Individual], count: int, separation: float
) -> list[Individual]:
    """Return the best `count` individuals no two of which are within `separation` box units in
    every coordinate.
    """
    chosen: list[Individual] = []
    for individual in individuals:
        if len(chosen) < count and all(
            np.abs(individual.u - other.u).max() > separation for other in chosen
        ):
            chosen.append(individual)
    return chosen


Method = Literal["auto", "hybrid", "ipopt", "ga"]
METHODS: tuple[Method, ...] = ("auto", "hybrid", "ipopt", "ga")
SHARE_AGREEING = 1 / 3
"""Share of the starts that must agree for `auto` to do without the genetic algorithm, but at least
two of several.
"""
MAX_POLISHED = 3
"""Maximum number of individuals from which local searches start."""
MIN_SEPARATION = 0.02
"""Smallest distance of these individuals, in units of the box."""


class OptimiserRun:
    """One run of a method on a problem; each part has its own counts and its own history.

    Workers run the descents of the task as `means` says.
    """

    def __init__(
        self,
        problem: Problem,
        settings: GeneticSettings,
        seed: int = 0,
        starts: int = DEFAULT_STARTS,
        progress: Listener | None = None,
        task: Task | None = None,
        means: Means = AUTO,
    ) -> None:
        self.task, self.means = task, means
        self.settings, self.seed, self.starts, self.progress = settings, seed, starts, progress
        self.ga, self.ipopt, self.polish = (problem.anew() for _ in range(3))
        self.minima: list[LocalMinimum] = []
        self.violations: list[ViolationMinimum] = []
        self.descents: list[Descent] = []
        self.begun = time.perf_counter()
        self._candidates: list[Array] = []
        self._has_bred = False

    def run(self, method: Method, candidates: Sequence[Array] = ()) -> OptimiserResult:
        """Return the best of the points that the method reaches and of feasible candidates u (p,).

        Raises NoFeasiblePointError if no point is feasible, ComputationError if every local search
        fails.
        """
        self._candidates = list(candidates)
        self._find_feasible_starts(method)
        reached = list(self._candidates)
        individuals = self._search_genetically() if method in ("ga", "hybrid") else []
        if method != "ga":
            self._descend()
        if method == "auto" and self._starts_disagree():
            individuals = self._search_genetically()
        reached += [individual.u for individual in individuals[:1]]
        reached += [minimum.u for minimum in self.minima]
        if method != "ga" and individuals:
            reached += self._polish(select_distinct(individuals, MAX_POLISHED, MIN_SEPARATION))
        return self._result(method, reached)

    def so_far(self, method: Method) -> OptimiserResult | None:
        """Return the best point of an interrupted run, or None if no feasible point was
        evaluated.
        """
        reached = [problem.best.u for problem in self._problems if problem.best is not None]
        reached += [minimum.u for minimum in self.minima]
        reached = [u for u in (*self._candidates, *reached) if self.polish.is_feasible(u)]
        return self._result(method, reached) if reached else None

    def best(self) -> BestPoint | None:
        """Return the best point that any part has met so far."""
        met = [problem.best for problem in self._problems if problem.best is not None]
        return min(met, key=lambda best: best.objective, default=None)

    def closest(self) -> ClosestPoint | None:
        """Return the point that violates the constraints least of all that any part has met so
        far.
        """
        met = [problem.closest for problem in self._problems if problem.closest is not None]
        return min(met, key=lambda closest: closest.violation, default=None)

    def describe(self, method: Method) -> str:
        """Return in a sentence what a method has run, and why."""
        count = len(self.descents)
        local = f"local searches from {count_things(count, 'start')}"
        if method == "ga":
            return "genetic algorithm alone, as asked for"
        if method == "ipopt":
            return f"{local} alone, as asked for"
        genetic = "the genetic algorithm and local searches from its best individuals"
        if method == "hybrid":
            return f"{local}, {genetic}, as asked for"
        agreeing = self._count_agreeing()
        share = f"{agreeing} of {count} agree on the best"
        if self._has_bred:
            return f"{local}, then {genetic}, since only {share}"
        return f"{local} alone: {share}, so the genetic algorithm was not needed"

    def _find_feasible_starts(self, method: Method) -> None:
        """List the descents, from feasible points where there are constraints; these are candidates
        too.

        Raises NoFeasiblePointError if a search from each start ends at a violation.
        """
        starts = sample_starts(self.ipopt, self.starts, self.seed)
        if self.ipopt.constraints is None:
            self.descents = list_descents(starts)
            return
        ends = find_violation_minima(self.ipopt, starts, self.progress, self.task, self.means)
        descents = list_descents(starts)
        for end, descent in zip(ends, descents, strict=False):
            if end is None:
                continue
            if not end.is_feasible:
                self.violations.append(end)
                continue
            self._candidates.append(end.u)
            self.descents.append(replace(descent, start=end.u))
            if method == "ga":  # one is enough
                break
        if not self._candidates:
            raise NoFeasiblePointError([end.u for end in self.violations])

    def _search_genetically(self) -> list[Individual]:
        self._has_bred = True
        self.ga.restart()
        return search_genetically(self.ga, self.settings, self.seed, self.progress)

    def _descend(self) -> None:
        phase = ProgressPhase("ipopt", "start", len(self.descents), self.progress)
        for minimum in find_minima(self.ipopt, self.descents, phase, self.task, self.means):
            self.minima.append(minimum)
        self._repeat_descents()

    def _list_disagreeing(self) -> list[int]:
        """Return the descents that ended above the best, none if some failed, so that the others
        cannot be told apart.
        """
        reached = [m.objective for m in self.minima if m.violation <= FEASIBILITY_TOLERANCE]
        if len(self.minima) < len(self.descents) or not reached:
            return []
        limit = min(reached) + AGREEMENT_TOLERANCE * self.ipopt.scale
        return [k for k, minimum in enumerate(self.minima) if minimum.objective > limit]

    def _starts_disagree(self) -> bool:
        count = len(self.descents)
        return self._count_agreeing() < max(SHARE_AGREEING * count, min(2, count))

    def _count_agreeing(self) -> int:
        """Return how many descents ended at the best objective."""
        reached = [m.objective for m in self.minima if m.violation <= FEASIBILITY_TOLERANCE]
        limit = min(reached, default=0.0) + AGREEMENT_TOLERANCE * self.ipopt.scale
        return sum(objective <= limit for objective in reached)

    def _repeat_descents(self) -> None:
        """Repeat the descents that ended above the best, with a glide if they had none, else
        without.

        The better minimum of each start counts.
        """
        again = self._list_disagreeing()
        if not again:
            return
        descents = self.descents
        phase = ProgressPhase("ipopt again", "start", len(again), self.progress)
        repeated = [replace(descents[k], glides=not descents[k].glides) for k in again]
        with suppress(ComputationError):
            minima = list(find_minima(self.ipopt, repeated, phase, self.task, self.means))
            for k, minimum in zip(again, minima, strict=False):
                self.minima[k] = min(self.minima[k], minimum, key=lambda each: each.rank)

    def _polish(self, individuals: Sequence[Individual]) -> list[Array]:
        """Return the local minima near individuals, points u (p,)."""
        phase = ProgressPhase("polish", "individual", len(individuals), self.progress)
        starts = [Descent(individual.u) for individual in individuals]
        return [m.u for m in find_minima(self.polish, starts, phase, self.task, self.means)]

    @property
    def _problems(self) -> tuple[Problem, Problem, Problem]:
        return self.ga, self.ipopt, self.polish

    def _result(self, method: Method, reached: list[Array]) -> OptimiserResult:
        counts = self.ga.counts + self.ipopt.counts + self.polish.counts
        named = zip(("ga", "ipopt", "polish"), self._problems, strict=True)
        history = {name: problem.history for name, problem in named if problem.history}
        return build_result(
            self.ga,
            reached,
            self.minima,
            method=method,
            seed=self.seed,
            evaluations=EvaluationCounts(**vars(counts)),
            seconds=time.perf_counter() - self.begun,
            history=history,
            searches=self.describe(method),
        )
