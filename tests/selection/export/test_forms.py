"""What trainers read of a selection: points, sizes, folders, wishes."""

import json
import sys
from pathlib import Path

import numpy as np
import pycolmap
import pytest
from plyfile import PlyData
from small_captures import record_of, select, write_ring

from fsel.captures.images import files as image_files
from fsel.captures.images.previews import LUMA
from fsel.captures.read import read_capture

sys.path.insert(0, str(Path(__file__).parents[2] / "captures"))


def model_of(folder):
    return pycolmap.Reconstruction(str(folder / "sparse" / "0"))


def check_points(model, atol=1e-6):
    """A model's points lie where its cameras see them."""
    for image in model.images.values():
        for seen in image.get_observation_points2D():
            local = image.cam_from_world() * model.points3D[seen.point3D_id].xyz
            np.testing.assert_allclose(image.camera.img_from_cam(local), seen.xy, atol=atol)


def test_test_frames_come_with_the_points_that_the_picks_see(capture, tmp_path):
    out = tmp_path / "out"
    assert select(capture, "-k", 5, "--targets", "every:4", "-o", out) == 0
    train, test = model_of(out / "train"), model_of(out / "test")
    assert len(train.points3D) > 0
    for key, point in train.points3D.items():
        np.testing.assert_array_equal(test.points3D[key].xyz, point.xyz)
    assert len(test.points3D) == len(train.points3D)


def test_points_are_triangulated_where_a_capture_has_none(tmp_path):
    from test_sfm import PLANES, poses, write_posed

    write_posed(tmp_path / "capture", poses(6))
    out = tmp_path / "out"
    assert select(tmp_path / "capture", "-k", 5, "-o", out) == 0
    model = model_of(out)
    xyz = np.array([point.xyz for point in model.points3D.values()])
    assert len(xyz) > 50
    depths = np.array([z for _, z, _ in PLANES])
    assert np.median(np.abs(xyz[:, 2:] - depths).min(axis=1)) < 0.05
    assert model.compute_mean_reprojection_error() < 1e-6  # as its points are projected
    assert len(PlyData.read(str(out / "sparse_pc.ply"))["vertex"]) == len(xyz)
    # which opens images
    unopened = tmp_path / "unopened"
    assert select(tmp_path / "capture", "-k", 5, "--geometry-only", "-o", unopened) == 0
    assert not model_of(unopened).points3D


def test_images_and_cameras_are_reduced_together(tmp_path):
    write_ring(tmp_path / "capture", model="OPENCV")
    out = tmp_path / "out"
    assert select(tmp_path / "capture", "-k", 4, "--long-side", 32, "-o", out) == 0
    content = json.loads((out / "transforms.json").read_text())
    keys = ("w", "h", "fl_x", "fl_y", "cx", "cy", "k1")
    assert [content[key] for key in keys] == [32, 24, 30, 30.5, 16, 12, -0.05]
    assert all(image_files.load(path).shape == (24, 32, 3) for path in (out / "images").iterdir())
    check_points(model_of(out))
    assert not (out / "scene.json").exists()  # Long-LRM knows no distortion


def test_wishes_come_first_and_what_is_unwanted_never(capture, tmp_path, capsys):
    always, never = tmp_path / "always.txt", tmp_path / "never.txt"
    always.write_text("frame_011.jpg\nframe_002.jpg\n")
    asked = ["-k", 6, "--always", always]
    assert select(capture, *asked, "-o", tmp_path / "one") == 0
    picks = [entry["index"] for entry in record_of(tmp_path / "one")["frames"]]
    assert picks[:2] == [11, 2]
    assert len(set(picks)) == 6
    assert not {1, 3, 10, 12} & set(picks)  # what follows keeps clear of them
    never.write_text("".join(f"frame_{i:03d}.jpg\n" for i in picks[2:]))
    assert select(capture, *asked, "--never", never, "-o", tmp_path / "two") == 0
    others = [entry["index"] for entry in record_of(tmp_path / "two")["frames"]]
    assert others[:2] == [11, 2]
    assert not set(others) & set(picks[2:])
    reasons = {entry["name"]: entry["reason"] for entry in record_of(tmp_path / "two")["left"]}
    assert reasons[f"frame_{picks[2]:03d}.jpg"] == "excluded by never (--never)"
    for more, said in (
        (["-k", 1, "--always", always], "k is 1, but 2 frames must always be selected"),
        (
            ["-k", 4, "--always", always, "--method", "uniform"],
            "a method that begins with them (fsel,",
        ),
        (["-k", 20, "--never", never, "--targets", "every:8"], "being unwanted"),
        (["-k", 4, "--never", tmp_path / "no.txt"], "no such file of frame names"),
    ):
        assert select(capture, *more, "-o", tmp_path / "no") == 1
        assert said in capsys.readouterr().err


