"""Validation: what `read_capture` refuses, every command refuses, in the same words."""

import json
import os

import cv2
import numpy as np
import pycolmap
import pytest
from small_captures import PARAMS, write_ring

from fsel.captures.layouts import colmap
from fsel.captures.layouts.nerfstudio import matrix_of
from fsel.captures.lazy import open_capture
from fsel.captures.read import read_capture
from fsel.cli import main
from fsel.core.names import matched


def sparse(folder):
    return folder / "sparse" / "0"


def changed_model(change):
    def damage(folder):
        model = pycolmap.Reconstruction(str(sparse(folder)))
        change(model)
        model.write_binary(str(sparse(folder)))

    return damage


def inverted(model):
    for frame in model.frames.values():
        frame.rig_from_world = frame.rig_from_world.inverse()


def unturned(model):
    frame = model.frames[1]
    frame.rig_from_world = pycolmap.Rigid3d(
        pycolmap.Rotation3d(np.zeros(4)), frame.rig_from_world.translation
    )


def far_away(model):
    frame = model.frames[2]
    frame.rig_from_world = pycolmap.Rigid3d(frame.rig_from_world.rotation, [1e200, 0, 0])


def wide(model):
    model.cameras[1].width *= 2


def at_infinity(model):
    next(iter(model.points3D.values())).xyz = [np.inf, 0, 0]


def without_pixels(model):
    model.cameras[1].height = 0


def image(name, content):
    return lambda folder: (folder / "images" / name).write_bytes(content)


def shifted_names(folder):
    """Two photos are gone, and an unrelated one has their stem."""
    model = pycolmap.Reconstruction(str(sparse(folder)))
    for key, name in ((1, "a/frame_000.jpg"), (2, "b/frame_000.jpg")):
        model.images[key].name = name
    model.write_binary(str(sparse(folder)))
    (folder / "images" / "frame_000.jpg").rename(folder / "images" / "frame_000.png")


def spaced(model):
    model.images[3].name = " frame_002.jpg"


def with_a_space(folder):
    changed_model(spaced)(folder)
    (folder / "images" / "frame_002.jpg").rename(folder / "images" / " frame_002.jpg")


def nerfstudio(change):
    def damage(folder):
        raw = colmap.read(folder)
        content = dict(zip(("fl_x", "fl_y", "cx", "cy"), PARAMS["PINHOLE"], strict=True))
        content |= {"w": 64, "h": 48}
        content["frames"] = [
            {"file_path": f"images/{name}", "transform_matrix": matrix_of(pose, np.eye(4)[:3])}
            for name, pose in zip(raw.names, raw.world_to_camera, strict=True)
        ]
        change(content)
        (folder / "transforms.json").write_text(json.dumps(content))
        for file in sparse(folder).iterdir():
            file.unlink()
        sparse(folder).rmdir()
        (folder / "sparse").rmdir()

    return damage


