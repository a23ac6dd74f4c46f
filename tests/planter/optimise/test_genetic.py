"""The genetic algorithm: reproducible, with the settings it is given, and stoppable."""

import numpy as np
import pytest

from planter.optimise import genetic
from planter.optimise.objective import evaluation
from planter.optimise.range_and_spread import problem as over_turn
from planter.planting.file import load
from tests.planter.optimise import toys


@pytest.fixture
def settings():
    return load("wang2017").genetic_algorithm.model_copy(update={"individuals": 20, "generations": 15})


def search(settings, seed=0, progress=None):
    problem = over_turn(toys.third_harmonic(), toys.RANGE, 24)
    return problem, genetic.search(problem, settings, seed, progress)


def test_the_same_seed_gives_the_same_bits(settings):
    (one, first), (two, second), (_, other) = (search(settings, seed) for seed in (3, 3, 4))
    assert [(p.u.tobytes(), p.objective) for p in first] == [(p.u.tobytes(), p.objective) for p in second]
    assert one.history == two.history
    assert [p.u.tobytes() for p in first] != [p.u.tobytes() for p in other]


def test_evaluations_follow_from_the_settings(settings):
    """A population first, then 0.8 of it in each further generation: 40 + 199 * 32 for the paper's."""
    problem, population = search(settings)
    assert problem.counts.objective == 20 + 14 * 16
    assert len(population) == 20


def test_it_finds_the_optimum_nearly_and_never_loses_it(settings):
    seen = []
    problem, population = search(settings, progress=lambda told: seen.append(told.best))
    assert population[0].objective == problem.best.objective == min(seen)
    assert seen == sorted(seen, reverse=True)
    assert population[0].objective == pytest.approx(np.sqrt(3), abs=0.02)


def test_offspring_replace_all_but_the_best(settings, monkeypatch):
    """Elitist reinsertion: a worse child still replaces a parent that is not among the elite."""
    populations = []
    tell = genetic._individuals
    monkeypatch.setattr(genetic, "_individuals", lambda p, pop, n: populations.append(pop) or tell(p, pop, n))
    full = settings.model_copy(update={"selection_ratio": 1.0, "generations": 2})
    problem, population = search(full)
    assert len(population) == 20
    assert problem.counts.objective == 40
    kept = {individual.u.tobytes() for individual in population}
    assert len(kept) > 1


def test_chromosomes_reach_both_bounds_exactly():
    problem = over_turn(toys.linear(0)[0], toys.RANGE, 24)
    bits = np.array([[False] * 20 + [True] * 20 + [True] + [False] * 19])
    (u,) = genetic.decode(problem, bits, 20)
    assert u.tolist() == [0.0, 1.0, 2**19 / (2**20 - 1)]


def test_distinct_individuals_are_apart():
    listed = ((0.1, 1.0), (0.11, 1.1), (0.3, 1.2), (0.9, 1.3))
    population = [genetic.Individual(np.array([u, 0.5]), f) for u, f in listed]
    assert [p.objective for p in genetic.distinct(population, 2, 0.05)] == [1.0, 1.2]


def test_an_interrupt_leaves_the_best_so_far(settings, monkeypatch):
    problem = over_turn(toys.third_harmonic(), toys.RANGE, 24)
    look, calls = problem.objective.turn.look, []

    def stopped(x):
        calls.append(x)
        if len(calls) == 50:
            raise KeyboardInterrupt
        return look(x)

    monkeypatch.setattr(problem.objective.turn, "look", stopped)
    with pytest.raises(KeyboardInterrupt):
        genetic.search(problem, settings, 0)
    least = min(evaluation(problem.objective, look(x)).objective for x in calls[:49])
    assert problem.best.objective == least
