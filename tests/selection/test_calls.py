"""The Python calls: what they take, what they refuse, what they print and what they write."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pycolmap
import pytest
from small_captures import write_ring

import fsel
from fsel.captures import opening
from fsel.captures.layouts.nerfstudio import matrix_of
from fsel.cli import main
from fsel.selection.api import captured

EVERY = "every:6"
STRAIGHT = np.eye(4)[:3]


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    """A ring that no turn maps onto itself: no two selections are worth the same."""
    folder = tmp_path_factory.mktemp("ring") / "ring"
    write_ring(folder)
    model = pycolmap.Reconstruction(str(folder / "sparse" / "0"))
    moves = np.random.default_rng(0).normal(0, 0.005, (24, 3))
    for frame, move in zip(model.frames.values(), moves, strict=True):
        turn, at = frame.rig_from_world.rotation, frame.rig_from_world.translation
        frame.rig_from_world = pycolmap.Rigid3d(turn, at + move)
    model.write(str(folder / "sparse" / "0"))
    return folder


@pytest.fixture(scope="module")
def capture(ring):
    return fsel.read_capture(ring, long_side=64)


@pytest.fixture(scope="module")
def content(capture):
    """Content of a transforms.json of the ring."""
    frames = [
        {"file_path": f"images/{name}", "transform_matrix": matrix_of(pose, STRAIGHT)}
        for name, pose in zip(capture.names, capture.world_to_camera, strict=True)
    ]
    return {"w": 64, "h": 48, "fl_x": 60, "fl_y": 61, "cx": 32, "cy": 24, "frames": frames}


def written(folder):
    """Files below a folder and their bytes, but those that a command adds to the capture."""
    ours = ("report.html", "selection.json", "bad_frames.csv", ".fsel")
    files = (path for path in Path(folder).rglob("*") if path.is_file() and path.name not in ours)
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.mark.parametrize("line", ["-k 6 --targets every:6", "-k 6", "-k auto --targets every:6"])
def test_a_folder_gives_the_picks_and_the_files_of_the_command(line, ring, quick_trials, tmp_path):
    words = line.split()
    k = words[1] if words[1] == "auto" else int(words[1])
    chosen = fsel.select(str(ring), k, words[3] if words[3:] else None)
    assert main(["select", str(ring), *words, "-o", str(tmp_path / "command"), "--quiet"]) == 0
    names = (tmp_path / "command" / "frames.txt").read_text().split()
    assert list(chosen.names) == names
    assert chosen.export(tmp_path / "call") == tmp_path / "call"
    assert written(tmp_path / "call") == written(tmp_path / "command")


def test_a_capture_that_was_read_is_exported_from_its_files(ring, tmp_path):
    small = fsel.read_capture(ring, long_side=32).subset(np.array([9, 3, 17, 12, 5, 20]))
    chosen = fsel.select(small, 3, targets=["frame_003.jpg"])
    chosen.export(tmp_path / "out")
    images = {path.name for path in (tmp_path / "out" / "train" / "images").iterdir()}
    assert images == set(chosen.names)
    assert [p.name for p in (tmp_path / "out/test/images").iterdir()] == ["frame_003.jpg"]
    assert (tmp_path / "out/test/images/frame_003.jpg").read_bytes() == (
        ring / "images/frame_003.jpg"
    ).read_bytes()
    with pytest.raises(FileExistsError, match="force=True"):
        chosen.export(tmp_path / "out")
    chosen.export(tmp_path / "out", force=True, link=True)


def test_a_reconstruction_and_a_json_are_selected_from_without_images(
    ring, content, tmp_path, monkeypatch
):
    model = pycolmap.Reconstruction(str(ring / "sparse" / "0"))
    monkeypatch.chdir(tmp_path)
    line = "-k 6 --geometry-only -o blind --quiet"
    assert main(["select", str(ring), *line.split()]) == 0
    names = tuple((tmp_path / "blind" / "frames.txt").read_text().split())
    assert fsel.select(model, 6).names == fsel.select(content, 6).names == names
    held_out = fsel.select(model, 6, EVERY)
    assert held_out.names == fsel.select(ring, 6, EVERY, sharpness=np.zeros(24), patience=0).names
    with pytest.raises(ValueError, match="poses but no images"):
        fsel.select(model, 6, method="sharpest")
    with pytest.raises(ValueError, match="no image files"):
        held_out.export(tmp_path / "out")


def test_a_json_whose_images_are_here_is_selected_from_with_them(ring, content, monkeypatch):
    monkeypatch.chdir(ring)
    chosen = fsel.select(content, 6, EVERY, "sharpest")
    assert chosen.names == fsel.select(ring, 6, EVERY, "sharpest").names


def test_a_video_has_its_poses_found_as_by_the_command(ring, monkeypatch, tmp_path):
    asked = []
    (tmp_path / "walk.mp4").touch()
    monkeypatch.setattr(opening, "opened", lambda how: asked.append(how) or captured(ring))
    chosen = fsel.select(tmp_path / "walk.mp4", 5, EVERY, patience=0)
    with pytest.raises(ValueError, match="views=True"):
        fsel.select(tmp_path / "walk.mp4", 5, views=True)
    walk = opening.Opening((tmp_path / "walk.mp4",))
    assert asked == [replace(walk, wanted=5), replace(walk, views=True)]
    assert len(chosen) == 5


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"k": 2.5}, r"k is 2\.5 \(float\); expected a whole number, 'auto' or fsel\.Auto"),
        ({"k": True}, r"k is True \(bool\); expected"),
        ({"k": "many"}, "k is 'many'; allowed: a number of frames, or 'auto'"),
        ({"targets": 7}, r"targets is 7 \(int\); expected names or numbers of the 24 frames"),
        ({"targets": [0.5]}, r"targets is \[0\.5\] \(list\); expected names or numbers"),
        ({"targets": np.zeros((2, 2, 2))}, r"targets are an array of \(2, 2, 2\) float64"),
        ({"targets": np.zeros((2, 3, 4))}, "target 0.*determinant 0"),
        ({"method": 7}, r"method is 7 \(int\); expected a key of fsel\.METHODS"),
        ({"method": "unifrom"}, "Hint: did you mean 'uniform'"),
        ({"seed": "x"}, r"seed is 'x' \(str\); expected a whole number"),
        ({"weights": 3}, r"weights is 3 \(int\); expected a file"),
        ({"patience": "x"}, r"patience is 'x' \(str\); .* seconds"),
        ({"never": 3}, r"frames is 3 \(int\); expected names or num"),
    ],
)
def test_wrong_arguments_say_what_was_expected(asked, said, ring):
    with pytest.raises((TypeError, ValueError), match=said):
        fsel.select(ring, **{"k": 5} | asked)


def test_what_is_no_capture_is_refused(ring):
    with pytest.raises(TypeError, match=r"capture is 3 \(int\); expected a folder, a video, a Cap"):
        fsel.select(3, 5)
    for call in (fsel.read_capture, fsel.bad_frames):
        with pytest.raises(TypeError, match=r"path is 3 \(int\); expected a folder"):
            call(3)
    with pytest.raises(TypeError, match=r"long_side is 'x' .* of pixels"):
        fsel.read_capture(ring, long_side="x")


def test_targets_as_poses_names_numbers_or_a_mask(capture):
    poses = capture.world_to_camera[::6]
    views = fsel.select(capture, 5, capture.view(np.arange(0, 24, 6)))
    square = np.tile(np.eye(4), (4, 1, 1))
    square[:, :3] = poses
    assert fsel.select(capture, 5, poses).names == views.names
    assert fsel.select(capture, 5, square.tolist()).names == views.names
    numbers = fsel.select(capture, 5, [0, 6, 12, 18], patience=0)
    assert fsel.select(capture, 5, capture.names[::6], patience=0).names == numbers.names
    masked = fsel.select(capture, 5, np.arange(24) % 6 == 0, patience=0)
    assert masked.names == numbers.names
    np.testing.assert_array_equal(numbers.held_out, [0, 6, 12, 18])
    assert len(views.held_out) == 0


def test_fit_and_evaluate_take_names(capture):
    by_name = fsel.fit(capture, capture.names[1:20:3])
    by_number = fsel.fit(capture, range(1, 20, 3))
    scores = fsel.evaluate(capture, by_name, capture.names[::8])["psnr"]
    np.testing.assert_array_equal(scores, fsel.evaluate(capture, by_number, [0, 8, 16])["psnr"])
    with pytest.raises(ValueError, match=r"1 frame not in the capture, the first 'x.jpg'"):
        fsel.fit(capture, ["x.jpg", capture.names[0]])
    with pytest.raises(ValueError, match="frames are repeated: 3 are named, 2 distinct"):
        fsel.fit(capture, [0, 1, 1])
    with pytest.raises(TypeError, match=r"capture is .*; expected a Capture. Hint: fsel.read_capt"):
        fsel.fit("ring", [0, 1])
    with pytest.raises(TypeError, match=r"frames is .*; expected names or numbers of the 24"):
        fsel.fit(capture, [0.5, 1.5])
    with pytest.raises(TypeError, match=r"frames is 'every:8' \(str\); expected names or numbers"):
        fsel.evaluate(capture, by_name, "every:8")
    with pytest.raises(TypeError, match=r"model is 3 \(int\); expected what fsel.fit returned"):
        fsel.evaluate(capture, 3, [0, 8])


def test_what_is_printed_is_short(capture):
    chosen = fsel.select(capture, 5, EVERY, patience=0)
    assert tuple(chosen) == chosen.names
    first = ", ".join(chosen.names[:3])
    assert repr(chosen) == f"Selection(5 frames: {first}, ...; 4 held out)"
    assert repr(capture).startswith("Capture(24 frames of 64x48, 1 sequence, 80 points; colmap at")
    assert repr(capture.views) == "Views(24 poses, 64x48)"
    assert repr(fsel.LAYOUTS).startswith("<16 layouts: scannetpp_dslr, ")
    assert dir(fsel) == sorted([*fsel.__all__, "__version__"])
