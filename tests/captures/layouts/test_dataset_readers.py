"""Each dataset's reader on files made by hand, with the quirks that its dataset is known for."""

import json
import shutil

import numpy as np
import pytest
from layout_recordings import full, recording, write_colmap, write_recording
from scipy.spatial.transform import Rotation

from fsel.captures.images import files as image_files
from fsel.captures.layouts.seven_scenes import DEPTH_TO_COLOR
from fsel.captures.read import read_capture, read_raw, recognise
from fsel.core.geometry import invert_pose


@pytest.fixture
def made():
    return recording("mipnerf360")


# DL3DV


def test_dl3dv_reads_either_distribution_but_mixes_none(tmp_path):
    made = write_recording("dl3dv", tmp_path)
    straight = recording("mipnerf360", seed=1)
    write_colmap(straight, tmp_path / "gaussian_splat", text=False)
    both = read_raw(tmp_path)[1]
    np.testing.assert_allclose(both.world_to_camera[0], made.world_to_camera[0], atol=1e-9)
    shutil.rmtree(tmp_path / "nerfstudio")
    assert recognise(tmp_path)[0] == "dl3dv"
    alone = read_capture(tmp_path, long_side=64)
    np.testing.assert_allclose(alone.world_to_camera, straight.world_to_camera, atol=1e-9)


def test_dl3dv_takes_the_small_copies_where_all_ship(tmp_path):
    write_recording("dl3dv", tmp_path)
    shutil.copytree(tmp_path / "nerfstudio" / "images_4", tmp_path / "nerfstudio" / "images")
    assert {file.parent.name for file in read_raw(tmp_path)[1].images} == {"images_4"}


@pytest.mark.parametrize("inner", [".", "colmap"])
def test_dl3dv_of_the_ten_thousand(tmp_path, inner):
    made = write_recording("dl3dv", tmp_path / "x")
    shutil.copytree(tmp_path / "x" / "nerfstudio", tmp_path / "scene" / inner)
    capture = read_capture(tmp_path / "scene", long_side=64)
    assert capture.source.startswith("dl3dv")
    np.testing.assert_allclose(capture.world_to_camera, made.world_to_camera, atol=1e-9)


# Tanks and Temples


def write_log(made, folder, lost=(3, 8)):
    image_files.write(made.images, folder, [f"{i + 1:06d}.jpg" for i in range(22)])
    lines = []
    for i, pose in enumerate(made.world_to_camera):
        matrix = np.eye(4) if i in lost else full(pose)
        lines += [f"{i} {-1 if i in lost else i} 0"]
        lines += [" ".join(repr(float(v)) for v in row) for row in matrix]
    (folder / f"{folder.name}_COLMAP_SfM.log").write_text("\n".join(lines) + "\n")


def test_the_official_log_leaves_out_unregistered_frames(made, tmp_path):
    write_log(made, tmp_path / "Barn")
    assert recognise(tmp_path / "Barn")[0] == "tanks_and_temples"
    raw = read_raw(tmp_path / "Barn", "tanks_and_temples", {"focal": 60 / 64})[1]
    rows = np.setdiff1d(np.arange(22), [3, 8])
    np.testing.assert_allclose(raw.world_to_camera, made.world_to_camera[rows], atol=1e-9)
    assert [file.name for file in raw.images] == [f"{i + 1:06d}.jpg" for i in rows]
    assert set(raw.dropped) == {"000004.jpg", "000009.jpg"}
    assert raw.cameras[0].params == (60, 32, 24)


def test_without_a_focal_length_or_with_more_poses_than_images_it_is_refused(made, tmp_path):
    write_log(made, tmp_path / "Barn")
    with pytest.raises(ValueError, match=r"reading: \{focal"):
        read_raw(tmp_path / "Barn", "tanks_and_temples")
    (tmp_path / "Barn" / "000022.jpg").unlink()
    with pytest.raises(ValueError, match="22 poses for 21 images"):
        read_raw(tmp_path / "Barn", "tanks_and_temples", {"focal": 1})


def test_nerfpp_release(made, tmp_path):
    k = np.eye(4)
    k[:2, :3] = [[60, 0, 31.5], [0, 60, 23.5]]  # OpenCV's pixel centres
    for i, pose in enumerate(made.world_to_camera):
        split = tmp_path / ("test" if i % 8 == 0 else "train")
        image_files.write(made.images[i : i + 1], split / "rgb", [f"{i:05d}.png"])
        for name, matrix in (("pose", full(pose)), ("intrinsics", k)):
            (split / name).mkdir(exist_ok=True)
            text = " ".join(repr(float(v)) for v in matrix.ravel())
            (split / name / f"{i:05d}.txt").write_text(text)
    capture = read_capture(tmp_path, long_side=64)
    assert capture.source.startswith("tanks_and_temples")
    np.testing.assert_allclose(capture.world_to_camera, made.world_to_camera, atol=1e-9)
    np.testing.assert_allclose(capture.intrinsics[0], [60, 60, 32, 24], atol=1e-9)
    np.testing.assert_array_equal(capture.images, made.images)


