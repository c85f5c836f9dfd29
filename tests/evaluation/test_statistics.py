"""Intervals hold for few places: against SciPy, and seeds and rivals on simulated nulls."""

import numpy as np
import pytest
from scipy import stats

from fsel.evaluation.statistics import ahead_of_all, holm, of_places, of_places_and_seeds

TRIALS = 1000
BOUND = 0.07  # nominal 5 %, and three standard errors of the simulation are 2 %


@pytest.mark.parametrize("n", [2, 5, 24])
def test_places_against_scipy(n):
    values = np.random.default_rng(n).normal(0.3, 1, n)
    found, wanted = of_places(values), stats.ttest_1samp(values, 0)
    np.testing.assert_allclose(found.p, wanted.pvalue)
    np.testing.assert_allclose((found.low, found.high), wanted.confidence_interval(0.95))


def test_one_place_says_nothing_about_others_and_equal_values_have_no_width():
    found = of_places(np.array([2.5]))
    assert found.mean == 2.5
    assert np.isnan([found.low, found.high, found.p]).all()
    assert of_places(np.full(4, 1.5))[:4] == (1.5, 1.5, 1.5, 0.0)
    assert of_places(np.zeros(3)).p == 1.0
    assert of_places_and_seeds(np.full((3, 2), 1.5))[:4] == (1.5, 1.5, 1.5, 0.0)


@pytest.mark.parametrize("places", [2, 6, 24])
@pytest.mark.parametrize("deviations", [(1, 0, 1), (1, 1, 0.5), (0.2, 1, 0.2)])
def test_seeds_are_a_sample_too(places, deviations):
    """Places, seeds that move all of them together, and a residual; three seeds."""
    rng = np.random.default_rng([places, int(10 * sum(deviations))])
    of_place, of_seed, residual = deviations
    rejected = 0
    for _ in range(TRIALS):
        values = rng.normal(0, of_place, (places, 1)) + rng.normal(0, of_seed, (1, 3))
        values = values + rng.normal(0, residual, (places, 3))
        rejected += of_places_and_seeds(values).p < 0.05
    assert rejected / TRIALS < BOUND


def test_seeds_widen_the_interval_and_one_seed_does_not():
    rng = np.random.default_rng(0)
    places = rng.normal(0, 1, (12, 1))
    alone = of_places(places[:, 0])
    moved = of_places_and_seeds(places + np.array([[-1.0, 0, 1]]))
    assert moved.high - moved.low > 1.2 * (alone.high - alone.low)
    np.testing.assert_allclose(of_places_and_seeds(places), alone)


def test_holm_by_hand():
    # sorted: 0.01 * 4, 0.02 * 3 = 0.06, 0.03 * 2 = 0.06, 0.5
    np.testing.assert_allclose(holm(np.array([0.5, 0.01, 0.03, 0.02])), [0.5, 0.04, 0.06, 0.06])
    np.testing.assert_allclose(holm(np.array([np.nan, 0.6, 0.7])), [np.nan, 1, 1])
    assert holm(np.array([np.nan])).tolist() != [1.0]


def test_the_weakest_comparison_decides():
    assert ahead_of_all(np.array([1.0, 0.1]), np.array([0.01, 0.3])) == 0.3
    assert ahead_of_all(np.array([1.0, -1.0]), np.array([0.01, 0.01])) == 1.0
    assert ahead_of_all(np.array([1.0]), np.array([0.01])) == 0.01
    assert np.isnan(ahead_of_all(np.array([1.0, 1.0]), np.array([0.01, np.nan])))


@pytest.mark.parametrize("places", [2, 12])
@pytest.mark.parametrize("lead", [0.0, 3.0])
def test_a_method_like_its_strongest_rival_is_seldom_called_ahead(places, lead):
    """Eight rivals, one of them the method's equal, the others behind by a lead."""
    rng = np.random.default_rng(places)
    called = 0
    for _ in range(TRIALS // 2):
        gaps = rng.normal(0, 1, (places, 1)) - rng.normal(0, 1, (places, 8))
        gaps[:, 1:] += lead
        found = [of_places(gap) for gap in gaps.T]
        p = ahead_of_all(gaps.mean(axis=0), np.array([gap.p for gap in found]))
        called += p < 0.05
    assert called / (TRIALS // 2) < BOUND
