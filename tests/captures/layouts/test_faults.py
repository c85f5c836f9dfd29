"""What is wrong on disk is refused, naming the file and the field; other captures go on."""

import gzip
import json
from itertools import product

import cv2
import numpy as np
import pycolmap
import pytest
from layout_recordings import recording, write_colmap, write_recording

from fsel.captures.read import read_capture, read_raw


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda p: p.write_bytes(b""), "0 bytes"),
        (lambda p: p.write_bytes(p.read_bytes()[:200]), "truncated"),
        (lambda p: p.unlink(), "missing"),
        (lambda p: p.write_text("no image"), "not a readable image"),
        (lambda p: cv2.imwrite(str(p), np.zeros((48, 90, 3), np.uint8)), "1 %"),
    ],
)
def test_a_damaged_image_is_named(tmp_path, damage, message):
    write_recording("mipnerf360", tmp_path)
    file = tmp_path / "images_4" / "f9.jpg"
    damage(file)
    with pytest.raises((ValueError, FileNotFoundError), match=message) as error:
        read_capture(tmp_path, "mipnerf360")
    assert "f9.jpg" in str(error.value)


def edit(path, change):
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))


def mirror(content):
    for row in content["frames"][0]["transform_matrix"][:3]:
        row[0] *= -1


def with_angle(content):
    del content["fl_x"]
    content["camera_angle_x"] = 40


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (mirror, "reflection"),
        (lambda c: c["frames"][0].update(transform_matrix=[[0] * 4] * 4), "has determinant 0"),
        (with_angle, "intrinsics of .* are missing"),
        (lambda c: c.update(fl_x=1e300, fl_y=1e300), "focal length .0.001 to 10000 times"),
        (lambda c: c.update(distortion_params=0.1), "distortion_params must"),
        (lambda c: c["frames"][0].update(file_path="images/a/../x.png"), "a/../x.png"),
        (lambda c: c["frames"][2].update(file_path="images/../../../etc/x.png"), "leads outside"),
        (
            lambda c: c["frames"][2]["transform_matrix"][0].__setitem__(3, float("nan")),
            "not finite",
        ),
        (lambda c: c.update(frames=[]), "list of frames"),
        (lambda c: c["frames"].append(c["frames"][0]), "duplicate frame names"),
        (lambda c: c["frames"][1].pop("transform_matrix"), "f9.png: field 'transform_matrix'"),
        (lambda c: c["frames"][1].pop("file_path"), r"frames\[1\]: field 'file_path'"),
        (lambda c: c.update(fl_x="wide"), "fl_x of .* must be one number, got 'wide'"),
        (lambda c: c.update(camera_model="EQUIRECTANGULAR"), "camera_model is 'EQUI.*allowed"),
        (lambda c: c.update(k4=0.1), "k4 is 0.1"),
        (lambda c: c.update(applied_transform=[[1, 2]]), "applied_transform must be 3x4"),
        (lambda c: c.update(applied_transform=[[0.0] * 4] * 3), "applied_transform cannot be"),
        (lambda c: c.update(w=-64), "positive size and focal length"),
        (lambda c: [f.update(mask_path=7) for f in c["frames"]], "'mask_path' must be a string"),
        (lambda c: c.update(train_filenames=["images/gone.png"]), "'images/gone.png' is in a"),
        (lambda c: c["frames"][0].update(mask_path="m.png"), "1 of 22 frames have a mask_path"),
    ],
)
def test_a_damaged_transforms_file_is_refused(tmp_path, change, message):
    write_recording("dl3dv", tmp_path)
    edit(tmp_path / "nerfstudio" / "transforms.json", change)
    with pytest.raises(ValueError, match=message) as error:
        read_capture(tmp_path, "dl3dv")
    assert str(tmp_path) in str(error.value)


def test_absent_or_unknown_folders_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such folder"):
        read_capture(tmp_path / "nothing")
    with pytest.raises(ValueError, match="no known layout"):
        read_capture(tmp_path)
    with pytest.raises(ValueError, match="allowed: auto"):
        read_capture(tmp_path, "kitti")
    with pytest.raises(FileNotFoundError, match="no COLMAP model"):
        read_capture(tmp_path, "colmap")


def test_json_of_nothing_but_nesting(tmp_path):
    (tmp_path / "transforms.json").write_bytes(b'{"frames":' + b"[" * 50_000)
    with pytest.raises(ValueError, match=r"transforms\.json: not readable as JSON"):
        read_capture(tmp_path, "nerfstudio")


def test_a_model_of_no_images_is_refused(tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "sparse").mkdir()
    pycolmap.Reconstruction().write_binary(str(tmp_path / "sparse"))
    with pytest.raises(ValueError, match="sparse: "):
        read_capture(tmp_path)


