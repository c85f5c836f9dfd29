"""Views behind what the cameras saw."""

import numpy as np
from selection_problems import capture_of

from fsel.core.points import SparsePoints
from fsel.selection.scene_depth import behind


def wall(spread, cameras):
    """Points on the plane z = 4, seen by all cameras, which look along z."""
    x, y = np.meshgrid(np.linspace(-spread, spread, 60), np.linspace(-2, 2, 30))
    xyz = np.stack([x.ravel(), y.ravel(), np.full(x.size, 4.0)], axis=1)
    points, frames = np.meshgrid(np.arange(len(xyz)), np.arange(cameras), indexing="ij")
    return SparsePoints(xyz, np.zeros((len(xyz), 3), np.uint8), points.ravel(), frames.ravel())


def test_a_view_behind_a_wall_is_told_from_one_before_it():
    centers = np.column_stack([np.linspace(-1, 1, 5), np.zeros(5), np.zeros(5)])
    cameras = capture_of(centers, np.tile(np.eye(3), (5, 1, 1))).views
    places = np.array([[0.0, 0, 2], [0, 0, 4.1], [0, 0, 6], [0.3, 0.1, 9], [0, 0, -3], [20, 0, 6]])
    views = capture_of(places, np.tile(np.eye(3), (6, 1, 1))).views
    # before it, at it, behind it twice, behind the cameras, beyond the wall's end
    hidden = behind(views, cameras, wall(3.0, 5))
    np.testing.assert_array_equal(hidden, [False, False, True, True, False, False])


def test_two_cameras_are_no_witnesses():
    cameras = capture_of(np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))).views
    view = capture_of(np.array([[0.0, 0, 6]]), np.eye(3)[None]).views
    assert not behind(view, cameras, wall(3.0, 2)).any()
