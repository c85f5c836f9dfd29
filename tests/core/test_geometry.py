"""Angles and distances by hand, at the ends where careless formulas fail."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fsel.core.geometry import (
    camera_centers,
    directions,
    invert_pose,
    line_equations,
    pairwise_angles,
    pairwise_distances,
    pixel_rays,
    pose_distance,
    poses_at,
    reference_points,
    upright,
    upwards,
    viewing_angles,
)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 0.3, np.pi / 2, np.pi - 1e-8, np.pi])
def test_angles_keep_their_precision_near_zero_and_pi(angle):
    a = np.array([1.0, 0, 0])
    b = np.array([np.cos(angle), np.sin(angle), 0])
    assert viewing_angles(a, b) == pytest.approx(angle, rel=1e-12, abs=1e-15)


def test_every_pair_is_measured():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(5, 3)), rng.normal(size=(7, 3))
    unit_a = a / np.linalg.norm(a, axis=1, keepdims=True)
    unit_b = b / np.linalg.norm(b, axis=1, keepdims=True)
    distance, angle = pairwise_distances(a, b), pairwise_angles(unit_a, unit_b)
    np.testing.assert_allclose(distance, np.sqrt(((a[:, None] - b) ** 2).sum(axis=2)))
    np.testing.assert_allclose(angle, np.arccos(unit_a @ unit_b.T))


def test_distances_survive_a_far_origin():
    a = np.array([[1e8, 0, 0]])
    assert pairwise_distances(a, a + [[0, 0.5, 0]])[0, 0] == 0.5


def test_pose_distance_weighs_both_parts_alike():
    x, y = [1.0, 0, 0], [0, 1.0, 0]
    centers, axes = np.array([[0.0, 0, 0], [4, 0, 0]]), np.array([x, y])
    got = pose_distance(centers, axes, np.zeros((1, 3)), np.array([x]))
    np.testing.assert_allclose(got, [[0.0], [2.0]], atol=1e-15)
    turned = pose_distance(centers, np.array([x, x]), np.zeros((1, 3)), np.array([x]))
    np.testing.assert_allclose(turned, [[0.0], [1.0]], atol=1e-15)
    same = np.zeros((3, 3)), np.tile(x, (3, 1))
    np.testing.assert_array_equal(pose_distance(*same, *same), np.zeros((3, 3)))


def test_reference_point_is_the_closest_of_the_forward_ray():
    centers = np.zeros((2, 3))
    axes = np.array([[0.0, 0, 1], [0, 0, -1]])
    points = reference_points(centers, axes, np.array([1.0, 2.0, 5.0]))
    np.testing.assert_allclose(points, [[0, 0, 5], [0, 0, 0]])


def test_a_point_at_the_origin_has_no_direction():
    found = directions(np.array([[1.0, 1, 1], [1, 1, 3]]), np.ones(3))
    np.testing.assert_array_equal(found, [[0, 0, 0], [0, 0, 1]])


def test_a_pose_put_together_is_where_it_was_put():
    quarter = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    pose = poses_at(np.array([[1.0, 2, 3]]), quarter[None])
    np.testing.assert_allclose(pose[0, :, 3], [-3, -2, 1], atol=1e-12)
    np.testing.assert_allclose(camera_centers(pose), [[1, 2, 3]], atol=1e-12)
    np.testing.assert_allclose(invert_pose(pose)[0, :, 3], [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(invert_pose(pose[0])[:, :3], quarter.T, atol=1e-12)


def test_a_world_is_turned_upright_by_the_smallest_rotation():
    rng = np.random.default_rng(0)
    for _ in range(20):
        level = Rotation.from_euler("zx", rng.uniform(-1, 1, (9, 2)) * [3, 0.3]).as_matrix()
        level = level @ np.diag([1.0, -1, -1])[[0, 2, 1]]  # horizontal axes in the xy plane
        tilt = Rotation.random(random_state=rng).as_matrix()
        poses = poses_at(rng.normal(size=(9, 3)), np.swapaxes(level, 1, 2) @ tilt)
        up, turn = upwards(poses), upright(poses)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1)
        np.testing.assert_allclose(turn @ up, [0, 0, 1], atol=1e-9)
        np.testing.assert_allclose(upwards(poses[:, :, :3] @ turn.T), [0, 0, 1], atol=1e-9)
        assert Rotation.from_matrix(turn).magnitude() == pytest.approx(np.arccos(up[2]))
    over = np.array([[[1.0, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 0], [0, 0, 1], [1, 0, 0]]])
    np.testing.assert_array_equal(upright(poses_at(np.zeros((2, 3)), over)), np.diag([1, -1, -1]))


def test_centres_keep_float32():
    assert camera_centers(np.eye(3, 4, dtype=np.float32)[None]).dtype == np.float32


def test_rays_go_through_the_middles_of_pixels():
    rays = pixel_rays(np.array([2.0, 4.0, 1.0, 0.5]), 3, 2)
    np.testing.assert_array_equal(rays[0, 0], [-0.25, 0, 1])
    np.testing.assert_array_equal(rays[1, 2], [0.75, 0.25, 1])


def test_the_point_nearest_to_lines_by_hand():
    """Lines along x at height 0 and along y at height 3: midway, or nearer the heavier one."""
    points, axes = np.array([[5.0, 0, 0], [0, 7, 3]]), np.array([[1.0, 0, 0], [0, 1, 0]])
    matrix, right, across = line_equations(points, axes)
    np.testing.assert_allclose(np.linalg.solve(matrix, right), [0, 0, 1.5], atol=1e-12)
    np.testing.assert_array_equal(across[0], np.diag([0.0, 1, 1]))
    matrix, right, _ = line_equations(points, axes, np.array([2.0, 1]))
    np.testing.assert_allclose(np.linalg.solve(matrix, right), [0, 0, 1], atol=1e-12)
