"""Poses that disagree with points or images are refused, with the cause."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from layout_recordings import recording, write_recording

from fsel.captures.canonical import in_order
from fsel.captures.images.matching import (
    agreeing,
    choose_pairs,
    epipolar_distances,
    focal_from_poses,
)
from fsel.captures.layouts import LAYOUTS
from fsel.captures.layouts.nerfstudio import OLD_APPLIED_TRANSFORM
from fsel.captures.poses.agreement import measure, reprojection_errors
from fsel.captures.read import read_folder, read_raw
from fsel.core.geometry import OPENGL_TO_OPENCV, invert_pose

CAPTURES = Path(__file__).parents[3] / "shared" / "captures"
REAL = pytest.mark.skipif(not CAPTURES.is_dir(), reason="../shared/captures is not there")


def opengl(poses):
    return np.array([OPENGL_TO_OPENCV @ pose for pose in poses])


def inverted(poses):
    return np.array([invert_pose(pose) for pose in poses])


def turned(poses):
    world = np.vstack([OLD_APPLIED_TRANSFORM, [0, 0, 0, 1]])
    return np.array([pose @ world for pose in poses])


MISTAKES = {
    "axes of OpenGL": opengl,
    "camera-to-world poses taken": inverted,
    "before January 2024, kept or undone wrongly": turned,
}


# matches of two views of a room, some of them twice, for which OpenCV finds no matrix and throws
FIRST = (
    "41 7 43 5 55 6 57 51 59 8 59 8 62 19 62 25 65 16 65 16 72 10 72 10 75 19 78 23 79 17 79 17 "
    "79 10 79 10 112 13 125 37 "
)
SECOND = (
    "8 14 11 12 25 12 62 51 29 14 29 14 33 26 35 32 37 24 37 24 44 17 44 17 48 25 51 28 51 23 "
    "51 23 51 16 51 16 81 18 125 38 "
)


def test_matches_without_any_model_tell_nothing():
    first, second = (np.array(t.split(), float).reshape(-1, 2) for t in (FIRST, SECOND))
    assert not agreeing(first, second).any()
    shifted = first + [4.0, 1.0]
    assert agreeing(first, shifted).all()


@pytest.fixture
def raw(tmp_path):
    write_recording("mipnerf360", tmp_path)
    return in_order(read_raw(tmp_path)[1], "made")


def test_exact_poses_reproject_exactly(raw):
    found = measure(raw, 0.02)
    assert found.kind == "reprojection"
    assert found.long_side == 256  # the camera's size, four times the images'
    assert found.p95 < 1e-6
    assert found.count == len(raw.sparse().track_xy)


def test_reprojection_error_by_hand(raw):
    points = raw.sparse()
    moved = replace(points, track_xy=points.track_xy + [3.0, -4.0])
    np.testing.assert_allclose(reprojection_errors(replace(raw, points=lambda _: moved)), 5)


def test_reprojection_error_one_by_one(tmp_path):
    write_recording("colmap", tmp_path)
    raw = in_order(read_raw(tmp_path)[1], "made")
    rng = np.random.default_rng(0)
    poses = raw.world_to_camera + rng.normal(scale=[0, 0, 0, 2.0], size=raw.world_to_camera.shape)
    cameras = [
        replace(camera, params=(60.0 + at, *camera.params[1:]))
        for at, camera in enumerate(raw.cameras)
    ]
    raw, points = replace(raw, world_to_camera=poses, cameras=cameras), raw.sparse()
    want = []
    for point, frame, xy in zip(
        points.track_point, points.track_frame, points.track_xy, strict=True
    ):
        x, y, z = poses[frame, :, :3] @ points.xyz[point] + poses[frame, :, 3]
        seen = cameras[frame].colmap.img_from_cam([x, y, z]) if z > 0 else np.inf
        want.append(np.linalg.norm(seen - xy))
    assert 0 < np.isinf(want).sum() < len(want)
    np.testing.assert_allclose(reprojection_errors(raw), want, rtol=1e-9)


@pytest.mark.parametrize("cause", MISTAKES)
def test_a_wrong_convention_is_named(raw, cause):
    found = measure(replace(raw, world_to_camera=MISTAKES[cause](raw.world_to_camera)), 0.02)
    assert found.share > 0.02
    assert cause in found.cause


def test_intrinsics_of_another_size_are_named(raw):
    cameras = [
        replace(c, params=tuple(p / 4 for p in c.params), width=64, height=48) for c in raw.cameras
    ]
    assert "0.25 times" in measure(replace(raw, cameras=cameras), 0.02).cause


def test_poses_of_another_capture_are_refused_at_the_door(tmp_path):
    made = recording("mipnerf360")
    other = replace(made, world_to_camera=np.roll(made.world_to_camera, 1, axis=0))
    LAYOUTS["mipnerf360"].write(other, tmp_path)
    with pytest.raises(ValueError, match="belong to different reconstructions") as error:
        read_folder(tmp_path)
    assert "reprojection error of median" in str(error.value)
    assert read_folder(tmp_path, max_error=10.0).agreement.median > 5


def test_epipolar_distance_by_hand():
    """Two cameras side by side: lines are rows, and the distance is the rows' difference."""
    pose = np.tile(np.eye(3, 4), (2, 1, 1))
    pose[1, 0, 3] = -1
    k = np.array([100.0, 100, 50, 50])
    a, b = np.array([[10.0, 20], [30, 40]]), np.array([[3.0, 20], [22, 47]])
    np.testing.assert_allclose(epipolar_distances(a, b, *pose, k, k), [0, 7], atol=1e-9)


def test_the_focal_length_is_found_from_poses():
    made = recording("mipnerf360", frames=8)
    pixels = []
    for pose in made.world_to_camera:
        local = made.xyz @ pose[:, :3].T + pose[:, 3]
        pixels.append(local[:, :2] / local[:, 2:] * 60 + [32, 24])
    pairs = [(pixels[i], pixels[i + 1], *made.world_to_camera[i : i + 2]) for i in range(7)]
    assert focal_from_poses(pairs, (64, 48)) == pytest.approx(60, abs=0.01)


def test_pairs_look_the_same_way_from_apart():
    poses = np.tile(np.eye(3, 4), (40, 1, 1))
    poses[:, 0, 3] = -np.arange(40.0)
    poses[20:, :, :3] = np.diag([-1.0, 1, -1])
    pairs = choose_pairs(poses, 8)
    assert len(pairs) >= 6
    for i, j in pairs:
        assert (i < 20) == (j < 20)
        assert j - i == 6  # the centres span 58, and a tenth of that is asked for


@REAL
def test_real_images_tell_right_poses_from_wrong_ones():
    raw = replace(in_order(read_raw(CAPTURES / "fox", "colmap")[1], "fox"), points=None)
    found = measure(raw, 0.02)
    assert found.kind == "epipolar"
    assert found.count > 300
    assert found.median < 1
    for cause in ("axes of OpenGL", "camera-to-world poses taken"):
        wrong = measure(replace(raw, world_to_camera=MISTAKES[cause](raw.world_to_camera)), 0.02)
        assert wrong.share > 0.02
