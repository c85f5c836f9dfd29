"""Views made from a capture's cameras: an orbit, a trajectory, the whole of it, views beside."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from selection_problems import around, capture_of
from small_captures import ring

from fsel.core.geometry import directions, upwards
from fsel.selection import paths
from fsel.selection.targets import targets_of


def is_rotation(views):
    rotation = views.world_to_camera[:, :, :3]
    product = rotation @ np.swapaxes(rotation, 1, 2)
    return np.allclose(product, np.eye(3)) and np.allclose(np.linalg.det(rotation), 1)


def test_an_orbit_keeps_the_cameras_distance_and_height_and_looks_at_their_point(circle):
    views = paths.orbit(circle, 12)
    np.testing.assert_allclose(np.hypot(views.centers[:, 0], views.centers[:, 2]), 4)
    np.testing.assert_allclose(views.centers[:, 1], -1)
    np.testing.assert_allclose(views.axes, directions(np.zeros(3), views.centers), atol=1e-9)
    turn = np.unwrap(np.arctan2(views.centers[:, 2], views.centers[:, 0]))
    np.testing.assert_allclose(np.abs(np.diff(turn)), np.pi / 6)
    assert is_rotation(views)
    np.testing.assert_allclose(views.world_to_camera[:, 1, 1] > 0, True)  # upright: y is down


def test_an_orbit_leaves_out_what_no_camera_filmed():
    half = around(ring(24)[:13])
    views = paths.orbit(half, 12)
    ends = half.centers[[0, 12]]
    gap = np.linalg.norm(views.centers[[0, -1], None] - ends, axis=2)
    np.testing.assert_allclose(gap.min(axis=1), 0, atol=1e-9)
    assert (views.centers[:, 2] > -1e-9).all()


def test_up_is_upright_on_a_straight_track_and_on_one_side_of_an_object():
    side = around(ring(24)[:5])
    np.testing.assert_allclose(upwards(side.world_to_camera), [0, -1, 0], atol=1e-9)
    tilt = cv2.Rodrigues(np.array([0.2, 0, 0]))[0]  # all look down alike: level is not known
    track = capture_of(np.arange(15.0).reshape(5, 3), np.tile(tilt, (5, 1, 1)))
    np.testing.assert_allclose(upwards(track.world_to_camera), -tilt[1], atol=1e-9)


def test_cameras_without_a_common_point_have_no_orbit():
    same = np.tile(np.eye(3), (5, 1, 1))
    with pytest.raises(ValueError, match="parallel lines"):
        targets_of(capture_of(np.arange(15.0).reshape(5, 3), same), "orbit")
    named = replace(capture_of(np.arange(15.0).reshape(5, 3), same), source="a folder")
    with pytest.raises(ValueError, match=r"^a folder: the cameras look along"):
        targets_of(named, "orbit")
    outward = ring(24)
    turned = np.diag([-1.0, 1, -1]) @ outward  # each about its own upright axis
    with pytest.raises(ValueError, match="use `trajectory`"):
        targets_of(around(turned), "orbit")


def test_a_trajectory_is_the_smoothed_path_of_each_pass(circle):
    views = paths.trajectory(circle, 50)
    radius = np.hypot(views.centers[:, 0], views.centers[:, 2])
    assert (np.abs(radius - 4) < 0.4).all()
    assert is_rotation(views)
    centers = np.zeros((20, 3))
    centers[:, 0] = np.arange(20)
    centers[10:, 1] = 100
    apart = capture_of(centers, np.tile(np.eye(3), (20, 1, 1)), sequences=("a",) * 10 + ("b",) * 10)
    heights = paths.trajectory(apart, 40).centers[:, 1]
    assert np.isclose(heights, 0).sum() == np.isclose(heights, 100).sum() == 20


def test_views_for_the_whole_capture_lie_among_the_cameras(circle):
    targets = targets_of(circle, None)
    assert targets.kind == "the whole capture"
    assert len(targets.views) == 24
    assert len(targets.frames) == 0
    assert is_rotation(targets.views)
    radius = np.hypot(targets.views.centers[:, 0], targets.views.centers[:, 2])
    assert ((radius > 3.4) & (radius <= 4 + 1e-9)).all()


def test_views_beside_others_are_shifted_and_turned_by_the_stated_spread(circle):
    views = circle.view(np.arange(24).repeat(40))
    both = paths.with_views_beside(views, circle)
    np.testing.assert_array_equal(both.world_to_camera[: len(views)], views.world_to_camera)
    off = both.subset(slice(len(views), None))
    assert is_rotation(off)
    shift = (off.centers - views.centers) / 4  # the circle's radius is its reach
    np.testing.assert_allclose(shift.std(axis=0), 0.2, rtol=0.1)
    turned = off.world_to_camera[:, :, :3] @ np.swapaxes(views.world_to_camera[:, :, :3], 1, 2)
    about = np.array([cv2.Rodrigues(turn)[0].ravel() for turn in turned])
    np.testing.assert_allclose(np.degrees(about.std(axis=0)), 12, rtol=0.1)


def test_views_beside_others_follow_the_world(circle):
    turn = cv2.Rodrigues(np.array([0.3, -0.2, 0.9]))[0]
    rotations = circle.world_to_camera[:, :, :3] @ turn.T
    moved = capture_of(3 * circle.centers @ turn.T + 7, rotations, size=(64, 48))
    here, there = (paths.with_views_beside(c.view(np.arange(9)), c) for c in (circle, moved))
    np.testing.assert_allclose(there.centers, 3 * here.centers @ turn.T + 7, atol=1e-9)
    np.testing.assert_allclose(there.axes, here.axes @ turn.T, atol=1e-12)
