"""`fsel select`: what it writes, what it refuses, what it leaves behind when it is cut off."""

import errno
import json
import os
import shlex
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from selection_problems import random_weights
from small_captures import camera_path, record_of, ring, select, state_orientation, write_ring

from fsel.captures.images import files as image_files
from fsel.captures.read import read_capture
from fsel.selection.select import select_frames
from fsel.selection.validation import CandidateScore, ValidationResult
from fsel.selectors.scorer import Network


def test_the_picks_are_listed_with_what_each_adds(capture, tmp_path, capsys):
    out = tmp_path / "out"
    assert select(capture, "-k", 6, "-o", out) == 0
    content = record_of(out)
    names = [entry["name"] for entry in content["frames"]]
    assert (out / "frames.txt").read_text().split() == names
    assert len(set(names)) == 6
    assert sorted(names + [entry["name"] for entry in content["left"]]) == [
        f"frame_{i:03d}.jpg" for i in range(24)
    ]
    shift = [entry["shift"] for entry in content["frames"]]
    assert 1 - sum(entry["adds"] for entry in content["frames"]) == pytest.approx(
        shift[-1], abs=1e-5
    )
    assert shift == sorted(shift, reverse=True)
    assert content["scorer"]["coefficients"]["target_gain"] == 150
    assert content["scorer"]["policy"] == "fsel"
    printed = capsys.readouterr().out
    assert "the whole capture" in printed
    assert "--targets" in printed


def test_the_end_says_that_trying_was_cut_and_what_comes_next(
    capture, tmp_path, capsys, monkeypatch
):
    def cut(checked, console):
        outcome = select_frames(checked, console)
        tried = CandidateScore("uniform", outcome.selection.indices, 0, 0, 0, 0, 9, 5)
        tried = ValidationResult((tried,), "uniform", 5, cut=True)
        return replace(outcome, selection=replace(outcome.selection, tried=tried))

    monkeypatch.setattr("fsel.cli.select.select_frames", cut)
    assert select(capture, "-k", 6, "-o", tmp_path / "out") == 0
    out = tmp_path / "out"
    *_, stopped, _, _, opened, following = capsys.readouterr().out.splitlines()
    assert "5 fits" in stopped
    assert Path(opened.split()[1]) == out / "report.html"
    assert shlex.split(following)[1:4] == ["fsel", "reconstruct", str(out)]
    assert record_of(out)["tried"]["cut"]


def test_weights_of_one_s_own_pick_and_are_recorded(capture, tmp_path):
    mine = tmp_path / "mine.safetensors"
    scorer = Network(random_weights(1), {"policy": "less_is_more", "made by": "a test"})
    scorer.save(mine)
    assert select(capture, "-k", 6, "--weights", mine, "-o", tmp_path / "out") == 0
    content = record_of(tmp_path / "out")
    assert content["scorer"] == scorer.provenance
    asked = content["settings"]
    assert (asked["method"], asked["weights"]) == ("less_is_more", str(mine))


def test_the_subset_is_a_capture_of_the_picks(tmp_path):
    poses, _ = write_ring(tmp_path / "capture", model="OPENCV")
    out = tmp_path / "out"
    assert select(tmp_path / "capture", "-k", 6, "-o", out) == 0
    picks = sorted(entry["index"] for entry in record_of(out)["frames"])
    for layout in ("colmap", "nerfstudio"):
        back = read_capture(out, layout, long_side=64)
        assert back.names == tuple(f"frame_{i:03d}.jpg" for i in picks)
        np.testing.assert_allclose(back.world_to_camera, poses[picks], atol=1e-9)
        whole = read_capture(tmp_path / "capture", long_side=64)
        np.testing.assert_allclose(back.intrinsics, whole.intrinsics[picks], rtol=1e-9)
        np.testing.assert_array_equal(back.images, whole.images[picks])


