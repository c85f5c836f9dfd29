"""Gains of frames, and which are unusual."""

import numpy as np
import pytest

from fsel.captures.quality.cells import GRID, Cells
from fsel.captures.quality.photometry import gains_at_points, gains_beside, unusual_gains

TRUE = np.array([1, 1.02, 0.98, 1, 1.6, 1, 1.01, 0.5, 1])


def cells(seed=0):
    """Frames of which each sees other colors, under gains."""
    rng = np.random.default_rng(seed)
    colors = rng.uniform(20, 120, (3, GRID * GRID))
    frames = colors * TRUE[:, None, None]
    nothing = np.zeros((len(TRUE), GRID, GRID), np.float32)
    shown = frames.reshape(len(TRUE), 3, GRID, GRID)
    return Cells(np.zeros((len(TRUE), 4, 1, 1)), nothing, shown)


def tracks(length=4, count=GRID * GRID):
    """Each point is seen by a few neighbouring frames, at its own cell."""
    start = np.arange(count) % (len(TRUE) - length + 1)
    point = np.repeat(np.arange(count), length)
    return point, point, (start[:, None] + np.arange(length)).ravel()


def test_gains_are_found_through_chains_of_points():
    gains = gains_at_points(cells(), *tracks())
    relative = np.exp(gains - np.median(gains, axis=0))
    np.testing.assert_allclose(relative, np.repeat(TRUE[:, None], 3, axis=1), rtol=0.03)


def test_unusual_frames_are_those_of_another_gain():
    brightness, most = unusual_gains(gains_at_points(cells(), *tracks()))
    assert np.flatnonzero(brightness > most).tolist() == [4, 7]
    assert brightness[[4, 7]] == pytest.approx([1.6, 2], rel=0.03)


def test_a_capture_that_varies_much_has_wider_limits():
    drift = np.repeat(np.linspace(-0.6, 0.6, 13)[:, None], 3, axis=1)
    brightness, most = unusual_gains(drift)
    assert not (brightness > most).any()
    assert np.isnan(unusual_gains(np.full((3, 3), np.nan))[0]).all()


def test_without_points_neighbours_are_compared():
    near = np.array([[max(0, i - 1), min(len(TRUE) - 1, i + 1), 0] for i in range(len(TRUE))])
    gains = gains_beside(cells(), near)
    assert np.exp(gains[4]) == pytest.approx([1.6] * 3, rel=0.03)
    dark = cells()
    dark.color[2] = 0
    assert np.isnan(gains_beside(dark, near)[2]).all()
