"""COLMAP models and transforms.json of every kind, and how layouts are recognised."""

import json
import shutil

import numpy as np
import pytest
from layout_recordings import OPENCV, PINHOLE, recording, write_colmap, write_recording
from small_captures import opengl

from fsel.captures.images import files as image_files
from fsel.captures.layouts import LAYOUTS
from fsel.captures.read import read_capture, read_raw, recognise


@pytest.fixture
def made():
    return recording("mipnerf360")


# COLMAP


@pytest.mark.parametrize("text", [True, False])
def test_text_and_binary_models_of_either_age(made, tmp_path, text):
    write_colmap(made, tmp_path, text=text)
    whole = read_capture(tmp_path, long_side=64)
    for name in ("rigs", "frames"):  # older models have neither
        for path in (tmp_path / "sparse" / "0").glob(f"{name}.*"):
            path.unlink()
    older = read_capture(tmp_path, long_side=64)
    np.testing.assert_allclose(whole.world_to_camera, made.world_to_camera, atol=1e-9)
    np.testing.assert_array_equal(older.world_to_camera, whole.world_to_camera)
    assert len(older.points.track_point) == len(whole.points.track_point) > 1000


def test_names_with_spaces_and_folders_in_a_text_model(made, tmp_path):
    names = [f"left cam/{name} a.png" for name in made.names]
    write_colmap(made, tmp_path, names)
    capture = read_capture(tmp_path, long_side=64)
    assert list(capture.names) == names
    assert set(capture.sequences) == {"left cam"}


def test_copies_named_otherwise_are_paired_in_order(made, tmp_path):
    LAYOUTS["mipnerf360"].write(made, tmp_path)
    folder = tmp_path / "images_4"
    shutil.copytree(folder, tmp_path / "images")
    for at, path in enumerate(sorted(folder.iterdir())):
        path.rename(folder / f"image{at:03d}.jpg")
    raw = read_raw(tmp_path)[1]
    for name, file in zip(raw.names, raw.images, strict=True):
        original = (tmp_path / "images" / name).read_bytes()
        assert file.read_bytes() == original


# nerfstudio


def transforms(made, camera=PINHOLE, **content):
    keys = ("k1", "k2", "p1", "p2")
    fx, fy, cx, cy, *extra = camera.params
    frames = []
    for name, pose in zip(made.names, made.world_to_camera, strict=True):
        place = opengl(pose).tolist()
        frames.append({"file_path": f"images/{name}.png", "transform_matrix": place})
    known = {"w": 64, "h": 48, "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy}
    return known | dict(zip(keys, extra, strict=False)) | {"frames": frames[::-1]} | content


def write_nerfstudio(made, folder, content):
    image_files.write(made.images, folder / "images", [f"{name}.png" for name in made.names])
    (folder / "transforms.json").write_text(json.dumps(content))


@pytest.mark.parametrize(
    "applied",
    [[[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, -1, 0]], [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]]],
)
def test_applied_transform_and_scale_are_undone(made, tmp_path, applied):
    content = transforms(made, applied_transform=applied, applied_scale=2.5)
    world = np.vstack([applied, [0, 0, 0, 1]])
    for frame in content["frames"]:
        moved = world @ np.array(frame["transform_matrix"])
        moved[:3, 3] *= 2.5
        frame["transform_matrix"] = moved.tolist()
    write_nerfstudio(made, tmp_path, content)
    assert recognise(tmp_path) == ["nerfstudio"]
    capture = read_capture(tmp_path, long_side=64)  # in natural order
    np.testing.assert_allclose(capture.world_to_camera, made.world_to_camera, atol=1e-9)
    np.testing.assert_array_equal(capture.images, made.images)


def test_intrinsics_of_each_frame_and_a_global_one_that_wins(made, tmp_path):
    content = transforms(made)
    for key in ("fl_x", "fl_y"):
        del content[key]
    for at, frame in enumerate(content["frames"]):
        frame |= {"fl_x": 50.0 + at, "fl_y": 51.0 + at, "cx": 1.0}
    write_nerfstudio(made, tmp_path, content)
    intrinsics = read_capture(tmp_path, long_side=64).intrinsics
    np.testing.assert_allclose(intrinsics[:, 0], 50.0 + np.arange(22)[::-1])
    np.testing.assert_allclose(intrinsics[:, 2], 32)


def test_distortion_by_name_or_in_a_list(made, tmp_path):
    content = transforms(made, OPENCV)
    write_nerfstudio(made, tmp_path, content)
    named = read_raw(tmp_path)[1].cameras[0]
    values = {key: content.pop(key) for key in ("k1", "k2", "p1", "p2")}
    content["distortion_params"] = [values["k1"], values["k2"], 0, 0, values["p1"], values["p2"]]
    write_nerfstudio(made, tmp_path, content)
    assert read_raw(tmp_path)[1].cameras[0] == named == OPENCV


def test_blender_s_field_of_view_and_bare_names(made, tmp_path):
    frames = transforms(made)["frames"]
    content = {"camera_angle_x": 2 * np.arctan(32 / 60), "w": 64, "h": 48, "frames": frames}
    for frame in content["frames"]:
        frame["file_path"] = "./" + frame["file_path"].removesuffix(".png")
    write_nerfstudio(made, tmp_path, content)
    (tmp_path / "images" / "f7.png").rename(tmp_path / "images" / "f7.jpg")  # as apps write them
    np.testing.assert_allclose(read_capture(tmp_path, long_side=64).intrinsics[0], [60, 60, 32, 24])


def test_frames_in_no_list_are_left_out(made, tmp_path):
    content = transforms(made)
    names = [frame["file_path"] for frame in content["frames"]]
    write_nerfstudio(
        made, tmp_path, content | {"train_filenames": names[:9], "test_filenames": names[12:]}
    )
    raw = read_raw(tmp_path)[1]
    assert len(raw.names) == 19
    assert list(raw.dropped.values()) == ["in none of the *_filenames lists"] * 3


# auto


def test_auto_points_at_captures_inside(tmp_path):
    write_recording("co3d", tmp_path / "a" / "b")
    write_recording("mipnerf360", tmp_path / "garden")
    with pytest.raises(ValueError, match=r"its folders \['garden'\] are captures"):
        read_raw(tmp_path)


def test_a_folder_beside_a_capture_is_not_part_of_it(tmp_path):
    write_recording("scannet", tmp_path / "scene0000_00")
    (tmp_path / "desk").mkdir()
    with pytest.raises(ValueError, match="desk: no known layout") as refusal:
        read_raw(tmp_path / "desk")
    assert "part of" not in str(refusal.value)
    with pytest.raises(ValueError, match=f"part of the capture {tmp_path / 'scene0000_00'}"):
        read_raw(tmp_path / "scene0000_00" / "color")


def test_options_of_other_layouts_are_refused(tmp_path):
    write_recording("mipnerf360", tmp_path)
    with pytest.raises(ValueError, match=r"reading\.focal: layout mipnerf360 takes nothing"):
        read_raw(tmp_path, reading={"focal": 1})


def test_every_nth_frame_of_each_sequence(tmp_path):
    write_recording("seven_scenes", tmp_path)
    names = read_capture(tmp_path, every=5).names
    assert names == tuple(f"seq-0{s}/frame-{i:06d}" for s in (1, 2) for i in (0, 5, 10))