def test_points_that_fewer_than_two_picks_see_are_dropped(tmp_path):
    _, seen = write_ring(tmp_path / "capture")
    out = tmp_path / "out"
    assert select(tmp_path / "capture", "-k", 5, "--targets", "every:4", "-o", out) == 0
    picks = [entry["index"] for entry in record_of(out)["frames"]]
    model = pycolmap.Reconstruction(str(out / "train" / "sparse" / "0"))
    whole = pycolmap.Reconstruction(str(tmp_path / "capture" / "sparse" / "0"))
    kept = seen[:, picks].sum(axis=1) >= 2
    assert 0 < kept.sum() < len(kept)
    expected = np.array([whole.points3D[p].xyz for p in sorted(whole.points3D)])[kept]
    found = np.array([model.points3D[p].xyz for p in sorted(model.points3D)])
    np.testing.assert_allclose(found, expected, atol=1e-12)
    lengths = sorted(point.track.length() for point in model.points3D.values())
    assert lengths == sorted(seen[kept][:, picks].sum(axis=1))
    original = {image.name: image for image in whole.images.values()}
    for image in model.images.values():
        known = {tuple(np.round(p.xy, 6)) for p in original[image.name].points2D}
        assert {tuple(np.round(p.xy, 6)) for p in image.points2D} <= known
    assert model.compute_num_observations() == seen[kept][:, picks].sum()


def test_held_out_frames_are_never_trained_on(capture, tmp_path):
    out = tmp_path / "out"
    assert select(capture, "-k", 6, "--targets", "every:8", "-o", out) == 0
    held = [f"frame_{i:03d}.jpg" for i in (0, 8, 16)]
    picked = sorted(entry["name"] for entry in record_of(out)["frames"])
    assert not set(picked) & set(held)
    for folder, names in (("train", picked), ("test", held)):
        for layout in ("colmap", "nerfstudio"):
            assert list(read_capture(out / folder, layout, max_error=1).names) == names
        assert sorted(path.name for path in (out / folder / "images").iterdir()) == names
        content = json.loads((out / folder / "transforms.json").read_text())
        assert content["train_filenames"] == [f"images/{name}" for name in names]
    content = json.loads((out / "transforms_split.json").read_text())
    listed = [f"test/images/{name}" for name in held]
    assert content["test_filenames"] == content["val_filenames"] == listed
    assert content["train_filenames"] == [f"train/images/{name}" for name in picked]
    assert not (out / "transforms.json").exists()
    reasons = {entry["name"]: entry["reason"] for entry in record_of(out)["left"]}
    assert [name for name, why in reasons.items() if "held out" in why] == held


