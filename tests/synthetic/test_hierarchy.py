"""Rays among triangles, held against every ray tried on every triangle in float64."""

import numpy as np
import pytest

from fsel.synthetic import hierarchy


def slow_hits(triangles, origins, rays):
    """(n, t) distances in float64, infinite where a ray does not meet a triangle."""
    a, b, c = triangles.astype(float).transpose(1, 0, 2)
    out = np.full((len(rays), len(triangles)), np.inf)
    for i, (origin, ray) in enumerate(zip(origins.astype(float), rays.astype(float), strict=True)):
        for j in range(len(triangles)):
            sides = np.column_stack([a[j] - b[j], a[j] - c[j], ray])
            if abs(np.linalg.det(sides)) < 1e-12:
                continue
            u, v, t = np.linalg.solve(sides, a[j] - origin)
            if u >= 0 and v >= 0 and u + v <= 1 and t > 0:
                out[i, j] = t
    return out


def scattered(seed, count, size=0.2):
    """Random triangles in a unit cube, origins beside it, and unit rays into it."""
    rng = np.random.default_rng(seed)
    corners = rng.random((count, 1, 3)) + rng.normal(0, size, (count, 3, 3))
    origins = rng.normal(0, 2, (101, 3))
    rays = rng.random((101, 3)) - origins
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return [np.ascontiguousarray(x, np.float32) for x in (corners, origins, rays)]


@pytest.mark.parametrize("count", [1, 4, 5, 300])
def test_first_hits_are_those_of_trying_every_triangle(count):
    triangles, origins, rays = scattered(count, count)
    distances = slow_hits(triangles, origins, rays)
    which, reach = hierarchy.first_hit(hierarchy.build(triangles), origins, rays)
    assert np.array_equal(which >= 0, np.isfinite(distances.min(axis=1)))
    hit = which >= 0
    assert np.array_equal(which[hit], distances.argmin(axis=1)[hit])
    np.testing.assert_allclose(reach, distances.min(axis=1), rtol=1e-5)


def test_shadows_are_cast_by_what_is_nearer_than_the_light():
    triangles, origins, rays = scattered(3, 40)
    least = slow_hits(triangles, origins, rays).min(axis=1)
    tree = hierarchy.build(triangles)
    for far in (0.5, 1.5, np.inf):
        reach = np.full(len(rays), far, np.float32)
        assert np.array_equal(hierarchy.occluded(tree, origins, rays, reach), least < far)
        assert (reach == far).all()  # what was given is not written to


def test_a_ray_has_the_same_hit_whichever_rays_are_followed_beside_it():
    triangles, origins, rays = scattered(7, 200)
    tree = hierarchy.build(triangles)
    which, reach = hierarchy.first_hit(tree, origins, rays)
    order = np.random.default_rng(0).permutation(len(rays))
    again = hierarchy.first_hit(tree, origins[order], rays[order])
    assert np.array_equal(again[0], which[order])
    assert np.array_equal(again[1], reach[order])


def test_of_two_triangles_in_one_place_the_first_is_met_whatever_their_order():
    rng = np.random.default_rng(1)
    triangles = np.array([[[0, 0, 2], [4, 0, 2], [0, 4, 2]]], np.float32).repeat(20, axis=0)
    triangles[10:] = rng.random((10, 3, 3)) + [0, 0, 5]  # farther ones
    origins = np.array([[1, 1, 0]], np.float32)
    rays = np.array([[0, 0, 1]], np.float32)
    which, reach = hierarchy.first_hit(hierarchy.build(triangles), origins, rays)
    assert (which[0], reach[0]) == (0, 2)
    which, _ = hierarchy.first_hit(hierarchy.build(triangles[::-1].copy()), origins, rays)
    assert which[0] == 10


def test_rays_along_the_axes_and_in_the_plane_of_a_wall():
    """A wall in the plane x = 1 is met from in front; a ray within that plane meets nothing."""
    wall = np.array([[[1, -1, -1], [1, 1, -1], [1, 0, 1]]], np.float32)
    origins = np.array([[0, 0, 0], [2, 0, 0], [1, 0, -3], [0, 0, 0], [0, 3, 0]], np.float32)
    rays = np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [-1, 0, 0], [1, 0, 0]], np.float32)
    which, reach = hierarchy.first_hit(hierarchy.build(wall), origins, rays)
    assert which.tolist() == [0, 0, -1, -1, -1]
    assert reach.tolist() == [1, 1, np.inf, np.inf, np.inf]


def test_triangles_without_area_and_many_in_one_point_are_no_obstacle():
    points = np.zeros((100, 3, 3), np.float32)
    line = np.array([[[0, 0, 1], [1, 0, 1], [2, 0, 1]]], np.float32)
    wall = np.array([[[-9, -9, 3], [9, -9, 3], [0, 9, 3]]], np.float32)
    tree = hierarchy.build(np.concatenate([points, line, wall]))
    origins = np.array([[0, 0, -1], [0.5, 0, 0]], np.float32)
    which, reach = hierarchy.first_hit(tree, origins, np.array([[0, 0, 1]] * 2, np.float32))
    assert which.tolist() == [101, 101]
    assert reach.tolist() == [4, 3]
