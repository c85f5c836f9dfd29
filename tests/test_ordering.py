"""Eq. 3 and Eq. 5."""

import numpy as np

from fsel.ordering import order_subset, trajectory_weights


def test_order_by_hand():
    # Frame 1 has the least total distance; then frame 2 mends the far view, then frame 0.
    distances = np.array([[0.0, 9.0, 9.0], [1.0, 1.0, 5.0], [9.0, 9.0, 0.0]])
    np.testing.assert_array_equal(order_subset(distances), [1, 2, 0])


def test_order_matches_the_definition():
    rng = np.random.default_rng(3)
    distances = rng.random((8, 5))
    order = order_subset(distances)
    prefix = []
    for pick in order:
        rest = [i for i in range(8) if i not in prefix]
        totals = [distances[[*prefix, i]].min(axis=0).sum() for i in rest]
        assert pick == rest[int(np.argmin(totals))]
        prefix.append(pick)


def test_ties_go_to_the_lowest_row():
    np.testing.assert_array_equal(order_subset(np.ones((4, 3))), [0, 1, 2, 3])


def test_weights_by_hand():
    fitness = np.array([1.0, 0.0])
    raw = np.array([1.0, np.exp(-2.0)])
    np.testing.assert_allclose(trajectory_weights(fitness), raw / raw.mean(), rtol=1e-9)


def test_equal_fitness_gives_equal_weights():
    np.testing.assert_array_equal(trajectory_weights(np.full(4, 0.3)), np.ones(4))
