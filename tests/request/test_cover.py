"""The guarantee of cover: by hand, and its bounds."""

from itertools import combinations

import numpy as np
from scipy.spatial.distance import cdist

from fsel.request.cover import SLACK, covering, farthest_first


def test_the_traversal_goes_to_the_farthest():
    places = np.array([[0.0], [1.0], [2.0], [6.0], [10.0]])
    rows, radii = farthest_first(cdist(places, places), 4)
    assert rows.tolist() == [3, 0, 4, 2]
    assert radii.tolist() == [6, 4, 2, 1]


def test_rows_in_one_place_are_taken_once_each():
    rows, radii = farthest_first(np.zeros((4, 4)), 4)
    assert rows.tolist() == [0, 1, 2, 3]
    assert radii.tolist() == [0, 0, 0, 0]
    assert covering(np.zeros((4, 4)), 3).tolist() == [0]


def test_no_row_is_farther_than_three_times_the_best_cover():
    for seed in range(20):
        places = np.random.default_rng(seed).normal(size=(11, 2))
        distance = cdist(places, places)
        best = min(distance[:, list(rows)].min(axis=1).max() for rows in combinations(range(11), 4))
        rows = covering(distance, 4)
        reached = distance[:, rows].min(axis=1).max()
        assert len(rows) <= 4
        assert reached <= 2 * SLACK * best
        _, radii = farthest_first(distance, 4)
        assert reached <= SLACK * radii[-1]
        assert radii[-1] <= 2 * best
        fewer = distance[:, rows[:-1]].min(axis=1, initial=np.inf).max()
        assert fewer > SLACK * radii[-1]  # no more rows than needed
