"""Embedded captures: reproducible, clear of objects, and true to their own geometry."""

import cv2
import numpy as np
import pytest

from fsel.synthesis import FAMILIES, record
from fsel.synthesis.lens import project, unproject


@pytest.fixture(scope="module", params=FAMILIES)
def recording(request):
    return request.param, record(request.param, 3, frames=24, width=64, height=48)


def test_equal_seeds_give_equal_bytes_and_others_differ():
    first, second, other = (
        record("scannetpp", seed, frames=12, width=32, height=24) for seed in (1, 1, 2)
    )
    for field in ("images", "depth", "world_to_camera", "xyz", "track_xy"):
        np.testing.assert_array_equal(getattr(first, field), getattr(second, field))
    assert (first.images != other.images).mean() > 0.5


def test_poses_are_rotations(recording):
    rotation = recording[1].world_to_camera[:, :, :3]
    identity = np.tile(np.eye(3), (len(rotation), 1, 1))
    np.testing.assert_allclose(rotation @ rotation.transpose(0, 2, 1), identity, atol=1e-12)
    assert (np.linalg.det(rotation) > 0).all()


def test_cameras_keep_their_distance_and_see_texture(recording):
    family, made = recording
    visible = made.depth > 0
    assert visible.mean() > 0.4
    metres = made.depth / np.linalg.norm(np.ptp(made.xyz, axis=0))
    assert metres[visible].min() > 0.005
    spread = made.images.reshape(len(made.images), -1).std(axis=1)
    assert spread.min() > 12, family


def test_tracks_agree_with_poses_lens_and_depth(recording):
    made = recording[1]
    pose = made.world_to_camera[made.track_frame]
    local = np.einsum("lij,lj->li", pose[:, :, :3], made.xyz[made.track_point]) + pose[:, :, 3]
    xy = project(made.camera, local)
    error = np.linalg.norm(xy - made.track_xy, axis=1)
    assert np.median(error) < 0.5
    assert error.max() < 2.5
    column, row = np.clip(xy, 0, [63.9, 47.9]).astype(int).T
    z = made.depth[made.track_frame, row, column]
    assert np.median(np.abs(z / local[:, 2] - 1)) < 0.01
    assert np.bincount(made.track_point).min() >= 3


def test_shaken_frames_are_less_sharp():
    made = record("scannetpp", 5, frames=60)
    assert 1 <= made.bad.sum() < 30
    sharp = [
        cv2.Laplacian(cv2.cvtColor(i, cv2.COLOR_RGB2GRAY), cv2.CV_64F).var() for i in made.images
    ]
    sharp = np.array(sharp)
    assert np.median(sharp[made.bad]) < 0.7 * np.median(sharp[~made.bad])


def test_the_camera_lingers_somewhere_and_hurries_elsewhere():
    made = record("tanks_and_temples", 2, frames=80, width=32, height=24)
    rotation = made.world_to_camera[:, :, :3]
    centers = -np.einsum("nij,ni->nj", rotation, made.world_to_camera[:, :, 3])
    steps = np.sort(np.linalg.norm(np.diff(centers, axis=0), axis=1))
    assert steps[:6].mean() < 0.2 * np.median(steps)
    assert steps[-1] > 1.4 * np.median(steps)


def test_several_passes_of_one_room():
    made = record("seven_scenes", 0, frames=40, width=32, height=24)
    assert sorted(set(made.sequences)) == ["seq-01", "seq-02", "seq-03", "seq-04"]
    assert made.names[0] == "seq-01/frame-000000"


def test_lens_round_trip(recording):
    camera = recording[1].camera
    rays = unproject(camera)
    x, y = np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5)
    expected = np.stack([x.ravel(), y.ravel()], axis=1)
    np.testing.assert_allclose(project(camera, rays * 3), expected, atol=1e-6)


@pytest.mark.parametrize(("family", "frames"), [("kitti", 24), ("dl3dv", 3)])
def test_impossible_requests_are_refused(family, frames):
    with pytest.raises(ValueError, match=r"allowed: dl3dv|at least 12"):
        record(family, 0, frames=frames)