def test_images_are_linked_where_asked_and_possible_or_copied(capture, tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(errno.EXDEV, "Invalid cross-device link")

    assert select(capture, "-k", 3, "-o", tmp_path / "linked", "--link") == 0
    assert select(capture, "-k", 3, "-o", tmp_path / "copied") == 0
    monkeypatch.setattr(os, "link", refuse)
    assert select(capture, "-k", 3, "-o", tmp_path / "elsewhere", "--link") == 0
    for name in (tmp_path / "linked" / "frames.txt").read_text().split():
        original = capture / "images" / name
        assert (tmp_path / "linked" / "images" / name).samefile(original)
        for copy in ("copied", "elsewhere"):
            assert not (tmp_path / copy / "images" / name).samefile(original)
            assert (tmp_path / copy / "images" / name).read_bytes() == original.read_bytes()


@pytest.mark.parametrize("more", [(), ("--link",), ("--long-side", 64)])
def test_no_trainer_turns_the_images_that_it_is_given(more, capture, tmp_path):
    """EXIF asks for a quarter turn; the cameras, 64 wide and 48 high, describe what is stored."""
    stored = {}
    for path in (capture / "images").iterdir():
        stored[path.name] = cv2.imread(str(path))
        state_orientation(path, 6)
        assert cv2.imread(str(path)).shape == (64, 48, 3)
    assert select(capture, "-k", 3, *more, "-o", tmp_path / "out") == 0
    content = json.loads((tmp_path / "out" / "transforms.json").read_text())
    assert (content["w"], content["h"]) == (64, 48)
    written = sorted((tmp_path / "out" / "images").iterdir())
    assert len(written) == 3
    for path in written:
        shown = cv2.imread(str(path))
        assert shown.shape == (48, 64, 3)
        assert np.abs(shown.astype(int) - stored[path.name]).mean() < 5  # coded anew
        original = capture / "images" / path.name
        assert path.stat().st_nlink == 1
        assert cv2.imread(str(original)).shape == (64, 48, 3)


def test_intrinsics_follow_images_smaller_than_their_camera(tmp_path):
    write_ring(tmp_path / "capture", shrink=2)
    assert select(tmp_path / "capture", "-k", 4, "-o", tmp_path / "out") == 0
    content = json.loads((tmp_path / "out" / "transforms.json").read_text())
    assert [content[key] for key in ("w", "h")] == [32, 24]
    assert [content[key] for key in ("fl_x", "fl_y", "cx", "cy")] == [30, 30.5, 16, 12]


@pytest.mark.parametrize(
    ("model", "params", "expected"),
    [
        ("SIMPLE_RADIAL", [60, 32, 24, 0.02], {"fl_y": 60, "k1": 0.02}),
        ("OPENCV_FISHEYE", [35, 36, 32, 24, 0.03, 0.02, 0.01, 0.005], {"fl_y": 36, "k4": 0.005}),
    ],
)
def test_transforms_state_the_camera_as_nerfstudio_has_it(model, params, expected, tmp_path):
    write_ring(tmp_path / "capture")
    sparse = tmp_path / "capture" / "sparse" / "0"
    built = pycolmap.Reconstruction(str(sparse))
    built.cameras[1].model = getattr(pycolmap.CameraModelId, model)
    built.cameras[1].params = params
    built.write_binary(str(sparse))
    assert select(tmp_path / "capture", "-k", 4, "--max-error", 1, "-o", tmp_path / "out") == 0
    content = json.loads((tmp_path / "out" / "transforms.json").read_text())
    assert {key: content[key] for key in expected} == expected
    assert (content["camera_model"] == model) == (model == "OPENCV_FISHEYE")
    whole = read_capture(tmp_path / "capture", "colmap", long_side=64, max_error=1)
    back = read_capture(tmp_path / "out", "nerfstudio", long_side=64, max_error=1)
    rows = [whole.names.index(name) for name in back.names]
    np.testing.assert_allclose(back.intrinsics, whole.intrinsics[rows], rtol=1e-9)


@pytest.mark.parametrize(
    ("model", "method"),
    [("OPENCV", "fsel"), *(("PINHOLE", name) for name in ("fsel", "nerf_director", "sharpest"))],
)
def test_geometry_only_opens_the_picks_alone(model, method, tmp_path, monkeypatch):
    write_ring(tmp_path / "capture", model=model)
    opened = []
    load = image_files.load
    monkeypatch.setattr(image_files, "load", lambda *a: opened.append(a) or load(*a))
    asked = ("-k", 4, "--geometry-only", "--method", method)
    assert select(tmp_path / "capture", *asked, "-o", tmp_path / "out") == 0
    written = record_of(tmp_path / "out")["frames"]
    assert sorted(file.name for file, _ in opened) == sorted(f["name"] for f in written)
    assert written[0]["sharpness_rank"] is None


def test_every_form_of_targets(capture, tmp_path):
    names = tmp_path / "names.txt"
    names.write_text("frame_003.jpg\n\nframe_011.jpg\n")
    forms = {
        "every:6": ("one frame in 6, held out", 4, [0, 6, 12, 18]),
        str(names): ("2 frames of names.txt, held out", 2, [3, 11]),
        "orbit": ("an orbit", 60, []),
        "trajectory": ("the smoothed camera path", 60, []),
        str(camera_path(tmp_path, ring(5))): ("the poses of path.json", 5, []),
    }
    for number, (form, (kind, views, held)) in enumerate(forms.items()):
        out = tmp_path / f"out{number}"
        assert select(capture, "-k", 4, "--targets", form, "-o", out) == 0
        stated = record_of(out)["targets"]
        assert (stated["kind"], stated["views"], stated["far"]) == (kind, views, 0)
        assert stated["held_out"] == [f"frame_{i:03d}.jpg" for i in held]


def test_json_is_the_only_output_that_scripts_see(capture, tmp_path, capsys):
    assert select(capture, "-k", 4, "--json", "-o", tmp_path / "out") == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out) == record_of(tmp_path / "out")
    assert printed.err == ""
    assert select(capture, "-k", 4, "--quiet", "-o", tmp_path / "quiet") == 0
    printed = capsys.readouterr()
    assert printed.out == printed.err == ""
