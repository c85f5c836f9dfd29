"""Sparse points keep their observations in step, and their groups are found by slow twins."""

import numpy as np
import pytest

from fsel.core.points import RawPoints, grouped_rows, quantile_of

POINTS = RawPoints(
    xyz=np.arange(9.0).reshape(3, 3),
    rgb=np.arange(9, dtype=np.uint8).reshape(3, 3),
    track_point=np.array([0, 1, 2, 2]),
    track_frame=np.array([0, 0, 1, 3]),
    track_xy=np.arange(8.0).reshape(4, 2),
    error=np.array([0.1, 0.2, 0.3]),
)


def test_some_points_take_their_observations_along():
    some = POINTS.subset(np.array([True, False, True]))
    np.testing.assert_array_equal(some.xyz, POINTS.xyz[[0, 2]])
    np.testing.assert_array_equal(some.rgb, POINTS.rgb[[0, 2]])
    np.testing.assert_array_equal(some.error, [0.1, 0.3])
    np.testing.assert_array_equal(some.track_point, [0, 1, 1])
    np.testing.assert_array_equal(some.track_frame, [0, 1, 3])
    np.testing.assert_array_equal(some.track_xy, POINTS.track_xy[[0, 2, 3]])


def test_some_frames_see_what_they_saw_and_are_numbered_anew():
    seen = POINTS.seen_from(np.array([3, 0]), 4)
    np.testing.assert_array_equal(seen.xyz, POINTS.xyz)
    np.testing.assert_array_equal(seen.track_point, [0, 1, 2])
    np.testing.assert_array_equal(seen.track_frame, [1, 1, 0])
    np.testing.assert_array_equal(seen.track_xy, POINTS.track_xy[[0, 1, 3]])


@pytest.mark.parametrize("count", [4, 255, 256, 65_535, 65_536, 65_537, 1 << 20])
def test_rows_of_every_key_also_at_the_ends_of_few_bytes(count):
    keys = np.random.default_rng(count).choice([count - 1, 0, count - 2, count // 2], 50)
    rows = grouped_rows(keys, count)
    assert all(rows[key].tolist() == np.flatnonzero(keys == key).tolist() for key in keys)
    assert sum(len(row) for row in rows) == 50


@pytest.mark.parametrize("each", [9, 500])
@pytest.mark.parametrize("share", [0.0, 0.5, 0.9, 1.0])
def test_lower_quantiles_of_small_and_of_large_groups(each, share):
    rng = np.random.default_rng(0)
    keys, values = rng.integers(0, 6, 7 * each), rng.integers(0, 9, 7 * each) / 8
    values[0] = np.nan
    found = quantile_of(values, keys, 7, share)
    own = [np.sort(values[keys == key]) for key in range(6)]
    by_hand = [one[int(share * (len(one) - 1))] for one in own]
    np.testing.assert_array_equal(found, [*by_hand, np.nan])
