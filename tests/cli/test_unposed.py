"""`fsel select --no-poses`: what it picks, in which order, what it writes and refuses."""

import json
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from small_captures import film, run, write_video

from fsel.features.appearance import descriptors

REFUSED = {"-k 24": "1 to 23", "-k 5 --method fvs": "best_n", "-k auto": "-k 48"}
REFUSED |= {"-k 5 --targets every:8": "--targets", "-k 5 --los=1": "--los"}


@pytest.fixture
def photos(capture):
    """A folder of images alone: 5 is blurred, 11 dark, 13 the same as 12."""
    film(capture, change={5: lambda shot: cv2.GaussianBlur(shot, (0, 0), 4), 11: lambda s: s // 2})
    shutil.rmtree(capture / "sparse")
    shutil.copy(capture / "images" / "frame_012.jpg", capture / "images" / "frame_013.jpg")
    return capture


def select(photos, out, *words):
    assert run("select", photos, "--no-poses", "-o", out, *words) == 0
    return json.loads((out / "frames.json").read_text())


def test_bad_and_equal_frames_are_left_out(photos, tmp_path):
    content = select(photos, tmp_path / "out", "-k", 21)
    kinds = {5: "blurred", 11: "exposure", 13: "duplicate"}
    bad = {f"frame_{i:03d}.jpg": kind for i, kind in kinds.items()}
    assert {entry["name"]: entry["kind"] for entry in content["bad"]} == bad
    assert all(entry["left_out"] for entry in content["bad"])
    assert set(content["frames"]) == {f"frame_{i:03d}.jpg" for i in range(24)} - set(bad)
    assert len(select(photos, tmp_path / "all", "-k", 24, "--keep-bad")["frames"]) == 24


def test_the_order_starts_with_what_the_others_resemble_and_is_that_of_the_files(photos, tmp_path):
    out = tmp_path / "out"
    names = select(photos, out, "-k", 6, "--long-side", 60)["frames"]
    assert (out / "frames.txt").read_text().split() == names
    files = sorted((out / "images").iterdir())
    assert [file.name for file in files] == [f"{i:04d}_{name}" for i, name in enumerate(names)]
    images = np.array([cv2.imread(str(file))[..., ::-1] for file in files])
    assert images.shape == (6, 45, 60, 3)
    described = descriptors(images, "lab_hog")
    assert np.argmax((described @ described.T).sum(axis=1)) == 0
    assert len(list(out.iterdir())) == 5
    assert cv2.imread(str(out / "contact_sheet.jpg")).shape == (2 * 96, 3 * 128, 3)


def test_a_video_and_photos_of_two_shapes_go_together(photos, tmp_path):
    shots = [cv2.imread(str(file)) for file in sorted((photos / "images").iterdir())]
    cv2.imwrite(str(photos / "images" / "frame_002.jpg"), np.rot90(shots[2]))
    walk, out = write_video(tmp_path / "walk.avi", shots[14:]), tmp_path / "out"
    assert run("select", photos, walk, "--poses", "none", "-k", 12, "-o", out) == 0
    names = (out / "frames.txt").read_text().split()
    assert {name.split("/")[0] for name in names} == {"capture", "walk"}


def test_the_page_to_try_runs(photos, tmp_path, monkeypatch):
    shots = [cv2.imread(str(file)) for file in sorted((photos / "images").iterdir())]
    page = (Path(__file__).parents[2] / "docs" / "try.md").read_text()
    words = re.search(r"^!fsel (.* --no-poses .*)$", page, re.MULTILINE)[1]
    monkeypatch.chdir(tmp_path)
    write_video(tmp_path / "walk.mp4", shots, code="mp4v")
    assert run(*words.replace("30", "8").split()) == 0
    sheet = re.search(r'Image\("(.*)"\)', page)[1]
    assert cv2.imread(str(tmp_path / sheet)) is not None


@pytest.mark.parametrize("words", REFUSED)
def test_what_needs_poses_is_refused(words, photos, tmp_path, capsys):
    assert run("select", photos, "--no-poses", "-o", tmp_path / "out", *words.split()) == 1
    assert REFUSED[words] in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
