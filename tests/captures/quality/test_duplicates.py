"""Frames equal to their neighbours."""

import cv2
import numpy as np
import pytest

from fsel.captures.quality.photometry import duplicates, moved


@pytest.fixture(scope="module")
def wide():
    """A texture of several scales, 400 x 700 pixels."""
    rng = np.random.default_rng(0)
    layers = [cv2.GaussianBlur(rng.normal(size=(400, 700)), (0, 0), s) * s for s in (2, 6, 18)]
    return 128 + 100 * sum(layers)


def film(wide, places, noise=0.0):
    """(n, 72, 96) thumbnails of a window of 480 x 360 pixels that begins at some columns."""
    rng = np.random.default_rng(1)
    shots = [cv2.getRectSubPix(wide.astype(np.float32), (480, 360), (240 + x, 200)) for x in places]
    noisy = [np.clip(shot + rng.normal(0, noise, shot.shape), 0, 255) for shot in shots]
    return np.array([cv2.resize(s, (96, 72), interpolation=cv2.INTER_AREA) for s in noisy])


@pytest.mark.parametrize("pixels", [0.5, 1, 2, 4, 8])
def test_a_shift_is_measured(wide, pixels):
    first, second = film(wide, [0, pixels])
    assert moved(first, second) == pytest.approx(pixels / 480, rel=0.5)
    assert moved(first, 0.8 * second + 9) == pytest.approx(moved(first, second), rel=1e-6)


def test_a_pause_is_thinned_to_one_frame(wide):
    places = [*range(0, 50, 5), *([50] * 30), *range(55, 105, 5)]
    keep = duplicates(film(wide, places, noise=4.0).round().astype(np.uint8))
    assert np.flatnonzero(~keep).tolist() == list(range(11, 40))


def test_a_creeping_camera_goes_on(wide):
    keep = duplicates(film(wide, np.arange(0, 60, 0.5)))
    gaps = np.diff(np.flatnonzero(keep))
    assert 2 <= gaps.min() <= gaps.max() <= 6


def test_blank_images_are_equal_and_a_picture_is_not(wide):
    blank, shown = np.full((72, 96), 40.0), film(wide, [0])[0]
    assert duplicates(np.array([blank, blank + 3, shown, shown, blank])).tolist() == [
        True, False, True, False, True,
    ]  # fmt: skip


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_to_compare(count):
    assert duplicates(np.zeros((count, 9, 9), np.uint8)).tolist() == [True] * count
