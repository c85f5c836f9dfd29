"""Poses found twice: how far two sets are apart, and what is said of it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fsel.captures.poses.placement import apart, doubt


def test_sets_are_apart_by_their_turns_in_any_worlds():
    first = Rotation.random(9, random_state=0)
    world = Rotation.random(random_state=1)
    assert apart(first.as_matrix(), (first * world).as_matrix()) == pytest.approx(0, abs=1e-5)
    halves = Rotation.from_euler("z", np.repeat([[0], [20]], [5, 4], axis=0), degrees=True)
    found = apart(first.as_matrix(), (first * halves * world).as_matrix())
    assert found == pytest.approx(20)  # 20 of 36 pairs are of one frame of each


@pytest.mark.parametrize(
    ("again", "said"),
    [
        (None, ""),
        ({"placed": 10, "degrees": 0.3}, ""),
        ({"placed": 9, "degrees": 2.9}, ""),
        ({"placed": 9, "degrees": 36.7}, "COLMAP's poses differ by 37 degrees"),
        ({"placed": 8, "degrees": 0.0}, "COLMAP places 8 frames, not 10"),
        ({"placed": 12, "degrees": 0.0}, "COLMAP places 12 frames, not 10"),
        ({"placed": 0, "degrees": None}, "COLMAP places 0 frames, not 10"),
    ],
)
def test_doubts_are_of_sets_that_differ(again, said):
    told = doubt({"placed": ["a.jpg"] * 10, "repeated": again})
    assert told == (said and f"the poses may be wrong: with another seed {said}")
    assert doubt({"placed": []}) == ""
