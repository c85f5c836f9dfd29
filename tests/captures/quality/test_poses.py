"""Poses that contradict their points or the path."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_captures import ring, write_ring

from fsel.captures.lazy import open_capture
from fsel.captures.quality.examination import examined
from fsel.captures.quality.findings import MISPLACED
from fsel.captures.quality.poses import jumps, reprojection


def test_medians_limits_and_inliers_by_hand():
    errors = np.array([1, 2, 3, 4, 5, 6, 7] + [0.5] * 7 + [40.0] * 5 + [1, 90] + [np.inf] * 2)
    frame = np.array([0] * 7 + [1] * 7 + [2] * 7 + [3] * 2)
    median, limit, within = reprojection(errors, frame, 5, side=480)
    np.testing.assert_array_equal(median, [4, 0.5, 40, np.nan, np.nan])  # two or none are too few
    assert limit == 24  # six times 4
    np.testing.assert_allclose(within, [1, 1, 1 / 7, 0, 0])
    assert reprojection(errors / 100, frame, 5, side=480)[1] == pytest.approx(1.92)
    nothing = reprojection(np.empty(0), np.empty(0, int), 2, side=480)
    assert np.isnan(nothing[0]).all()


def walk(turn=0.0, shift=0.0, at=20, count=60):
    """A smooth path of which one frame is turned, degrees, and shifted, in steps."""
    poses = ring(count)
    step = 2 * 4.0 * np.sin(np.pi / count)
    rotation = Rotation.from_rotvec(np.radians([turn, 0, 0])).as_matrix()
    poses[at] = rotation @ poses[at]
    poses[at, 1, 3] += shift * step
    return poses


@pytest.mark.parametrize(("turn", "shift"), [(10, 0), (0, 4), (10, 4)])
@pytest.mark.parametrize("at", [0, 1, 20, 58, 59])
def test_the_frame_that_jumps_is_found_alone(turn, shift, at):
    assert np.flatnonzero(jumps(walk(turn, shift, at)) > 1).tolist() == [at]


def test_smooth_paths_and_photos_have_no_jumps():
    assert jumps(walk()).max() < 0.2
    photos = walk()[np.random.default_rng(0).permutation(60)]
    assert not jumps(photos).any()
    assert not jumps(walk(10, 4, at=3, count=7)).any()  # too few to tell
    assert not jumps(np.repeat(walk()[:1], 20, axis=0)).any()  # no path


def test_the_frame_after_a_jump_of_a_video_is_misplaced(tmp_path):
    write_ring(tmp_path)
    opened = open_capture(tmp_path)
    assert not len(examined(opened, images=False).of_kind(MISPLACED))
    found = {"jumps": [{"name": opened.capture.names[5], "degrees": 170}]}
    health = examined(replace(opened, found=found), images=False)
    assert health.of_kind(MISPLACED).tolist() == health.left_out.tolist() == [5]
