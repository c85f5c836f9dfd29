"""Points that views look at, and how much frames see of them."""

import numpy as np
import pytest
from slow_selector import slow_sight

from fsel.core.capture import Views
from fsel.features.conditioned import (
    NEAREST,
    NOTHING,
    Visibility,
    view_points,
    visibility,
    visibility_counts,
    visibility_gain,
)

SIZE = (60, 50)


def cameras(*centers, turned=()):
    """Views along z, focal length 30; those `turned` look backwards."""
    rotations = np.tile(np.eye(3), (len(centers), 1, 1))
    rotations[list(turned)] = np.diag([-1.0, 1.0, -1.0])
    shift = -np.einsum("nij,nj->ni", rotations, np.array(centers, float))
    poses = np.concatenate([rotations, shift[..., None]], axis=2)
    return Views(poses, np.tile([30.0, 30.0, 30.0, 25.0], (len(centers), 1)), SIZE)


def seen_by(frames, view, depth=2.0):
    distance = np.zeros((len(frames), 1))
    return visibility(frames, view, distance, depth).seen[0]


def test_points_lie_behind_a_grid_of_pixels_at_four_depths():
    points = view_points(cameras((0, 0, 0), (1, 2, 3)), 2.0)
    assert points.shape == (2, 120, 3)
    np.testing.assert_allclose(np.unique(points[0, :, 2]), [1, 2, 4, 8])
    # the first pixel of the grid is (5, 5), the next across (15, 5)
    first = points[0][np.isclose(points[0, :, 2], 4)]
    across = (np.array([5, 15, 25, 35, 45, 55]) - 30) / 30 * 4
    np.testing.assert_allclose(np.unique(first[:, 0]), across, atol=1e-12)
    np.testing.assert_allclose(np.unique(first[:, 1]), (np.arange(5, 50, 10) - 25) / 30 * 4)
    np.testing.assert_allclose(points[1] - points[0], np.tile([1, 2, 3], (120, 1)))


def test_the_view_itself_sees_all_and_one_that_looks_away_nothing():
    seen = seen_by(cameras((0, 0, 0), (0, 0, 0), turned=[1]), cameras((0, 0, 0)))
    np.testing.assert_allclose(seen[0], 1)
    np.testing.assert_array_equal(seen[1], 0)


def test_of_many_frames_the_nearest_are_asked():
    frames = cameras(*np.zeros((NEAREST + 3, 3)))
    distance = np.arange(NEAREST + 3, 0, -1.0)[:, None]
    visible = visibility(frames, cameras((0, 0, 0)), distance, 1.0)
    np.testing.assert_array_equal(visible.nearest[0], np.arange(NEAREST + 2, 2, -1))
    assert visible.seen.shape == (1, NEAREST, 120)


def test_visibility_counts_are_summed_over_the_rows_that_a_view_asks():
    seen = np.array([[[1, 0.5], [0, 0.25]], [[0.25, 0], [1, 1]]])
    visible = Visibility(np.array([[2, 0], [0, 1]]), seen)
    for rows, counts in (([0, 2], [[1, 0.75], [0.25, 0]]), ([], np.zeros((2, 2)))):
        np.testing.assert_array_equal(visibility_counts(visible, np.array(rows, int)), counts)


def test_the_gain_is_the_slope_of_the_chances_of_one_and_of_two_counts():
    def worth(rate):
        return (1 - np.exp(-rate)) + (1 - (1 + rate) * np.exp(-rate))

    rate, step = np.array([[0.3, 1.7]]), 1e-6
    visible = Visibility(np.array([[0]]), np.ones((1, 1, 2)))
    slope = (worth(rate + step) - worth(rate - step)).mean() / (2 * step)
    assert visibility_gain(visible, rate, 1)[0] == pytest.approx(slope, rel=1e-6)


def test_nothing_is_gained_where_it_is_not_read():
    np.testing.assert_array_equal(visibility_gain(NOTHING, np.zeros((0, 0)), 3), 0)


def scattered(rng, count):
    """Views at random places that look at random, focal lengths of their own."""
    rotations = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    rotations *= np.linalg.det(rotations)[:, None, None]
    poses = np.concatenate([rotations, rng.normal(size=(count, 3, 1))], axis=2)
    intrinsics = np.column_stack([rng.uniform(20, 60, (count, 2)), rng.uniform(20, 35, (count, 2))])
    return Views(poses, intrinsics, SIZE)


def test_every_view_frame_and_point_for_itself():
    rng = np.random.default_rng(0)
    frames, views = scattered(rng, 12), scattered(rng, 5)
    distance, points = rng.uniform(size=(12, 5)), view_points(views, 2.0)
    visible = visibility(frames, views, distance, 2.0)
    want = [
        [[slow_sight(frames, row, p, views.centers[o]) for p in points[o]] for row in rows]
        for o, rows in enumerate(visible.nearest)
    ]
    assert 0.05 < np.mean(np.array(want) > 0) < 0.95
    np.testing.assert_allclose(visible.seen, want, rtol=1e-9)
