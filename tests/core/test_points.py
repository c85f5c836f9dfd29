"""Sparse points keep their observations in step."""

import numpy as np

from fsel.core.points import RawPoints

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
