"""Layouts: what is written is read back; what is wrong is refused by name."""

import re
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from layout_recordings import DROPPED, MASKED, READING, WRITERS, write_recording

from fsel.captures.canonical import ingest
from fsel.captures.colmap.camera import Camera
from fsel.captures.read import read_capture, read_raw, recognise
from fsel.core.capture import Capture
from fsel.stages.ingest import ingest as save
from fsel.synthetic.record import project, unproject


@pytest.fixture(params=WRITERS)
def written(request, tmp_path):
    made = write_recording(request.param, tmp_path)
    return request.param, made, tmp_path


def kept(layout):
    return np.setdiff1d(np.arange(22), DROPPED.get(layout, []))


def test_round_trip(written):
    layout, made, folder = written
    capture = read_capture(folder, layout, long_side=64, reading=READING.get(layout))
    rows = kept(layout)
    if layout == "scannet":  # numbers its frames
        assert capture.names == tuple(str(i) for i in rows)
    elif layout == "co3d":
        assert capture.names == tuple(f"{i:06d}" for i in rows)
    else:
        names = [Path(name).name.split(".")[0] for name in capture.names]
        assert names == [Path(made.names[i]).name for i in rows]
    np.testing.assert_allclose(capture.world_to_camera, made.world_to_camera[rows], atol=1e-9)
    if made.camera.model == "PINHOLE":
        np.testing.assert_allclose(capture.intrinsics[0], made.camera.params, atol=1e-6)
        assert np.abs(capture.images.astype(int) - made.images[rows]).mean() < 3
    for camera in read_raw(folder, layout, READING.get(layout))[1].cameras:
        lengths = np.array(camera.params[:4]) / (camera.width / 64)
        np.testing.assert_allclose(lengths, made.camera.params[:4], atol=1e-6)
        np.testing.assert_allclose(camera.params[4:], made.camera.params[4:], atol=1e-9)
    assert recognise(folder)[0] == ("colmap" if layout == "tanks_and_temples" else layout)


@pytest.mark.parametrize("layout", MASKED)
def test_masks_follow_their_images(layout, tmp_path):
    made = write_recording(layout, tmp_path)
    capture = read_capture(tmp_path, layout, long_side=64, reading=READING.get(layout))
    rows = kept(layout)
    if made.camera.model == "PINHOLE":
        np.testing.assert_array_equal(capture.masks, made.masks[rows])
        return
    fx, fy, cx, cy = capture.intrinsics[0]
    source = project(made.camera, unproject(Camera("PINHOLE", 64, 48, (fx, fy, cx, cy))))
    column, row = np.floor(source).astype(int).reshape(48, 64, 2).transpose(2, 0, 1)
    expected = made.masks[rows][:, row.clip(0, 47), column.clip(0, 63)]
    assert (capture.masks != expected).mean() < 0.02  # along the disc's edge


def test_undistorted_images_show_what_a_pinhole_sees(written):
    layout, made, folder = written
    capture = read_capture(folder, layout, long_side=64)
    fx, fy, cx, cy = capture.intrinsics[0]
    straight = Camera("PINHOLE", 64, 48, (fx, fy, cx, cy))
    source = project(made.camera, unproject(straight)) - 0.5
    maps = source.reshape(48, 64, 2).astype(np.float32)
    for shown, i in zip(capture.images[:3], kept(layout)[:3], strict=True):
        expected = cv2.remap(made.images[i], maps, None, cv2.INTER_LINEAR)
        inner = np.abs(shown.astype(int) - expected)[3:-3, 3:-3]
        assert inner.mean() < 3


def test_points_and_tracks_survive(written):
    layout, made, folder = written
    capture = read_capture(folder, layout, long_side=64)
    if layout in ("seven_scenes", "scannet", "co3d", "nerfstudio"):
        assert capture.points is None
        return
    points = capture.points
    pose = capture.world_to_camera[points.track_frame]
    local = np.einsum("lij,lj->li", pose[:, :, :3], points.xyz[points.track_point]) + pose[:, :, 3]
    uv = local[:, :2] / local[:, 2:] * capture.intrinsics[0, :2] + capture.intrinsics[0, 2:]
    assert (np.abs(uv - [32, 24]) < [48, 40]).all()
    assert np.isin(np.round(points.xyz, 6), np.round(made.xyz, 6)).all()
    assert len(points.track_point) > 0.6 * len(made.track_point)


@pytest.mark.parametrize("layout", ["dl3dv", "mipnerf360", "scannetpp_dslr"])
def test_lazy_images_are_the_images(layout, tmp_path):
    write_recording(layout, tmp_path)
    raw = read_raw(tmp_path, layout)[1]
    lazy = ingest(raw, "made", 32, lazy=True)
    whole = ingest(raw, "made", 32)
    assert lazy.names == whole.names
    assert lazy.size == whole.size
    assert lazy.points is None
    # what undistortion keeps of a lens depends a little on the size it is done at
    np.testing.assert_allclose(lazy.intrinsics, whole.intrinsics, rtol=1e-3)
    np.testing.assert_array_equal(lazy.world_to_camera, whole.world_to_camera)
    if layout == "mipnerf360":  # without distortion
        np.testing.assert_array_equal(np.asarray(lazy.images), whole.images)
    np.testing.assert_array_equal(lazy.images[np.array([3, 1])].shape, (2, *whole.images.shape[1:]))
    np.testing.assert_array_equal(lazy.images[3], lazy.images[3:4][0])


def test_lazy_images_open_nothing_before_they_are_asked_for(tmp_path):
    write_recording("mipnerf360", tmp_path)
    raw = read_raw(tmp_path, "mipnerf360")[1]
    raw.images[5].write_bytes(b"")
    lazy = ingest(raw, "made", 32, lazy=True)
    lazy.images[:4]
    with pytest.raises(ValueError, match=re.escape(f"{raw.images[5]}: image file is empty")):
        np.asarray(lazy.images)


def test_what_was_found_is_recorded_and_arrays_are_streamed(tmp_path):
    write_recording("scannetpp_dslr", tmp_path / "raw")
    whole = read_capture(tmp_path / "raw", long_side=32)
    for _ in range(2):  # a second run replaces the first
        save(tmp_path / "raw", tmp_path / "out", at_least=20, long_side=32, reading={})
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["frames.parquet", "images.npy", "masks.npy", "points.parquet"]
    stored = Capture.load(tmp_path / "out")
    np.testing.assert_array_equal(stored.images, whole.images)
    np.testing.assert_array_equal(stored.masks, whole.masks)
    found = pd.read_parquet(tmp_path / "out" / "frames.parquet").attrs
    assert found["agreement"]["kind"] == "reprojection"
    assert 0 <= found["agreement"]["median"] <= found["agreement"]["p95"] < 0.01
    assert found["dropped"] == {
        "f14.JPG": "marked bad by its owner",
        "f26.JPG": "a test frame, never a candidate",
    }


def test_a_failed_ingestion_leaves_no_array(tmp_path):
    write_recording("mipnerf360", tmp_path / "raw")
    (tmp_path / "raw" / "images_4" / "f20.jpg").write_bytes(b"")
    with pytest.raises(ValueError, match=r"f20\.jpg"):
        save(tmp_path / "raw", tmp_path / "out", at_least=5, long_side=32, reading={})
    assert not list(tmp_path.glob("out/*"))