# ScanNet++


def test_undistorted_dslr_images_use_their_own_file(tmp_path):
    write_recording("scannetpp_dslr", tmp_path)
    root = tmp_path / "dslr"
    (root / "resized_images").rename(root / "resized_undistorted_images")
    (root / "resized_anon_masks").rename(root / "resized_undistorted_masks")
    content = json.loads((root / "nerfstudio" / "transforms.json").read_text())
    content["camera_model"] = "PINHOLE"
    for key in ("k1", "k2", "k3", "k4"):
        del content[key]
    (root / "nerfstudio" / "transforms_undistorted.json").write_text(json.dumps(content))
    raw = read_raw(tmp_path)[1]
    assert raw.cameras[0].model == "PINHOLE"
    assert raw.sparse() is None


# 7-Scenes


def test_calibrated_poses_are_the_colour_camera_s(tmp_path):
    write_recording("seven_scenes", tmp_path)
    raw = read_raw(tmp_path, reading={"pose_source": "calibrated"})[1]
    centers = [invert_pose(pose)[:, 3] for pose in raw.world_to_camera]
    depth = [invert_pose(pose)[:, 3] for pose in read_raw(tmp_path)[1].world_to_camera]
    offset = np.linalg.norm(np.array(centers) - depth, axis=1)
    np.testing.assert_allclose(offset, np.linalg.norm(DEPTH_TO_COLOR[:, 3]), atol=1e-6)
    np.testing.assert_allclose(offset, 0.0256, atol=1e-4)
    assert raw.cameras[0].params[:2] == (525, 525)


def test_pseudo_truth_has_a_focal_length_a_frame(tmp_path):
    made = write_recording("seven_scenes", tmp_path)
    lines = {"train": [], "test": []}
    for i, (name, pose) in enumerate(zip(made.names, made.world_to_camera, strict=True)):
        x, y, z, w = Rotation.from_matrix(pose[:, :3]).as_quat()
        numbers = " ".join(repr(float(v)) for v in (w, x, y, z, *pose[:, 3], 520 + i))
        lines["train" if i % 2 else "test"].append(f"{name}.color.png {numbers}\n")
    for split, text in lines.items():
        (tmp_path / f"pgt_{split}.txt").write_text("".join(text[:-1]))
    raw = read_raw(tmp_path, reading={"pose_source": "pgt"})[1]
    assert len(raw.names) == 20
    focal = {name: camera.params[0] for name, camera in zip(raw.names, raw.cameras, strict=True)}
    for name, pose in zip(raw.names, raw.world_to_camera, strict=True):
        at = made.names.index(name)
        assert focal[name] == 520 + at
        np.testing.assert_allclose(pose, made.world_to_camera[at], atol=1e-9)


def test_a_sequence_still_packed_is_named(tmp_path):
    write_recording("seven_scenes", tmp_path)
    shutil.rmtree(tmp_path / "seq-02")
    with pytest.raises(FileNotFoundError, match=r"seq-02: named by a split file.*must be unpacked"):
        read_raw(tmp_path)


# ScanNet, CO3D


def test_scannet_numbers_are_ordered_as_numbers(tmp_path):
    write_recording("scannet", tmp_path)
    capture = read_capture(tmp_path, long_side=64)
    assert capture.names[:6] == ("0", "1", "2", "3", "5", "6")
    assert capture.names[9:11] == ("10", "11")
    assert capture.masks is None


def test_co3d_s_two_ways_of_stating_intrinsics(tmp_path):
    from fsel.captures.layouts.co3d import _camera

    view = {"focal_length": [2.0, 3.0], "principal_point": [0.1, -0.2]}
    frame = {"image": {"size": [48, 64]}, "viewpoint": view}
    assert _camera(frame, tmp_path).params == pytest.approx((64, 72, 28.8, 28.8))
    view["intrinsics_format"] = "ndc_isotropic"
    assert _camera(frame, tmp_path).params == pytest.approx((48, 72, 29.6, 28.8))
    view["intrinsics_format"] = "screen"
    with pytest.raises(ValueError, match="intrinsics_format is 'screen'"):
        _camera(frame, tmp_path)


def test_co3d_refuses_a_sequence_of_poor_quality(tmp_path):
    write_recording("co3d", tmp_path)
    with pytest.raises(ValueError, match=r"viewpoint_quality_score of 1_1_1 is 1\.0"):
        read_raw(tmp_path, reading={"min_quality": 1.5})
    raw = read_raw(tmp_path / "object" / "1_1_1")[1]
    assert raw.dropped == {"object/1_1_1/images/f11.jpg": "no viewpoint"}
