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
    visibility_gain,
    with_sight,
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
    return visibility(frames, view, distance, np.array([depth])).seen[0]


def test_points_lie_behind_a_grid_of_pixels_at_four_depths():
    points = view_points(cameras((0, 0, 0), (1, 2, 3)), np.array([2.0, 2.0]))
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
    visible = visibility(frames, cameras((0, 0, 0)), distance, np.ones(1))
    np.testing.assert_array_equal(visible.nearest[0], np.arange(NEAREST + 2, 2, -1))
    assert visible.seen.shape == (1, NEAREST, 120)


def sights_of(rows, visible):
    sights = np.zeros((2, *visible.seen.shape[::2]))
    for row in rows:
        sights = with_sight(sights, visible, row)
    return sights


def test_sights_are_summed_over_the_rows_that_a_view_asks_or_the_best_two_kept():
    seen = np.array([[[1, 0.5], [0, 0.25]], [[0.25, 0], [0.5, 1]]])
    visible = Visibility(np.array([[2, 0], [0, 1]]), seen)
    np.testing.assert_array_equal(sights_of([0, 2], visible)[0], [[1, 0.75], [0.25, 0]])
    best = sights_of([0, 2, 1], visible._replace(two=True))
    np.testing.assert_array_equal(best[0], [[1, 0.5], [0.5, 1]])
    np.testing.assert_array_equal(best[1], [[0, 0.25], [0.25, 0]])


def test_the_gain_of_the_best_two_is_what_they_and_their_shares_grow_by():
    visible = Visibility(np.array([[3]]), np.array([[[0.9, 0.5, 0.1, 0.0]]]), two=True)
    sights = np.array([[[0.6, 0.6, 0.6, 0.0]], [[0.2, 0.2, 0.2, 0.0]]])
    gain = visibility_gain(visible, sights, 5)
    assert gain[3] == pytest.approx((0.3 + 0.7 * 0.4 + 0.7 * 0.3) * 2 / 3 / 4)
    assert np.flatnonzero(gain).tolist() == [3]


def test_the_gain_is_the_slope_of_the_chances_of_one_and_of_two_counts():
    def worth(rate):
        return (1 - np.exp(-rate)) + (1 - (1 + rate) * np.exp(-rate))

    rate, step = np.array([[0.3, 1.7]]), 1e-6
    visible = Visibility(np.array([[0]]), np.ones((1, 1, 2)))
    slope = (worth(rate + step) - worth(rate - step)).mean() / (2 * step)
    assert visibility_gain(visible, np.stack([rate, 0 * rate]), 1)[0] == pytest.approx(
        slope, rel=1e-6
    )


def test_nothing_is_gained_where_it_is_not_read():
    np.testing.assert_array_equal(visibility_gain(NOTHING, np.zeros((2, 0, 0)), 3), 0)


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
    distance, depths = rng.uniform(size=(12, 5)), rng.uniform(1, 3, 5)
    points, visible = view_points(views, depths), visibility(frames, views, distance, depths)
    want = [
        [[slow_sight(frames, row, p, views.centers[o]) for p in points[o]] for row in rows]
        for o, rows in enumerate(visible.nearest)
    ]
    assert 0.05 < np.mean(np.array(want) > 0) < 0.95
    np.testing.assert_allclose(visible.seen, want, rtol=1e-9)
