"""Evenly spaced rows, the key of a subset of frames, and the order of names."""

import numpy as np
import pytest

from fsel.core.names import natural
from fsel.core.subsets import evenly, subset_key


@pytest.mark.parametrize(
    ("count", "most", "expected"),
    [
        (9, 3, [0, 4, 8]),
        (10, 4, [0, 3, 6, 9]),
        (6, 3, [0, 2, 5]),  # 2.5 rounds to the even number
        (4, 9, [0, 1, 2, 3]),
        (5, 1, [0]),
        (0, 3, []),
    ],
)
def test_rows_are_spaced_evenly(count, most, expected):
    found = evenly(count, most)
    assert found.dtype == np.int64
    assert found.tolist() == expected


def test_the_key_forgets_the_order_alone():
    assert subset_key(np.array([7, 2, 5])) == subset_key(np.array([5, 7, 2])) == (2, 5, 7)
    assert subset_key(np.array([2, 5])) != subset_key(np.array([2, 6]))


def test_digits_that_are_no_numbers_sort_as_letters():
    names = ["frame1²", "frame2", "frame10", "frame²"]
    assert sorted({*names}, key=natural) == names