CASES = {
    "inverted poses": (changed_model(inverted), "camera-to-world poses taken"),
    "a zero quaternion": (changed_model(unturned), "frame 1 has a quaternion of length 0"),
    "a translation beyond numbers": (changed_model(far_away), "'frame_001.jpg': translation is"),
    "a camera twice as wide": (changed_model(wide), "image is 64x48 but its camera 128x48"),
    "a camera without pixels": (changed_model(without_pixels), "camera 1 has 64x0 pixels"),
    "a point at infinity": (changed_model(at_infinity), "sparse/0: point 30 lies at"),
    "a name with a space": (with_a_space, "' frame_002.jpg'"),
    "photos of another's name": (
        shifted_names,
        "a/frame_000.jpg: image file is missing (2",
    ),
    "a missing photo": (lambda f: (f / "images" / "frame_003.jpg").unlink(), "frame_003.jpg"),
    "an empty photo": (image("frame_004.jpg", b""), "frame_004.jpg: image file is empty"),
    "a damaged photo": (image("frame_004.jpg", b"\xff\xd8\xff\xd9"), "frame_004.jpg: "),
    "a smaller photo": (
        image("frame_005.jpg", cv2.imencode(".jpg", np.zeros((24, 32, 3), np.uint8))[1].tobytes()),
        "frame_005.jpg: (32, 24) pixels",
    ),
    "an angle": (
        nerfstudio(lambda c: (c.pop("fl_x"), c.update(camera_angle_x=40))),
        "intrinsics of images/frame_000.jpg are missing",
    ),
    "a number": (nerfstudio(lambda c: c.update(distortion_params=0.1)), "distortion_params must"),
    "a detour": (
        nerfstudio(lambda c: c["frames"][0].update(file_path="images/a/../frame_000.jpg")),
        "'a/../frame_000.jpg' is no plain path",
    ),
    "a focal length of no lens": (
        nerfstudio(lambda c: c.update(fl_x=1e300, fl_y=1e300)),
        "camera must have a positive size and focal length (0.001 to 10000 times",
    ),
    "a pipe": (
        lambda f: ((sparse(f) / "points3D.bin").unlink(), os.mkfifo(sparse(f) / "points3D.bin")),
        "points3D.bin: not a regular file",
    ),
    "no rotation": (
        nerfstudio(lambda c: c["frames"][1].update(transform_matrix=np.zeros((4, 4)).tolist())),
        "'frame_001.jpg': rotation has determinant 0",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_damaged_capture_is_refused_by_name(case, tmp_path):
    damage, said = CASES[case]
    write_ring(tmp_path, frames=9, cloud=30)
    damage(tmp_path)
    with pytest.raises((ValueError, OSError)) as refused:
        read_capture(tmp_path)
    assert said in str(refused.value)


@pytest.mark.parametrize("case", ["inverted poses", "a smaller photo"])
def test_every_command_refuses_alike(case, tmp_path, capsys):
    folder, names = tmp_path / "capture", tmp_path / "names.txt"
    write_ring(folder, frames=9, cloud=30)
    names.write_text("frame_006.jpg\nframe_007.jpg\n")
    CASES[case][0](folder)
    with pytest.raises(ValueError, match=r"jpg|poses") as refused:
        read_capture(folder)
    commands = {
        "select": ["-k", "3", "-o", "out"],
        "info": [],
        "compare": ["-k", "3", "-o", "out", "--long-side", "128"],
        "reconstruct": ["--frames", names, "-o", "out.ply", "--long-side", "128"],
    }
    for name, more in commands.items():
        asked = [str(tmp_path / word if word in ("out", "out.ply") else word) for word in more]
        assert main([name, str(folder), *asked]) == 1
        assert capsys.readouterr().err == f"fsel: {refused.value}\n"
    assert {path.name for path in tmp_path.iterdir()} == {"capture", "names.txt"}


def test_the_bound_on_disagreement_is_an_option(tmp_path, capsys):
    write_ring(tmp_path / "capture", frames=9, cloud=30)
    changed_model(inverted)(tmp_path / "capture")
    assert main(["info", str(tmp_path / "capture"), "--max-error", "inf"]) == 0


def test_cameras_of_several_shapes_are_read_cropped_lazily_or_not(tmp_path):
    """A third of the images is cut at the sides, and their camera with them."""
    write_ring(tmp_path)
    model = pycolmap.Reconstruction(str(tmp_path / "sparse" / "0"))
    cut = pycolmap.Camera(
        camera_id=2, model="PINHOLE", width=40, height=48, params=[60, 61, 20, 24]
    )
    model.add_camera_with_trivial_rig(cut)
    parts = pycolmap.Reconstruction()
    for key in (1, 2):
        parts.add_camera_with_trivial_rig(model.cameras[key])
    for key, image in model.images.items():
        narrow = key % 3 == 0
        posed = pycolmap.Image(image_id=key, name=image.name, camera_id=2 if narrow else 1)
        parts.add_image_with_trivial_frame(posed, image.cam_from_world())
        if narrow:
            path = tmp_path / "images" / image.name
            cv2.imwrite(str(path), cv2.imread(str(path))[:, 12:52])
    parts.write_binary(str(tmp_path / "sparse" / "0"))
    whole = read_capture(tmp_path, long_side=32, max_error=1)
    lazy = open_capture(tmp_path, long_side=32, max_error=1).capture
    assert whole.images.shape == (24, 24, 32, 3)
    np.testing.assert_array_equal(lazy.images[:], whole.images)
    np.testing.assert_array_equal(lazy.intrinsics, whole.intrinsics)
    wide, narrow = whole.intrinsics[0], whole.intrinsics[2]
    np.testing.assert_allclose(wide, [30, 30.5, 16, 12])
    np.testing.assert_allclose(narrow, [48, 48.8, 16, 12])  # 40 of 40 columns, 30 of 48 rows


def test_names_are_matched_one_to_one():
    assert matched(["a.jpg", "b.jpg"], ["a.png", "b.png"]) == {"a.png": 0, "b.png": 1}
    assert matched(["a.jpg", "b.jpg"], ["x/a.png", "y/a.png"]) == {}
