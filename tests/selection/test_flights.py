"""Flights: through the frames, at an even speed, at any size."""

import numpy as np
import pytest
from selection_problems import around
from small_captures import ring

from fsel.selection.flights import between, flight


def test_a_flight_passes_through_its_views_at_an_even_speed(circle):
    known = circle.view(np.arange(9))
    flown = between(known, 161)
    np.testing.assert_allclose(flown.world_to_camera[::20], known.world_to_camera, atol=1e-9)
    ways = np.linalg.norm(np.diff(flown.centers, axis=0), axis=1)
    assert ways.max() < 1.1 * ways.min()
    np.testing.assert_allclose(np.linalg.det(flown.world_to_camera[:, :, :3]), 1)
    np.testing.assert_allclose(np.linalg.norm(flown.centers, axis=1), 17**0.5, rtol=5e-3)


def test_a_flight_takes_no_time_for_no_way_and_stands_still_at_one_view():
    poses = ring(24)[[0, 0, 3, 3, 6]]
    flown = between(around(poses).views, 101)
    ways = np.linalg.norm(np.diff(flown.centers, axis=0), axis=1)
    assert (ways < 1e-6).sum() <= 12
    for still in (poses[:1], poses[:2]):
        same = between(around(still).views, 5)
        np.testing.assert_allclose(same.world_to_camera, poses[[0] * 5], atol=1e-12)


@pytest.mark.parametrize("request_", ["orbit", "trajectory", "every:8", [3, 9]])
def test_views_are_as_many_and_as_large_as_asked_and_see_the_same(request_, circle):
    flown = flight(circle, request_, 100, 1280)
    assert (len(flown), flown.size) == (100, (1280, 960))
    np.testing.assert_allclose(flown.intrinsics, np.tile(circle.intrinsics[0] * 20, (100, 1)))
