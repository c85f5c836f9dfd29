"""Faults that people met at the command line, each said in words that help."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from small_captures import camera_path, damage_pixels, pose_anew, record_of, ring, run, select

import fsel
from fsel.selection.focus import check_within, from_box, scene_bounds


def test_all_frames_are_all_of_them(capture, tmp_path, capsys):
    assert select(capture, "-k", 10, "--method", "all", "-o", tmp_path / "out") == 1
    assert "takes every frame; allowed: 24" in capsys.readouterr().err
    assert select(capture, "-k", 24, "--method", "all", "-o", tmp_path / "out") == 0
    asked = ["-k", "4,5", "--methods", "uniform,all", "--long-side", 48]
    asked += ["--reconstructor", "splats"]
    assert run("compare", capture, *asked, "-o", tmp_path / "compared") == 0
    rows = json.loads((tmp_path / "compared" / "compare.json").read_text())["rows"]
    found = [(row["k"], row["method"]) for row in rows]
    assert found == [(4, "uniform"), (5, "uniform"), (21, "all")]


def test_a_box_outside_of_the_scene_is_refused_with_the_scenes_bounds(capture, tmp_path, capsys):
    """In front of a camera, and so inside of an image, but thirty scenes away."""
    assert run("info", capture, "--json") == 0
    low, high = json.loads(capsys.readouterr().out)["bounds"]
    np.testing.assert_allclose([low[0], high[0]], [-4, 4])  # the ring of cameras
    for box in ([100, 20, 0, 101, 21, 1], [4.1, 0, 0, 5, 1, 1]):
        assert select(capture, "-k", 4, "--box", *box, "-o", tmp_path / "out") == 1
        assert "lies outside of the scene, which reaches from [-4.0" in capsys.readouterr().err
    assert run("info", capture) == 0
    assert "bounds    -4 " in capsys.readouterr().out


def test_without_points_the_scene_is_where_the_cameras_look(capture):
    """The ring of cameras is flat, and an object in its middle is not at their height."""
    bare = replace(fsel.read_capture(capture, long_side=48), points=None)
    bounds = scene_bounds(bare)
    check_within(from_box(np.array([-1, 1.5, -1, 1, 2.5, 1])), bounds)
    with pytest.raises(ValueError, match="outside of the scene"):
        check_within(from_box(np.array([-1, 6, -1, 1, 7, 1])), bounds)


def test_no_pick_is_blind_to_the_object(capture, tmp_path, capsys):
    """Cameras of the ring turned about: every second one sees nothing of its middle."""
    poses = ring(24)
    poses[::2] = np.diag([-1.0, 1, -1]) @ poses[::2]
    pose_anew(capture, poses)
    box, out = ["--box", -0.2, -0.2, -0.2, 0.2, 0.2, 0.2], tmp_path / "out"
    path = camera_path(tmp_path, ring(24)[1::2])
    asked = [*box, "--max-error", 1, "--targets", path]
    assert select(capture, "-k", 12, *asked, "-o", out) == 0
    assert {entry["index"] % 2 for entry in record_of(out)["frames"]} == {1}
    assert {entry["reason"] for entry in record_of(out)["left"]} == {"does not show the object"}
    assert select(capture, "-k", 13, *asked, "-o", tmp_path / "more") == 1
    assert "1 to 12" in (said := capsys.readouterr().err)
    assert "12 not seeing the object" in said


@pytest.mark.parametrize("by", ["--masks", "--box"])
def test_an_object_is_compared_inside_of_its_outline(by, capture, tmp_path):
    """Whatever the held-out frames show outside of it, the scores are the same."""
    masks = tmp_path / "shapes"
    masks.mkdir()
    for i in (0, 3, 8, 11, 19):  # 16 is held out and has none
        mask = np.zeros((48, 64), np.uint8)
        mask[14:34, 20:44] = 255
        cv2.imwrite(str(masks / f"frame_{i:03d}.png"), mask)
    thing = {"--masks": [masks], "--box": [-0.7, -0.7, -0.7, 0.7, 0.7, 0.7]}[by]
    asked = ["-k", "5", "--methods", "uniform", by, *thing, "--long-side", 64]
    asked += ["--reconstructor", "splats"]
    assert run("compare", capture, *asked, "-o", tmp_path / "one") == 0
    for i in (0, 8):
        path = capture / "images" / f"frame_{i:03d}.jpg"
        shot = cv2.imread(str(path))
        shot[:, :8] = 255 - shot[:, :8]
        cv2.imwrite(str(path.with_suffix(".png")), shot)
        path.unlink()
    assert run("compare", capture, *asked, "-o", tmp_path / "two") == 0
    one, two = (json.loads((tmp_path / o / "compare.json").read_text()) for o in ("one", "two"))
    held = ["frame_000.jpg", "frame_008.jpg"] + ["frame_016.jpg"] * (by == "--box")
    assert one["targets"] == held
    assert one["rows"][0]["psnr"] == pytest.approx(two["rows"][0]["psnr"], abs=0.02)


@pytest.mark.parametrize("more", [[], ["--geometry-only"], ["--long-side", 32]])
@pytest.mark.parametrize("how", [["--always", "names.txt"], ["--targets", "every:4"]])
def test_damaged_pixels_are_exported_neither_as_a_pick_nor_held_out(
    more, how, capture, tmp_path, monkeypatch, capsys
):
    """The header is whole: what decodes the image refuses it."""
    monkeypatch.chdir(tmp_path)
    damage_pixels(capture / "images" / "frame_008.jpg")
    Path("names.txt").write_text("frame_008.jpg\n")
    assert select(capture, "-k", 4, *how, *more, "-o", "out") == 1
    printed = capsys.readouterr().err
    for said in ("frame_008.jpg: not a readable image: its ", "--skip-unreadable", "--never"):
        assert said in printed
    assert not Path("out").exists()
    assert select(capture, "-k", 3, "--never", "names.txt", *more, "-o", "out") == 0
    assert len(fsel.read_capture(capture, long_side=48, skip_unreadable=True)) == 23


@pytest.fixture
def damaged(capture):
    """A capture that has lost one image, and of another all but its first bytes."""
    (capture / "images" / "frame_002.jpg").unlink()
    cut = capture / "images" / "frame_005.jpg"
    cut.write_bytes(cut.read_bytes()[:100])
    return capture


@pytest.mark.parametrize(
    "asked",
    [
        ["info"],
        ["select", "-k", 6, "--patience", 0],
        ["compare", "-k", 4, "--methods", "uniform", "--reconstructor", "splats"],
        ["reconstruct", "--long-side", 48],
    ],
)
def test_unreadable_images_are_skipped_where_asked(asked, damaged, tmp_path, capsys):
    command, *options = asked
    (tmp_path / "frames.txt").write_text("frame_007.jpg\nframe_008.jpg\n")
    if command == "reconstruct":
        options += ["--frames", tmp_path / "frames.txt"]
    if command != "info":
        options += ["-o", tmp_path / ("out.ply" if command == "reconstruct" else "out")]
    assert run(command, damaged, *options) == 1
    assert "frame_002.jpg" in capsys.readouterr().err
    assert run(command, damaged, *options, "--skip-unreadable") == 0
    printed = capsys.readouterr().err
    assert "2 images" in printed
    assert "frame_005.jpg" in printed


def test_what_is_skipped_is_recorded_and_never_picked(damaged, tmp_path, capsys):
    asked = ["-k", 22, "-o", tmp_path / "out", "--skip-unreadable"]
    assert select(damaged, *asked) == 0
    record = record_of(tmp_path / "out")
    assert list(record["capture"]["dropped"]) == ["frame_002.jpg", "frame_005.jpg"]
    assert record["capture"]["frames"] == 22
    assert capsys.readouterr().err.count("warning") == 1
    whole = fsel.read_capture(damaged, long_side=48, skip_unreadable=True)
    assert len(whole) == 22
    assert whole.points.track_frame.max() == 21
    for image in (damaged / "images").iterdir():
        image.write_bytes(b"")
    assert select(damaged, "-k", 4, "-o", tmp_path / "none", "--skip-unreadable") == 1
    assert "24 images" in capsys.readouterr().err
