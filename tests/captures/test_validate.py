"""Validation: what `read_capture` refuses, every command refuses, in the same words."""

import os
import re
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from small_captures import write_ring

from fsel.captures.lazy import open_capture
from fsel.captures.read import read_capture
from fsel.cli import main, with_options
from fsel.core.names import matched


def inverted(model):
    for frame in model.frames.values():
        frame.rig_from_world = frame.rig_from_world.inverse()


def placed(number, rotation, translation):
    """Another pose of one frame."""
    pose = pycolmap.Rigid3d(pycolmap.Rotation3d(np.array(rotation)), translation)
    return lambda model: setattr(model.frames[number], "rig_from_world", pose)


def renamed(names):
    """Other names of images, by their numbers."""

    def change(model):
        for key, name in names.items():
            model.images[key].name = name

    return change


def moved(name, other):
    return lambda folder: (folder / "images" / name).rename(folder / "images" / other)


def piped(folder):
    path = folder / "sparse" / "0" / "points3D.bin"
    path.unlink()
    os.mkfifo(path)


def smaller(folder):
    cv2.imwrite(str(folder / "images" / "frame_005.jpg"), np.zeros((24, 32, 3), np.uint8))


def thin(folder):
    cv2.imwrite(str(folder / "images" / "frame_005.jpg"), np.zeros((1, 64, 3), np.uint8))


def without_pixels(model):
    model.cameras[1].height = 0


def nothing(_):
    pass


SPACED, TWO = {3: " frame_002.jpg"}, {1: "a/frame_000.jpg", 2: "b/frame_000.jpg"}
CASES = {  # what is done to the model, and then to the folder
    "inverted poses": (inverted, nothing, "camera-to-world poses taken"),
    "a zero quaternion": (placed(1, [0.0] * 4, [0, 0, 0]), nothing, "a quaternion of length 0"),
    "far away": (placed(2, [0.0, 0, 0, 1], [1e200, 0, 0]), nothing, "001.jpg': translation is"),
    "a camera without pixels": (without_pixels, nothing, "camera 1 has 64x0 pixels"),
    "a space": (renamed(SPACED), moved("frame_002.jpg", " frame_002.jpg"), "' frame_002.jpg'"),
    # two photos are gone, and an unrelated one has their stem
    "other names": (
        renamed(TWO),
        moved("frame_000.jpg", "frame_000.png"),
        "a/frame_000.jpg: image file is missing (2",
    ),
    "a smaller photo": (nothing, smaller, "frame_005.jpg: (32, 24) pixels"),
    "a line of pixels": (nothing, thin, "frame_005.jpg: an image of 64x1 pixels"),
    "a pipe": (nothing, piped, "points3D.bin: not a regular file"),
}


def write_damaged(folder, case):
    """A ring of nine cameras with one of the faults, and what is said of it."""
    write_ring(folder, frames=9, cloud=30)
    change, damage, said = CASES[case]
    sparse = str(folder / "sparse" / "0")
    model = pycolmap.Reconstruction(sparse)
    change(model)
    model.write_binary(sparse)
    damage(folder)
    return said


@pytest.mark.parametrize("case", CASES)
def test_a_damaged_capture_is_refused_by_name(case, tmp_path):
    said = write_damaged(tmp_path, case)
    with pytest.raises((ValueError, OSError)) as refused:
        read_capture(tmp_path)
    assert said in str(refused.value)


@pytest.mark.parametrize("case", ["inverted poses", "a smaller photo"])
def test_every_command_refuses_alike(case, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("names.txt").write_text("frame_006.jpg\nframe_007.jpg\n")
    said = write_damaged(tmp_path / "ring", case)
    with pytest.raises(ValueError, match=re.escape(said)) as refused:
        read_capture("ring")
    for line in (
        "select ring -k 3 -o out",
        "info ring",
        "compare ring -k 3 --long-side 128 -o out",
        "reconstruct ring --frames names.txt --long-side 128 -o out.ply",
    ):
        assert main(line.split()) == 1
        assert capsys.readouterr().err == f"fsel: {with_options(str(refused.value))}\n"
    assert {path.name for path in tmp_path.iterdir()} == {"ring", "names.txt"}


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
