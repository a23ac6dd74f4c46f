"""The genetic algorithm: reproducible, with the settings it is given, and stoppable."""

import numpy as np
import pytest

from planter.engine.solvers import optimiser
from planter.engine.solvers.objective import evaluate_summary
from planter.papers.planting.file import load
from tests.planter.engine.solvers import toys


@pytest.fixture
def settings():
    return load("wang2017").genetic_algorithm.model_copy(
        update={"individuals": 20, "generations": 15}
    )


def search(settings, seed=0, progress=None):
    problem = toys.over_turn(toys.third_harmonic(), toys.RANGE, 24)
    return problem, optimiser.search_genetically(problem, settings, seed, progress)


def test_the_same_seed_gives_the_same_bits(settings):
    (first_best, first), (second_best, second), (_, other) = (
        search(settings, seed) for seed in (3, 3, 4)
    )
    assert [(p.u.tobytes(), p.objective) for p in first] == [
        (p.u.tobytes(), p.objective) for p in second
    ]
    assert first_best.history == second_best.history
    assert [p.u.tobytes() for p in first] != [p.u.tobytes() for p in other]


def test_evaluations_follow_from_the_settings(settings):
    """A population first, then 0.8 of it in each further generation: 40 + 199 * 32 for the
    paper's.
    """
    problem, population = search(settings)
    assert problem.counts.objective == 20 + 14 * 16
    assert len(population) == 20


def test_it_finds_the_optimum_nearly_and_never_loses_it(settings):
    seen = []
    problem, population = search(settings, progress=lambda progress: seen.append(progress.best))
    assert population[0].objective == problem.best.objective == min(seen)
    assert seen == sorted(seen, reverse=True)
    assert population[0].objective == pytest.approx(np.sqrt(3), abs=0.02)


def test_elite_survives_and_offspring_replace_the_rest(settings, monkeypatch):
    """A worse child still replaces a parent that is not among the elite."""
    bits = np.zeros((16, 200), bool)
    monkeypatch.setattr(
        optimiser,
        "breed_offspring",
        lambda random, chromosomes, *rest: bits[:, : chromosomes.shape[1]],
    )
    _, first = search(settings.model_copy(update={"generations": 1}))
    problem, second = search(settings.model_copy(update={"generations": 2}))
    length = settings.bits_per_variable
    (child,) = (
        u.tobytes()
        for u in optimiser.decode_points(problem, bits[:1, : len(problem.free) * length], length)
    )
    assert sum(individual.u.tobytes() == child for individual in second) == 16
    assert [p.u.tobytes() for p in first[:4]] == [
        p.u.tobytes() for p in second if p.u.tobytes() != child
    ]


def breed(settings, seed=0, crossover=0.0, mutation=0.0, count=4000, merits=(0.0, 0.0)):
    """Offspring of two parents, all zeros and all ones."""
    parents = np.array([[False] * 12, [True] * 12])
    probabilities = {"crossover_probability": crossover, "mutation_probability": mutation}
    changed = settings.model_copy(update=probabilities)
    return optimiser.breed_offspring(
        np.random.default_rng(seed), parents, np.array(merits), count, changed
    )


def test_tournament_prefers_the_better_parent(settings):
    """The better of two parents wins unless both draws are the other one: three times out of
    four.
    """
    share = breed(settings, merits=(1.0, 0.5)).mean()
    assert share == pytest.approx(0.75, abs=4 * np.sqrt(0.75 * 0.25 / 4000))
    assert breed(settings).mean() == pytest.approx(0.5, abs=4 * np.sqrt(0.25 / 4000))


def test_crossover_exchanges_tail_after_a_point(settings):
    """A child of different parents changes its value once; every cut, 1 to 11, is equally
    frequent.
    """
    children = breed(settings, crossover=1.0)
    steps = children[:, 1:] != children[:, :-1]
    assert set(steps.sum(axis=1)) == {0, 1}
    assert steps.any(axis=1).mean() == pytest.approx(0.5, abs=4 * np.sqrt(0.25 / 2000))
    cuts = steps.sum(axis=0)
    assert cuts == pytest.approx(np.full(11, cuts.mean()), rel=0.35)
    first, second = children[:2000], children[2000:]
    differ = steps[:2000].any(axis=1)
    np.testing.assert_array_equal(first[differ], ~second[differ])
    assert not (breed(settings)[:, 1:] != breed(settings)[:, :-1]).any()


def test_mutation_flips_the_given_share_of_bits(settings):
    children = breed(settings, mutation=0.1)
    flipped = np.minimum(children.sum(axis=1), 12 - children.sum(axis=1)).sum() / children.size
    assert flipped == pytest.approx(0.1, abs=4 * np.sqrt(0.09 / children.size))
    assert len(breed(settings, count=7)) == 7


def test_chromosomes_reach_both_bounds_exactly():
    problem = toys.over_turn(toys.linear(0)[0], toys.RANGE, 24)
    bits = np.array([[False] * 20 + [True] * 20 + [True] + [False] * 19])
    (u,) = optimiser.decode_points(problem, bits, 20)
    assert u.tolist() == [0.0, 1.0, 2**19 / (2**20 - 1)]


def test_distinct_individuals_are_apart():
    listed = ((0.1, 1.0), (0.11, 1.1), (0.3, 1.2), (0.9, 1.3))
    population = [optimiser.Individual(np.array([u, 0.5]), f) for u, f in listed]
    assert [p.objective for p in optimiser.select_distinct(population, 2, 0.05)] == [1.0, 1.2]


def test_an_interrupt_leaves_the_best_so_far(settings, monkeypatch):
    problem = toys.over_turn(toys.third_harmonic(), toys.RANGE, 24)
    summarise, calls = problem.objective.parts[0].summarise, []

    def stopped(x):
        calls.append(x)
        if len(calls) == 50:
            raise KeyboardInterrupt
        return summarise(x)

    monkeypatch.setattr(problem.objective.parts[0], "summarise", stopped)
    with pytest.raises(KeyboardInterrupt):
        optimiser.search_genetically(problem, settings, 0)
    best = min(evaluate_summary(problem.objective, summarise(x)).objective for x in calls[:49])
    assert problem.best.objective == best


def test_universal_sampling_rounds_expected_numbers():
    """Baker's property: each is chosen as often as expected, rounded down or up; linear ranks sum
    up to the population.
    """
    random, size, count = np.random.default_rng(5), 11, 40
    merits = random.permutation(np.arange(float(size)))
    expected = np.linspace(2.0, 0.0, size)[merits.astype(int)] * count / size
    total = np.zeros(size)
    for _ in range(400):
        chosen = np.bincount(optimiser.sample_ranks(random, merits, count), minlength=size)
        assert chosen.sum() == count
        assert (np.abs(chosen - expected) < 1).all()
        total += chosen
    assert total / 400 == pytest.approx(expected, abs=0.1)
    tournaments = np.bincount(optimiser.hold_tournaments(random, merits, count), minlength=size)
    assert (np.abs(tournaments - expected) >= 1).any(), "tournaments have a larger spread"


def test_ranking_reaches_the_optimum_of_tournaments(settings):
    ranked = settings.model_copy(update={"selection": "ranking"})
    _, population = search(ranked)
    assert population[0].objective == pytest.approx(np.sqrt(3), abs=0.05)
    assert [p.objective for p in population] != [p.objective for p in search(settings)[1]]
