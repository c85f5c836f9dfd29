"""How well picks serve views, and what each adds."""

import numpy as np
import pytest
from selection_problems import in_line

from fsel.selection.outcome import proximity_of


def test_service_by_hand():
    """Frames at 0, 1, 2, 10 on a line, all looking alike, and a view at 0."""
    line = in_line([0, 1, 2, 10])
    close = np.array([1, 0.7, 0.49, 0.343])  # by rank
    whole = close @ [1, 1 / 2, 1 / 4, 1 / 8]
    result = proximity_of(line, line.view(np.array([0])), np.arange(4), np.array([2, 0]))
    expected = np.array([close[2], close[0] + close[2] / 2]) / whole
    np.testing.assert_allclose(result.curve, expected)
    np.testing.assert_allclose(result.gain, [expected[0], expected[1] - expected[0]])


def test_service_rises_to_one_and_each_frame_adds_less(circle):
    views = circle.view(np.array([1, 9, 17]))
    pool = np.setdiff1d(np.arange(24), [1, 9, 17])
    picks = np.array([2, 10, 18, *np.setdiff1d(pool, [2, 10, 18])])
    result = proximity_of(circle, views, pool, picks)
    np.testing.assert_array_equal(result.nearest_view[:3], [0, 1, 2])
    assert result.curve[-1] == pytest.approx(1)
    assert (result.gain >= -1e-12).all()
