"""Where picks are no more than the targets, the rule knows how far what they look at is."""

from dataclasses import replace

import numpy as np
from selection_problems import problem_on, random_capture, with_points_ahead

import fsel
from fsel.captures.lazy import open_capture
from fsel.selection.problem import with_target_depths
from fsel.selection.targets import targets_of


def test_it_is_the_median_depth_of_what_the_proxy_sees():
    problem = with_points_ahead(problem_on(random_capture(30), targets=6))
    capture, points = problem.capture, problem.capture.points
    want = []
    for frame in problem.proxies:
        seen = points.xyz[points.track_point[points.track_frame == frame]]
        want.append(np.median((seen - capture.centers[frame]) @ capture.axes[frame]))
    np.testing.assert_allclose(with_target_depths(problem).target_depths, want)


def test_without_points_or_with_points_behind_the_cameras_poses_alone_decide():
    problem = with_points_ahead(problem_on(random_capture(30), targets=6))
    points = problem.capture.points
    behind = replace(points, xyz=2 * problem.capture.centers[points.track_frame] - points.xyz)
    for other in (None, points.observed(np.zeros(len(points.track_frame), bool)), behind):
        bare = replace(problem, capture=replace(problem.capture, points=other))
        assert with_target_depths(bare) is bare


def test_only_no_more_picks_than_stated_targets_are_picked_by_it(ring):
    opened = open_capture(ring)
    capture, bare = opened.with_all_points(), opened.capture
    assert not targets_of(capture, None).as_many_as(3)
    for k, same in ((8, False), (9, True)):
        picks, without = (fsel.select(c, k, "every:3", patience=0).scores for c in (capture, bare))
        assert np.array_equal(picks, without) == same
        read = fsel.select(ring, k, "every:3", keep_bad=True, patience=0)
        np.testing.assert_array_equal(read.scores, picks)
