"""Noise in poses and errors of poses, worked by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import capture_of, random_capture

from fsel.experiments.paper.pose_errors import perturbed, pose_errors, scene_size

OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)])


def posed(centers, seed=0):
    """(N, 3, 4) poses at the centres, turned at random."""
    rng = np.random.default_rng(seed)
    turns = Rotation.random(len(centers), rng=rng).as_matrix()
    return capture_of(np.asarray(centers, float), turns).world_to_camera


def centers_of(poses):
    return -np.einsum("nij,ni->nj", poses[:, :, :3], poses[:, :, 3])


def moved(poses, rotation, shift, scale):
    """The same cameras in a world x' = scale * rotation x + shift."""
    turned = poses[:, :, :3] @ rotation.T
    return np.concatenate([turned, scale * poses[:, :, 3:] - (turned @ shift)[..., None]], axis=2)


def angles(first, second):
    relative = first[:, :, :3] @ second[:, :, :3].transpose(0, 2, 1)
    return np.degrees(Rotation.from_matrix(relative).magnitude())


class Drawn:
    """Draws what it is told, in order."""

    def __init__(self, *values):
        self.values = list(values)

    def normal(self, size):
        value = np.array(self.values.pop(0), float)
        assert value.shape == size
        return value


def test_the_scene_is_as_large_as_its_farthest_camera():
    assert scene_size(posed([(0, 0, 0), (4, 0, 0), (2, 7, 0), (2, 1, 0)])) == pytest.approx(5.0)


def test_a_disturbed_camera_worked_by_hand():
    # two cameras 6 apart, so that the size is 3; 20 % of it is 0.6, along each axis 0.6 / sqrt(3)
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, 0, 3] = -6.0
    rng = Drawn([(0, 0, 2), (0, 5, 0)], [[1], [0]], [(0, np.sqrt(3), 0), (0, 0, 0)])
    found = perturbed(poses, 90, 20, rng)
    # the first turns by 90 degrees about its z axis and moves by 0.6 along its y axis
    np.testing.assert_allclose(found[0, :, :3], [(0, -1, 0), (1, 0, 0), (0, 0, 1)], atol=1e-15)
    np.testing.assert_allclose(centers_of(found), [(0, 0.6, 0), (6, 0, 0)], atol=1e-15)
    np.testing.assert_array_equal(found[1], poses[1])


def test_no_noise_changes_nothing():
    poses = random_capture(20).world_to_camera
    before = poses.copy()
    np.testing.assert_array_equal(perturbed(poses, 0, 0, np.random.default_rng(1)), poses)
    perturbed(poses, 5, 5, np.random.default_rng(1))
    np.testing.assert_array_equal(poses, before)


def test_noise_has_the_size_that_was_asked_for():
    poses = posed(np.random.default_rng(3).normal(size=(20_000, 3)))
    turned = perturbed(poses, 4, 0, np.random.default_rng(5))
    assert np.sqrt(np.mean(angles(turned, poses) ** 2)) == pytest.approx(4, rel=0.02)
    np.testing.assert_allclose(centers_of(turned), centers_of(poses), atol=1e-12)
    shifted = perturbed(poses, 0, 7, np.random.default_rng(5))
    offsets = centers_of(shifted) - centers_of(poses)
    wanted = 0.07 * scene_size(poses)
    assert np.sqrt(np.mean(np.sum(offsets**2, axis=1))) == pytest.approx(wanted, rel=0.02)
    np.testing.assert_allclose(offsets.std(axis=0), wanted / np.sqrt(3), rtol=0.03)
    np.testing.assert_array_equal(shifted[:, :, :3], poses[:, :, :3])


def test_disturbed_poses_are_rigid():
    rotation = perturbed(random_capture(50).world_to_camera, 60, 30, np.random.default_rng(2))
    rotation = rotation[:, :, :3]
    np.testing.assert_allclose(np.linalg.det(rotation), 1, atol=1e-13)
    gram = rotation @ rotation.transpose(0, 2, 1)
    np.testing.assert_allclose(gram, np.tile(np.eye(3), (50, 1, 1)), atol=1e-13)


def test_the_world_s_frame_and_unit_have_no_say_in_the_noise():
    poses = random_capture(15).world_to_camera
    world = Rotation.from_rotvec([0.3, -1, 2]).as_matrix(), np.array([5.0, -7, 1]), 40.0
    first, second = (
        perturbed(given, 10, 10, np.random.default_rng(4))
        for given in (poses, moved(poses, *world))
    )
    np.testing.assert_allclose(second, moved(first, *world), atol=1e-10)


def test_levels_differ_in_length_alone():
    poses = random_capture(15).world_to_camera
    low, high = (perturbed(poses, level, level, np.random.default_rng(4)) for level in (2, 6))
    np.testing.assert_allclose(angles(high, poses), 3 * angles(low, poses), rtol=1e-6)
    offsets = [centers_of(found) - centers_of(poses) for found in (low, high)]
    np.testing.assert_allclose(offsets[1], 3 * offsets[0], rtol=1e-9)


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