@pytest.mark.parametrize(
    ("name", "share"),
    [*product(("images.bin", "points3D.bin", "cameras.bin", "frames.bin"), (0.0, 0.9))]
    + [("images.bin", 2.0)],
)
def test_a_binary_model_cut_short_or_with_more_behind_it_is_refused(tmp_path, name, share):
    write_colmap(recording("mipnerf360"), tmp_path, text=False)
    path = tmp_path / "sparse" / "0" / name
    content = path.read_bytes()
    path.write_bytes((2 * content)[: int(share * len(content))])
    with pytest.raises(ValueError, match=r"sparse/0") as error:
        read_capture(tmp_path)
    if name != "frames.bin":
        assert f"{name}: {'cut short' if share < 1 else ''}" in str(error.value)


def text_model(folder, change):
    """A text model without rigs whose lines of images.txt are changed."""
    write_colmap(recording("mipnerf360"), folder, text=True)
    model = folder / "sparse" / "0"
    for name in ("rigs.txt", "frames.txt"):
        (model / name).unlink()
    path = model / "images.txt"
    lines = path.read_text().splitlines()
    head = [line for line in lines if line.startswith("#")]
    path.write_text("\n".join(head + change(lines[len(head) :])) + "\n")


def test_quaternions_that_are_not_normalised_are_refused(tmp_path):
    def stretch(lines):
        first = lines[0].split()
        first[1:5] = [repr(1.5 * float(q)) for q in first[1:5]]
        return [" ".join(first), *lines[1:]]

    text_model(tmp_path, stretch)
    with pytest.raises(ValueError, match=r"frame 'f7\.png': .* unnormalised quaternion"):
        read_capture(tmp_path)


def test_a_text_model_without_a_line_of_points_is_refused(tmp_path):
    text_model(tmp_path, lambda lines: lines[:1] + lines[2:])
    with pytest.raises(ValueError, match=r"images\.txt|not a readable COLMAP model"):
        read_capture(tmp_path)


def test_a_model_may_not_name_images_outside(tmp_path):
    names = [f"{i}.png" for i in range(21)] + ["../../outside.png"]
    (tmp_path / "a").mkdir()
    write_colmap(recording("mipnerf360"), tmp_path / "a" / "b", names)
    with pytest.raises(ValueError, match=r"'\.\./\.\./outside\.png' leads outside"):
        read_capture(tmp_path / "a" / "b")


def test_lost_poses_of_any_kind_are_left_out(tmp_path):
    for layout in ("scannet", "seven_scenes"):
        write_recording(layout, tmp_path / layout)
    for stem, value in (("9", np.nan), ("10", np.inf), ("11", 0.0)):
        np.savetxt(tmp_path / "scannet" / "pose" / f"{stem}.txt", np.full((4, 4), value))
    lost = dict.fromkeys(["4", "9", "10", "11"], "tracking lost")
    assert read_raw(tmp_path / "scannet")[1].dropped == lost
    seven = tmp_path / "seven_scenes"
    np.savetxt(seven / "seq-01" / "frame-000003.pose.txt", np.full((4, 4), -np.inf))
    assert list(read_raw(seven)[1].dropped) == ["seq-01/frame-000003"]


@pytest.mark.parametrize(
    ("layout", "file", "text", "message"),
    [
        ("seven_scenes", "seq-01/frame-000002.pose.txt", "1 2 3", "expected a 4x4 matrix, got 3"),
        ("seven_scenes", "TrainSplit.txt", "seq one", "expected lines like sequence3"),
        ("scannet", "intrinsic/intrinsic_color.txt", "0", "expected a 4x4 matrix, got 1"),
        ("scannetpp_iphone", "iphone/pose_intrinsic_imu.json", "{}", "no entry for 'f7"),
    ],
)
def test_a_damaged_text_file_is_named(tmp_path, layout, file, text, message):
    write_recording(layout, tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(ValueError, match=message) as error:
        read_capture(tmp_path, layout)
    assert str(tmp_path / file) in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: f[0].pop("image"), "field 'image' is missing"),
        (lambda f: f[0]["image"].update(path="../x.jpg"), "leads outside"),
        (lambda f: f[0]["image"].update(size=[1, 2, 3]), "image.size must be 2"),
        (lambda f: f[0]["viewpoint"].update(R=[[1]]), r"viewpoint\.R must be 3x3"),
        (lambda f: f.append(7), "list of objects"),
        (lambda f: f[0]["image"].update(size=[float("inf"), 2]), "image.size must be finite"),
        (lambda f: f[0].update(frame_number=None), "frame_number must be finite"),
        (lambda f: f[0].update(mask=7), "mask: field 'path' is missing"),
    ],
)
def test_damaged_annotations_are_named(tmp_path, change, message):
    write_recording("co3d", tmp_path)
    (tmp_path.parent / "x.jpg").write_bytes(b"outside")
    path = tmp_path / "object" / "frame_annotations.jgz"
    frames = json.loads(gzip.decompress(path.read_bytes()))
    change(frames)
    path.write_bytes(gzip.compress(json.dumps(frames).encode()))
    with pytest.raises(ValueError, match=message) as error:
        read_capture(tmp_path, "co3d")
    assert "frame_annotations.jgz" in str(error.value)
