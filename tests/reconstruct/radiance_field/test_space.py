"""The contraction, and the pace of rays through it."""

import numpy as np
import pytest
import radiance_twin
import torch

from fsel.reconstruct.radiance_field import rays


@pytest.mark.parametrize(("r", "image"), [(0.3, 0.3), (1.0, 1.0), (2.0, 1.5), (4.0, 1.75)])
def test_the_largest_coordinate_moves_to_two_less_its_inverse(r, image):
    assert rays.shrink(r) * r == pytest.approx(image, rel=1e-15)


def test_pace_is_the_length_of_the_contracted_direction():
    rng = np.random.default_rng(0)
    for point in rng.normal(size=(40, 3)) * 2:
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        turn = torch.autograd.functional.jacobian(radiance_twin.contracted, torch.tensor(point))
        wanted = np.linalg.norm(turn.numpy() @ direction)
        assert rays.pace(*point, *direction) == pytest.approx(wanted, rel=1e-12)


def test_pace_along_an_axis_where_coordinates_are_zero():
    assert rays.pace(2.0, 0.0, 0.0, -1.0, 0.0, 0.0) == pytest.approx(0.25)
    assert rays.pace(0.0, 0.0, -4.0, 1.0, 0.0, 0.0) == pytest.approx((2 - 0.25) / 4)


def test_samples_of_a_ray_from_the_middle_are_one_a_cell():
    side, step = 41, 0.1
    cells, parts = np.empty(200, np.int64), np.empty((200, 3), np.float32)
    ray = np.array([0, 0, 0, 0, 0, 1], np.float32)
    occupied = np.ones(side**3, bool)
    count = rays.sample(ray, 0.0, 0.5, step, side, occupied, cells, parts)
    i, j, k = np.unravel_index(cells[:count], (side,) * 3)
    assert (i == 20).all()
    assert (j == 20).all()
    # inside the cube of half-side 1 exactly; outside, Euler's steps are a little short
    np.testing.assert_array_equal(k[:10], np.arange(20, 30))
    np.testing.assert_allclose(parts[:10, 2], 0.5, atol=1e-6)
    assert 20 <= count <= 24
    assert (np.diff(k) >= 0).all()


def test_a_ray_never_has_more_samples_than_there_is_room_for():
    rng = np.random.default_rng(1)
    side, step = 21, 0.2
    room = int(4 * np.sqrt(3) * rays.HALF_SIDE / step) + 2
    cells, parts = np.empty(10 * room, np.int64), np.empty((10 * room, 3), np.float32)
    most = 0
    for line in rng.normal(size=(3000, 6)).astype(np.float32):
        line[:3] *= rng.choice([0.1, 1, 10, 100])
        line[3:] /= np.linalg.norm(line[3:])
        most = max(
            most, rays.sample(line, 0.0, 1.0, step, side, np.ones(side**3, bool), cells, parts)
        )
    assert most < room