def test_long_lrm_and_viewers_are_told_the_scene(capture, tmp_path):
    """Long-LRM multiplies intrinsics by the images' size over w and h, and inverts w2c."""
    out = tmp_path / "out"
    assert select(capture, "-k", 4, "-o", out) == 0
    assert (out / "scenes.txt").read_text() == "scene.json\n"
    scene = json.loads((out / "scene.json").read_text())
    whole = read_capture(capture, long_side=64)
    for frame in scene["frames"]:
        row = whole.names.index(frame["file_path"].removeprefix("images/"))
        np.testing.assert_allclose(frame["w2c"][:3], whole.world_to_camera[row], atol=1e-12)
        assert frame["w2c"][3] == [0, 0, 0, 1]
        keys = ("w", "h", "fx", "fy", "cx", "cy")
        assert [frame[key] for key in keys] == [64, 48, 60, 61, 32, 24]
        assert (out / frame["file_path"]).is_file()
        camera = next(
            c
            for c in json.loads((out / "cameras.json").read_text())
            if c["img_name"] == whole.names[row]
        )
        assert [camera[key] for key in ("width", "height", "fx", "fy")] == [64, 48, 60, 61]
        np.testing.assert_allclose(camera["position"], whole.centers[row], atol=1e-12)
        np.testing.assert_allclose(
            camera["rotation"], whole.world_to_camera[row, :, :3].T, atol=1e-12
        )


@pytest.mark.parametrize("reduced", [False, True])
def test_without_distortion_images_cameras_and_points_agree(reduced, tmp_path):
    """The images are those that the library's reader makes of the distorted ones."""
    write_ring(tmp_path / "capture", model="OPENCV")
    masks, out = tmp_path / "masks", tmp_path / "out"
    white = np.full((24, 48, 64), 255, np.uint8)
    image_files.write(white, masks, [f"frame_{i:03d}.png" for i in range(24)])
    more = ["--long-side", 32] if reduced else ["--masks", masks]
    assert select(tmp_path / "capture", "-k", 6, "--undistort", *more, "-o", out) == 0
    whole = read_capture(tmp_path / "capture", long_side=32 if reduced else 64)
    assert "k1" not in json.loads((out / "transforms.json").read_text())
    for frame in json.loads((out / "scene.json").read_text())["frames"]:
        row = whole.names.index(frame["file_path"].removeprefix("images/"))
        known = [frame[key] for key in ("fx", "fy", "cx", "cy")]
        np.testing.assert_allclose(known, whole.intrinsics[row], atol=1e-9)
        shown = image_files.load(out / frame["file_path"])
        off = (shown.astype(int) - whole.images[row]) @ LUMA  # JPEG again, which blurs colours
        assert np.abs(off).mean() < 3
        if not reduced:
            mask = image_files.load(out / "masks" / f"{whole.names[row]}.png")
            assert mask.shape == (48, 64, 3)
            assert (mask == 255).all()  # the image covers all of it
    model = model_of(out)
    assert {camera.model_name for camera in model.cameras.values()} == {"PINHOLE"}
    assert sum(point.track.length() for point in model.points3D.values()) > 50
    check_points(model, atol=1e-4)


def test_cameras_that_no_trainer_states_are_written_without_distortion(tmp_path, capsys):
    write_ring(tmp_path / "capture")
    model = model_of(tmp_path / "capture")
    model.cameras[1].model = pycolmap.CameraModelId.FULL_OPENCV
    model.cameras[1].params = [60, 61, 32, 24, -0.05, 0.01, 1e-3, -1e-3, 0, 0, 0, 0]
    model.write_binary(str(tmp_path / "capture" / "sparse" / "0"))
    asked = ["-k", 4, "--max-error", 1, "-o", tmp_path / "out"]
    assert select(tmp_path / "capture", *asked) == 1
    assert "FULL_OPENCV has no counterpart" in capsys.readouterr().err
    assert select(tmp_path / "capture", *asked, "--undistort") == 0
    assert model_of(tmp_path / "out").cameras[1].model_name == "PINHOLE"


def test_points_keep_their_errors_in_pixels_of_the_images_that_are_written(capture, tmp_path):
    model = model_of(capture)
    for key, point in model.points3D.items():
        point.error = key / 10
    model.write_binary(str(capture / "sparse" / "0"))
    errors = {tuple(point.xyz): point.error for point in model.points3D.values()}
    for scale, asked in ((1.0, []), (0.5, ["--long-side", 32])):
        out = tmp_path / str(scale)
        assert select(capture, "-k", 6, *asked, "-o", out) == 0
        for point in model_of(out).points3D.values():
            assert point.error == pytest.approx(errors[tuple(point.xyz)] * scale)
