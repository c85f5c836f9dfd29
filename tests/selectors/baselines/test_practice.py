"""What tools do before poses are known: hand-worked cases."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from selection_problems import in_line, problem_of

from fsel.selectors.baselines import PRACTICE, before_poses
from fsel.selectors.baselines.before_poses import farthest


def picks(name, k, images=None, **seen):
    """What a method picks of frames that are all observed."""
    n = len(next(iter(seen.values())) if images is None else images)
    capture = in_line(range(n))
    if images is not None:
        capture = replace(capture, images=np.repeat(images[..., None], 3, axis=3))
    problem = problem_of(capture, [0], np.arange(1, n), **seen)
    return PRACTICE[name].select(problem, k, np.random.default_rng(0)).tolist()


def test_best_n_weighs_sharpness_against_position():
    assert picks("best_n", 2, sharpness=[0, 0, 0, 9, 9, 0, 0, 0]) == [3, 7]  # at least 4 on
    # 0.7 * 0.9 + 0.3 * 3/4 > 0.7 + 0.3 * 1/4
    assert picks("best_n", 2, sharpness=[10, 9, 0, 0, 0, 0, 0, 10]) == [1, 7]
    assert picks("best_n", 2, sharpness=[5] * 8) == [1, 5]  # the middles


def test_a_thumbnail_is_the_frame_nearest_to_the_mean_histogram_of_its_batch():
    levels = np.array([0, 9, 9, 5, 1, 5], np.uint8)  # off by 2/3 of the pixels, or by 1/3
    assert picks("thumbnail", 2, np.tile(levels[:, None, None], (1, 4, 4))) == [1, 3]


def test_what_most_others_resemble_comes_first():
    angle = np.radians([0, 10, 20, 80])  # sums of cosines: 3.1, 3.3, 3.4, 2.0
    described = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert farthest(described, 4).tolist() == [2, 3, 0, 1]


def test_alicevision_cuts_stretches_of_equal_motion():
    moved = np.array([1, 1, 4, 1, 1, 0.5, 3])  # from row to row
    assert [row.tolist() for row in before_poses.stretches(moved, 4)] == [
        [0, 1, 2],
        [3, 4, 5, 6],
        [7],
    ]
    assert len(before_poses.stretches(moved, 0)) == 8
    np.testing.assert_allclose(before_poses.weights(5), [1, 1.5, 2, 1.5, 1])
    np.testing.assert_allclose(before_poses.weights(4), [4 / 3, 2, 2, 4 / 3])
    assert before_poses.weights(1) == 2


def test_alicevision_weighs_sharpness_in_a_window_against_the_middle():
    spot = np.zeros((36, 36), np.uint8)
    spot[18, 18] = 9  # Laplacian: -36 and four times 9, in a window of ten pixels
    assert before_poses.sharpness(spot) == pytest.approx(9 * np.sqrt(20 / 100))
    noise = np.random.default_rng(0).integers(0, 255, (10, 20), np.uint8)
    wall = cv2.resize(noise, (240, 120), interpolation=cv2.INTER_CUBIC)
    images = np.array([wall[:, s : s + 160] for s in (0, 4, 8, 12, 16, 20, 24, 32, 40, 48)])
    assert before_poses.motion(images[7], images[6]) == pytest.approx(8, abs=0.1)
    images[2] = cv2.blur(images[2], (3, 3))
    assert picks("alicevision", 3, images) == [3, 7, 9]  # 24 pixels each: rows 0-5, 6-8 and 9
    assert picks("alicevision", 3, images[[0] * 9]) == [0, 4, 8]  # nothing moves: evenly
