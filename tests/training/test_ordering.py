"""Eq. 3 and Eq. 5."""

import numpy as np

from fsel.training.ordering import order_subset, trajectory_weights


def test_frames_that_cover_nothing_more_spread_out():
    # One view at 0, frames at 1, 2, 3, 6, 7: the first is closest, and no other reduces anything.
    # 7 is farthest from it; then 3, two away from 1 (2 and 6 have a frame beside them).
    places = np.array([1.0, 2.0, 3.0, 6.0, 7.0])
    apart = np.abs(places[:, None] - places)
    np.testing.assert_array_equal(order_subset(places[:, None], apart), [0, 4, 2, 1, 3])


def test_order_matches_the_definition():
    rng = np.random.default_rng(3)
    distances, places = rng.random((12, 5)), rng.random((12, 3))
    apart = np.linalg.norm(places[:, None] - places, axis=-1)
    prefix = []
    for pick in order_subset(distances, apart):
        rest = [i for i in range(12) if i not in prefix]
        totals = [distances[[*prefix, i]].min(axis=0).sum() for i in rest]
        best = [i for i, total in zip(rest, totals, strict=True) if total == min(totals)]
        gaps = [min((apart[i, j] for j in prefix), default=0.0) for i in best]
        assert pick == best[int(np.argmax(gaps))]
        prefix.append(pick)


def test_frames_all_in_one_place_keep_their_order():
    order = order_subset(np.ones((4, 3)), np.zeros((4, 4)))
    np.testing.assert_array_equal(order, [0, 1, 2, 3])


def test_weights_by_hand():
    fitness = np.array([1.0, 0.0])
    raw = np.array([1.0, np.exp(-2.0)])
    np.testing.assert_allclose(trajectory_weights(fitness), raw / raw.mean(), rtol=1e-9)


def test_equal_fitness_gives_equal_weights():
    np.testing.assert_array_equal(trajectory_weights(np.full(4, 0.3)), np.ones(4))
