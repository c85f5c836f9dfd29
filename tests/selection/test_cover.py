"""The guarantee of cover: by hand, and its bounds."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.distance import cdist
from selection_problems import capture_of

import fsel
from fsel.selection.cover import SLACK, covering, farthest_first


def looking_ahead(centers):
    """Places of cameras that all look along z, one depth away."""
    return np.stack([centers, centers + [0, 0, 1.0]], axis=1)


def test_the_traversal_goes_to_the_farthest():
    places = looking_ahead(np.array([0.0, 1, 2, 6, 10])[:, None] * [1.0, 0, 0])
    rows, radii = farthest_first(places, 4)
    assert rows.tolist() == [2, 4, 3, 0]
    assert radii.tolist() == [16, 8, 4, 2]
    assert covering(places, 4).tolist() == [2, 4, 3, 0]


def test_rows_in_one_place_are_taken_once_each():
    places = looking_ahead(np.zeros((4, 3)))
    rows, radii = farthest_first(places, 4)
    assert rows.tolist() == [0, 1, 2, 3]
    assert radii.tolist() == [0, 0, 0, 0]
    assert covering(places, 3).tolist() == [0]


def test_no_row_is_farther_than_three_times_the_best_cover():
    for seed in range(20):
        places = np.random.default_rng(seed).normal(size=(11, 2, 3))
        distance = sum(cdist(places[:, part], places[:, part]) for part in (0, 1))
        best = min(distance[:, list(rows)].min(axis=1).max() for rows in combinations(range(11), 4))
        rows = covering(places, 4)
        reached = distance[:, rows].min(axis=1).max()
        assert len(rows) <= 4
        assert reached <= 2 * SLACK * best
        _, radii = farthest_first(places, 4)
        assert reached <= SLACK * radii[-1]
        assert radii[-1] <= 2 * best
        fewer = distance[:, rows[:-1]].min(axis=1, initial=np.inf).max()
        assert fewer > SLACK * radii[-1]  # no more rows than needed


def test_covered_picks_leave_no_stretch_without_one():
    """Thirty cameras in a heap and three far off: the rule alone has nothing against a hole."""
    rng = np.random.default_rng(0)
    heap = rng.normal(scale=0.05, size=(30, 3))
    far = np.array([[40.0, 0, 0], [80, 0, 0], [120, 0, 0]])
    capture = capture_of(np.concatenate([heap, far]), np.tile(np.eye(3), (33, 1, 1)))
    picks = fsel.select(capture, 5, patience=0, k_center=True).indices
    assert len(set(picks)) == 5
    assert {30, 31, 32} <= set(picks)


def test_a_cover_goes_with_a_number_alone():
    capture = capture_of(np.eye(3)[[0, 1, 2, 0, 1, 2]] * 2, np.tile(np.eye(3), (6, 1, 1)))
    with pytest.raises(ValueError, match="a k-center is wanted, and the views to be rendered"):
        fsel.select(capture, 2, targets="every:3", k_center=True)
