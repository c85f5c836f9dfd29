"""Bad frames in the commands: told, listed, left out, and what keeps them."""

import csv

import cv2
import numpy as np
import pycolmap
import pytest
from small_captures import damage_pixels, film, record_of, ring, select

import fsel

BLURRED, DARK, BROKEN = "frame_005.jpg", "frame_011.jpg", "frame_017.jpg"
BAD = {BLURRED, DARK, BROKEN}


def blur(shot):
    return cv2.GaussianBlur(shot, (0, 0), 4)


def darken(shot):
    return shot // 2


@pytest.fixture
def spoilt(capture):
    film(capture, change={5: blur, 11: darken})
    damage_pixels(capture / "images" / BROKEN, (240, 180))
    return capture


def test_bad_frames_are_left_out_and_listed(spoilt, tmp_path, capsys):
    assert select(spoilt, "-k", 21, "-o", tmp_path / "out") == 0
    content = record_of(tmp_path / "out")
    bad = {entry["name"]: entry for entry in content["bad"]}
    kinds = {BLURRED: "blurred", DARK: "exposure", BROKEN: "unreadable"}
    assert {name: entry["kind"] for name, entry in bad.items()} == kinds
    assert all(entry["left_out"] and entry["value"] > entry["threshold"] for entry in bad.values())
    left = {entry["name"]: entry["reason"] for entry in content["left"]}
    assert left.keys() == kinds.keys()
    assert left[BLURRED].startswith("blurred: ")
    assert "times less detail than" in left[BLURRED]
    with open(tmp_path / "out" / "bad_frames.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == list(bad)
    assert float(rows[0]["value"]) == bad[BLURRED]["value"]
    assert set(fsel.bad_frames(spoilt)) == kinds.keys()
    assert f"exposure  1 frame left out: {DARK} (" in capsys.readouterr().out
    assert {f["blurred"] for f in content["frames"]} == {False}
    assert (tmp_path / "out" / "report.html").read_text().count('class="frame bad"') == 3


def test_the_call_leaves_out_what_the_command_does(spoilt):
    assert not BAD & set(fsel.select(spoilt, "auto", "every:8", patience=0).names)
    assert not BAD & set(fsel.select(spoilt, 21, patience=0).names)
    assert set(fsel.select(spoilt, 24, patience=0).names) > BAD
    assert len(fsel.select(spoilt, 21, patience=0, keep_bad=True)) == 21
    read = fsel.read_capture(spoilt, skip_unreadable=True)
    assert not BAD & set(fsel.select(read, 21, patience=0))


def test_the_least_bad_come_back_where_so_many_are_wanted(spoilt, tmp_path):
    assert [name for name in fsel.select(spoilt, 22, patience=0).names if name in BAD] == [DARK]
    wanted = tmp_path / "wanted.txt"
    wanted.write_text(f"{BLURRED}\n")
    assert select(spoilt, "-k", 6, "--always", wanted, "-o", tmp_path / "always") == 0
    first = record_of(tmp_path / "always")["frames"][0]
    assert (first["name"], first["blurred"]) == (BLURRED, True)


def test_keep_bad_looks_for_none(capture, tmp_path):
    film(capture, change={5: blur})
    assert select(capture, "-k", 24, "--keep-bad", "-o", tmp_path / "out") == 0
    content = record_of(tmp_path / "out")
    assert (content["bad"], len(content["frames"])) == (None, 24)
    assert not (tmp_path / "out" / "bad_frames.csv").exists()


def test_without_images_poses_are_still_judged(capture, tmp_path):
    model = pycolmap.Reconstruction(str(capture / "sparse" / "0"))
    turn = cv2.Rodrigues(np.radians([0.0, 10, 0]))[0] @ ring(24)[7]
    model.images[8].frame.rig_from_world = pycolmap.Rigid3d(
        pycolmap.Rotation3d(turn[:, :3]), turn[:, 3]
    )
    model.write_binary(str(capture / "sparse" / "0"))
    assert select(capture, "-k", 22, "--geometry-only", "-o", tmp_path / "out") == 0
    (bad,) = record_of(tmp_path / "out")["bad"]
    assert (bad["name"], bad["kind"], bad["left_out"]) == ("frame_007.jpg", "misplaced", True)
    assert bad["measure"] == "pixels of reprojection error, 0% of its points fit"
