"""Flights: through the frames, at an even speed, at any size."""

import numpy as np
import pytest
from small_captures import ring

from fsel.core.capture import Capture, Views
from fsel.selection.flights import between, flight

K = np.array([60.0, 61, 32, 24])


def views(poses, size=(64, 48)):
    return Views(poses, np.tile(K, (len(poses), 1)), size)


def test_a_flight_passes_through_its_views_at_an_even_speed():
    known = views(ring(24)[:9])
    flown = between(known, 161)
    np.testing.assert_allclose(flown.world_to_camera[::20], known.world_to_camera, atol=1e-9)
    ways = np.linalg.norm(np.diff(flown.centers, axis=0), axis=1)
    assert ways.max() < 1.1 * ways.min()
    np.testing.assert_allclose(np.linalg.det(flown.world_to_camera[:, :, :3]), 1)
    np.testing.assert_allclose(np.linalg.norm(flown.centers, axis=1), 17**0.5, rtol=5e-3)


def test_a_flight_takes_no_time_for_no_way_and_stands_still_at_one_view():
    poses = ring(24)[[0, 0, 3, 3, 6]]
    flown = between(views(poses), 101)
    ways = np.linalg.norm(np.diff(flown.centers, axis=0), axis=1)
    assert (ways < 1e-6).sum() <= 12
    np.testing.assert_array_equal(between(views(poses[:1]), 4).world_to_camera, poses[[0] * 4])
    same = between(views(poses[[0, 0]]), 5)
    np.testing.assert_allclose(same.world_to_camera, poses[[0] * 5], atol=1e-12)


@pytest.mark.parametrize("request_", ["orbit", "trajectory", "every:8", [3, 9]])
def test_views_are_as_many_and_as_large_as_asked_and_see_the_same(request_):
    poses = ring(24)
    images = np.zeros((24, 48, 64, 3), np.uint8)
    names = tuple(map(str, range(24)))
    capture = Capture(names, poses, np.tile(K, (24, 1)), images, sequences=("",) * 24)
    flown = flight(capture, request_, 100, 1280)
    assert (len(flown), flown.size) == (100, (1280, 960))
    np.testing.assert_allclose(flown.intrinsics, np.tile(K * 20, (100, 1)))
