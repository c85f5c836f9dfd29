"""Frames with less detail than they should have."""

import cv2
import numpy as np
import pytest

from fsel.captures.quality import photometry
from fsel.captures.quality.cells import GRID, Cells

ALL = np.ones((4, 3), bool)
NEAR = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


def test_a_frame_is_compared_with_the_second_sharpest_beside_it():
    detail = np.log([[8.0] * 4, [4.0, 4, 4, 1], [16.0] * 4, [np.e] * 4])
    detail[3] = np.nan
    times = photometry.blur_beside(detail, NEAR, ALL)
    assert times[0] == pytest.approx(4 / 8)  # of 4 and 16, in the direction that lost most
    assert times[1] == pytest.approx(8)
    assert times[2] == pytest.approx(4 / 16)
    assert np.isnan(times[3])
    assert np.isnan(photometry.blur_beside(np.full((4, 4), np.nan), NEAR, ALL)).all()
    one = NEAR[:, :1], ALL[:, :1]
    assert np.isnan(photometry.blur_beside(detail, *one)).all()  # one says nothing
    other = ALL.copy()
    other[1, 0] = False  # shows another place
    assert photometry.blur_beside(detail, NEAR, other)[1] != times[1]
    other[1, 1] = False  # one that shows the same says nothing
    assert np.isnan(photometry.blur_beside(detail, NEAR, other)[1])


def test_frames_show_the_same_by_their_grey_levels_which_blur_leaves():
    """A wall, the same blurred and brighter, a curtain, and a frame that is clipped to white."""
    rng = np.random.default_rng(0)
    wall, curtain = (cv2.resize(rng.uniform(10, 200, (6, 6)), (GRID, GRID)) for _ in range(2))
    grey = np.array([wall, 1.2 * cv2.blur(wall, (3, 3)), curtain, 0 * wall], np.float32)
    color = np.repeat(grey[:, None], 3, axis=1)
    nothing = np.zeros((4, GRID, GRID), np.float32)
    cells = Cells(nothing[:, None], nothing, color)
    assert photometry.same_content(cells, NEAR).tolist() == [
        [True, False, False],
        [True, False, False],
        [False, False, False],
        [False, False, False],
    ]


def seen(frames=10, points=60, seed=0):
    """Cells of frames that all see the same points, each place with a detail of its own."""
    rng = np.random.default_rng(seed)
    cells = rng.permutation(GRID * GRID)[:points]
    energy = np.zeros((frames, 4, GRID * GRID), np.float32)
    energy[:, :, cells] = rng.uniform(1, 90, points)
    variance = np.zeros((frames, GRID * GRID), np.float32)
    variance[:, cells] = 100
    frame, point = (part.ravel() for part in np.indices((frames, points)))
    return energy, variance, cells[point], point, frame


def judged(energy, variance, cell, point, frame):
    shape = (len(energy), -1, GRID, GRID)
    color = np.zeros((len(energy), 3, GRID, GRID), np.float32)
    cells = Cells(energy.reshape(shape), variance.reshape(shape)[:, 0], color)
    return photometry.blur_at_points(cells, cell, point, frame)


def test_places_are_compared_with_themselves():
    energy, *rest = seen()
    np.testing.assert_allclose(judged(energy, *rest), 1)
    energy[4:7, 2] /= 9  # a stretch, along one direction
    np.testing.assert_allclose(judged(energy, *rest), [1] * 4 + [9] * 3 + [1] * 3, rtol=1e-5)


def test_few_places_or_short_tracks_say_nothing():
    energy, variance, cell, point, frame = seen()
    few = (frame != 3) | (point < 15)
    times = judged(energy, variance, cell[few], point[few], frame[few])
    assert np.flatnonzero(np.isnan(times)).tolist() == [3]
    short = frame < 3
    times = judged(energy, variance, cell[short], point[short], frame[short])
    assert np.isnan(times).all()
    nothing = np.empty(0, np.int64)
    assert np.isnan(judged(energy, variance, nothing, nothing, nothing)).all()
