"""Errors of poses, worked by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import capture_of, random_capture

from fsel.captures.poses.agreement import pose_errors

OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)])


def posed(centers):
    """(N, 3, 4) poses at the centres, turned at random."""
    turns = Rotation.random(len(centers), rng=np.random.default_rng(0)).as_matrix()
    return capture_of(np.asarray(centers, float), turns).world_to_camera


def moved(poses, rotation, shift, scale):
    """The same cameras in a world x' = scale * rotation x + shift."""
    turned = poses[:, :, :3] @ rotation.T
    return np.concatenate([turned, scale * poses[:, :, 3:] - (turned @ shift)[..., None]], axis=2)


def test_another_world_is_no_error():
    poses = random_capture(12).world_to_camera
    world = Rotation.from_rotvec([2.0, 0.4, -1]).as_matrix(), np.array([1.0, 2, 3]), 0.01
    for error in pose_errors(moved(poses, *world), poses):
        np.testing.assert_allclose(error, 0, atol=1e-4)


def test_errors_of_poses_worked_by_hand():
    found = posed(OCTAHEDRON)
    given = posed(OCTAHEDRON * [4, 1, 1])
    # by symmetry nothing turns or shifts; the scale is (2 * 4 + 4 * 1) / 6 = 2: the farthest
    # centres, 4 away, are missed by 2, the others by 1
    turn = Rotation.from_rotvec(np.radians([[0, 0, 30]] + 5 * [[0, 0, 0]])).as_matrix()
    degrees, percent = pose_errors(turn @ found, given)
    np.testing.assert_allclose(percent, [50, 25, 25, 50, 25, 25], atol=1e-9)
    np.testing.assert_allclose(degrees, [30, 0, 0, 0, 0, 0], atol=1e-5)


def test_centres_in_one_place_are_refused():
    poses = posed(np.zeros((5, 3)))
    with pytest.raises(ValueError, match="5 camera centres on a line or point"):
        pose_errors(poses, poses)
