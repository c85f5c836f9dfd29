"""Searches: operators, budgets, replay, and what they optimise."""

import numpy as np
import pytest

from fsel.training.search import (
    GeneticSettings,
    fitness,
    fittest_so_far,
    genetic_search,
    initial_population,
    offspring,
    random_search,
)

POOL = np.arange(0, 80, 2)
CENTERS = np.random.default_rng(0).normal(size=(80, 3))


def additive(subset):
    """A landscape whose optimum is the ten largest frames of the pool."""
    value = subset.sum() / 100
    return np.array([value, value / 10, -value])


def run(evaluate=additive, **settings):
    rng, made = np.random.default_rng(0), GeneticSettings(**settings)
    return genetic_search(evaluate, POOL, POOL[:30], CENTERS, 10, rng, made)


def test_fitness_by_hand():
    metrics = np.array([[10.0, 0.5, 0.3], [20.0, 0.5, 0.1], [15.0, 0.5, 0.2]])
    # SSIM is equal for all and counts 0; the others normalise to 0, 1, 1/2.
    np.testing.assert_allclose(fitness(metrics), [0, 2 / 3, 1 / 3])


def test_equal_metrics_have_equal_finite_fitness():
    np.testing.assert_array_equal(fitness(np.ones((5, 3))), np.zeros(5))


def test_initial_population_has_the_papers_composition():
    region, rng = POOL[5:35], np.random.default_rng(1)
    subsets = initial_population(POOL, region, CENTERS, 10, rng, GeneticSettings())
    assert len(subsets) == 40
    for subset in subsets:
        assert len(np.unique(subset)) == 10
        assert np.isin(subset, region).all()
    spacing = np.diff(np.searchsorted(region, subsets[16]))
    assert set(spacing) <= {3}
    assert len({tuple(s) for s in subsets[16:28]}) > 1


@pytest.mark.parametrize("size", [0, 4])
def test_a_small_region_is_filled_from_the_pool(size):
    rng, settings = np.random.default_rng(1), GeneticSettings(population=6, farthest=2, uniform=2)
    subsets = initial_population(POOL, POOL[:size], CENTERS, 10, rng, settings)
    for subset in subsets:
        assert len(np.unique(subset)) == 10
        assert np.isin(POOL[:size], subset).all()
        assert np.isin(subset, POOL).all()


def test_the_fittest_so_far_is_the_first_of_equals():
    assert fittest_so_far(np.array([0.5, 0.4, 0.6, 0.6, 0.9, 0.1])).tolist() == [0, 0, 2, 2, 4, 4]


def test_genetic_search_improves_and_keeps_every_subset():
    result = run()
    first = result.fitness[result.generation == 0].max()
    assert result.fitness.max() > first + 0.2
    assert result.generation.max() == 15
    assert (np.diff(result.subsets, axis=1) > 0).all()
    assert len(np.unique(result.subsets, axis=0)) == len(result.subsets)
    assert np.isin(result.subsets, POOL).all()


def test_without_variation_nothing_new_is_evaluated():
    assert run(crossover=0.0, mutation=0.0).generation.max() == 0


FAMILIES = np.arange(600).reshape(20, 30)  # disjoint parents; frames from 600 on are nobody's
LARGE = np.arange(15000)


def children(count, k=10, **settings):
    """Children of `FAMILIES`, whose fitness rises with their number."""
    rng, score = np.random.default_rng(4), np.arange(20.0)
    population = list(FAMILIES[:, :k])
    made = GeneticSettings(**settings)
    return [offspring(population, score, LARGE, k, rng, made) for _ in range(count)]


def parents_of(child):
    """How many families a child has frames of."""
    return len(np.unique(child[child < 600] // 30))


def fresh(child):
    return int((child >= 600).sum())


@pytest.mark.parametrize("size", [1, 4])
def test_a_tournament_returns_the_fittest_of_its_entrants(size):
    made = children(3000, crossover=0, mutation=0, tournament=size)
    winners = np.array([child[0] // 30 for child in made])
    # the fittest of 20 enters with probability size / 20; the least fit wins only alone
    assert np.mean(winners == 19) == pytest.approx(size / 20, abs=0.02)
    assert (winners == 0).any() == (size == 1)


def test_crossover_draws_from_the_union_of_two_parents():
    made = children(1000, crossover=1, mutation=0, tournament=1)
    assert all(fresh(child) == 0 and parents_of(child) <= 2 for child in made)
    assert np.mean([parents_of(child) == 2 for child in made]) == pytest.approx(0.95, abs=0.03)
    shares = [np.mean(child // 30 == child[0] // 30) for child in made if parents_of(child) == 2]
    assert np.mean(shares) == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize(("k", "replaced"), [(10, 2), (4, 2), (30, 6)])
def test_mutation_replaces_a_fifth_and_at_least_two(k, replaced):
    made = children(300, k=k, crossover=0, mutation=1)
    counts = [fresh(child) for child in made]
    assert max(counts) == replaced
    assert np.mean(counts) > 0.9 * replaced  # a draw from the pool may return an old frame


def test_crossover_and_mutation_happen_independently_at_the_papers_rates():
    made = children(4000, tournament=1)
    mixed = np.array([parents_of(child) == 2 for child in made])
    mutated = np.array([fresh(child) > 0 for child in made])
    assert mixed.mean() == pytest.approx(0.8 * 0.95, abs=0.03)
    assert mutated.mean() == pytest.approx(0.3, abs=0.03)
    assert (mixed & mutated).mean() == pytest.approx(0.3 * 0.8 * 0.95, abs=0.03)


def test_two_elites_take_the_place_of_two_children():
    rng = np.random.default_rng(0)
    settings = GeneticSettings(mutation=1.0, generations=1)
    result = genetic_search(additive, LARGE, LARGE, np.zeros((15000, 3)), 10, rng, settings)
    assert (result.generation == 1).sum() == 38


def test_the_fittest_of_all_generations_stays_a_parent():
    # each child is a mutant of the fittest of its population: 8 of 10 frames are its parent's
    def rugged(subset):
        return np.full(3, np.random.default_rng(subset).random()) * [1, 1, -1]

    result = run(rugged, crossover=0.0, mutation=1.0, tournament=40, generations=10)
    for generation in range(1, 11):
        before = result.generation < generation
        fittest = result.subsets[before][np.argmax(result.fitness[before])]
        for child in result.subsets[result.generation == generation]:
            assert len(np.intersect1d(child, fittest)) >= 8


def test_a_search_asks_for_the_same_subsets_again():
    asked = []
    whole = run(lambda subset: asked.append(subset) or additive(subset))
    np.testing.assert_array_equal(asked, whole.subsets)
    np.testing.assert_array_equal(run().subsets, whole.subsets)


def test_random_search_meets_its_budget():
    result = random_search(additive, POOL, 10, 100, np.random.default_rng(0))
    assert len(result.subsets) == 100
    tiny = random_search(additive, POOL[:4], 4, 100, np.random.default_rng(0))
    assert len(tiny.subsets) == 1


@pytest.mark.parametrize("k", [0, 41])
def test_impossible_size_is_refused(k):
    with pytest.raises(ValueError, match="pool of 40"):
        genetic_search(additive, POOL, POOL, CENTERS, k, np.random.default_rng(0))
