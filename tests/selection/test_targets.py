"""Requests become views to select for; those without sense are refused."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from selection_problems import around, capture_of
from small_captures import ring

from fsel.selection import focus
from fsel.selection.problem import request_problem
from fsel.selection.targets import targets_of


def test_views_off_the_path_are_served_where_nothing_is_asked_for(circle):
    about = focus.Focus(np.zeros(3), np.zeros((1, 3)), "a point")
    problems = {
        (request, thing): request_problem(
            circle, targets_of(circle, request), np.zeros(24), about if thing else None, None
        )
        for request, thing in ((None, False), (None, True), ("every:8", False))
    }
    assert [len(p.targets) for p in problems.values()] == [48, 24, 3]
    assert [p.targets_unknown for p in problems.values()] == [True, True, False]
    assert all(len(p.proxies) == len(p.targets) for p in problems.values())


def test_a_long_path_is_thinned_evenly_with_both_ends(circle):
    path = around(ring(200)).views
    views = targets_of(circle, path).views
    assert len(views) == 60
    np.testing.assert_array_equal(views.world_to_camera[[0, -1]], path.world_to_camera[[0, -1]])


def test_frames_are_held_out_by_name_and_by_number(circle):
    for request in (["frame_0005", "frame_0002"], [5, 2], np.array([2, 5, 5])):
        targets = targets_of(circle, request)
        np.testing.assert_array_equal(targets.frames, [2, 5])
        np.testing.assert_array_equal(targets.views.world_to_camera, circle.world_to_camera[[2, 5]])
        np.testing.assert_array_equal(
            targets.pool(circle), [0, 1, 3, 4, *range(6, 24)], strict=False
        )


@pytest.mark.parametrize(
    ("request_", "said"),
    [
        ([], "no frame"),
        ([24], "24"),
        ([-1], "-1"),
        (["x.jpg"], "'x.jpg'; its names are like 'frame_0000'"),
        (list(range(23)), "at least two must remain"),
        ("spiral", "allowed: every:N, orbit"),
        ("every:x", "allowed: every:N"),
        ("every:2.5", "targets are 'every:2.5'; allowed: every:N.* N is 2 or more"),
    ],
)
def test_requests_without_sense_are_refused(request_, said, circle):
    with pytest.raises(ValueError, match=said):
        targets_of(circle, request_)


def test_a_wish_that_cannot_be_met_is_refused_for_its_own_reason(circle):
    targets = replace(targets_of(circle, [3]), blind=np.array([5]))
    for frame, why in ((3, "is held out as a target"), (5, "sees nothing of the object")):
        said = f"frame 'frame_000{frame}' is to be selected always, and {why}$"
        with pytest.raises(ValueError, match=said):
            targets.wished(circle, [frame, 1])
    assert not len(targets.wished(circle, always=[], never=[]).always)


def test_views_of_another_world_are_told(circle):
    poses = ring(4)
    poses[3, :, 3] += [0, 0, 50]
    targets = targets_of(circle, around(poses).views)
    np.testing.assert_array_equal(targets.far, [False, False, False, True])
    with pytest.raises(ValueError, match="another world frame"):
        targets_of(circle, around(poses[3:]).views)


@pytest.mark.parametrize("request_", [None, "trajectory", f"every:{10**30}"])
def test_cameras_in_one_place_are_near_one_another(request_):
    turns = [cv2.Rodrigues(np.array([0, turn, 0]))[0] for turn in np.linspace(0, 3, 12)]
    capture = capture_of(np.tile([0.1, 0.2, 0.3], (12, 1)), np.array(turns))
    assert not targets_of(capture, request_).far.any()
