"""`fsel select` on captures with masks, and on those whose frames lie in a video."""

import json

import cv2
import numpy as np
import pytest
from layout_recordings import recording, write_film, write_recording
from small_captures import record_of, select, write_video

from fsel.captures.images import files as image_files
from fsel.captures.read import read_capture


def bands(frames, width=64):
    """(N, 48, width) 0 or 255: a bright band that moves down from frame to frame."""
    rows = np.arange(48)[:, None] - np.arange(frames)[:, None, None]
    bright = np.where((rows >= 4) & (rows < 14), np.uint8(255), np.uint8(0))
    return np.repeat(bright, width, axis=2)


def exported(out, layout):
    """The subset read back, and the frames that it has of the whole."""
    back = read_capture(out, layout, long_side=64, max_error=1)
    return back, [int("".join(filter(str.isdigit, name))) for name in back.names]


@pytest.mark.parametrize("layout", ["colmap", "nerfstudio"])
def test_a_captures_masks_come_with_the_subset(capture, tmp_path, layout):
    masks, out = bands(24), tmp_path / "out"
    names = [f"frame_{i:03d}.jpg.png" for i in range(24)]
    image_files.write(masks, capture / "masks", names)
    assert select(capture, "-k", 5, "--targets", "every:8", "-o", out) == 0
    for folder, count in (("train", 5), ("test", 3)):
        back, frames = exported(out / folder, layout)
        assert len(frames) == count
        np.testing.assert_array_equal(back.masks, masks[frames] > 0)
        used = {f"{path.name}.png" for path in (out / folder / "images").iterdir()}
        assert {path.name for path in (out / folder / "masks").iterdir()} == used


def test_an_objects_masks_win_and_frames_without_one_are_black(capture, tmp_path, capsys):
    image_files.write(bands(24), capture / "masks", [f"frame_{i:03d}.jpg.png" for i in range(24)])
    shapes, out = tmp_path / "shapes", tmp_path / "out"
    mask = np.zeros((24, 32), np.uint8)  # half the images' size
    mask[8:16, 10:20] = 255
    image_files.write([mask] * 12, shapes, [f"frame_{2 * i:03d}.png" for i in range(12)])
    assert select(capture, "-k", 8, "--masks", shapes, "-o", out) == 0
    (said,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("object")]
    assert {"12", "24"} <= set(said.split())
    back, frames = exported(out, "nerfstudio")
    whole = np.zeros((48, 64), bool)
    whole[16:32, 20:40] = True
    assert {i % 2 for i in frames} == {0, 1}
    for i, found in zip(frames, back.masks, strict=True):
        np.testing.assert_array_equal(found, whole if i % 2 == 0 else np.zeros_like(whole))
    written = cv2.imread(str(next((out / "masks").iterdir())), cv2.IMREAD_UNCHANGED)
    assert written.dtype == np.uint8
    assert set(np.unique(written)) <= {0, 255}


def test_only_the_chosen_values_of_a_mask_are_white(tmp_path):
    """ScanNet++ counts 255 alone; grey of its anonymisation is black in the subset."""
    made = write_recording("scannetpp_dslr", tmp_path / "scene")
    folder = tmp_path / "scene" / "dslr" / "resized_anon_masks"
    for path in folder.iterdir():
        mask = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), np.where(mask > 0, mask, 200).astype(np.uint8))
    assert select(tmp_path / "scene", "-k", 4, "-o", tmp_path / "out") == 0
    for entry in record_of(tmp_path / "out")["frames"]:
        at = made.names.index(entry["name"].removesuffix(".JPG"))
        found = image_files.load_mask(
            tmp_path / "out" / "masks" / f"{entry['name']}.png", (255, 255)
        )
        np.testing.assert_array_equal(found, made.masks[at])


@pytest.mark.parametrize("more", [[], ["--geometry-only"], ["--targets", "every:5"]])
def test_frames_of_a_video_become_images(tmp_path, monkeypatch, more):
    """No frame of a ScanNet++ iPhone capture was extracted: the picks are, as JPEG, and masks."""
    made = recording("scannetpp_iphone")
    write_film(made, tmp_path / "scene")
    masks = np.repeat(bands(22)[..., None], 3, axis=3)
    write_video(tmp_path / "scene" / "iphone" / "rgb_mask.mkv", masks, 60, "FFV1")
    out = tmp_path / "out"
    monkeypatch.setattr("fsel.cli.select.thumbnails", None)  # no frame is decoded for a page alone
    assert select(tmp_path / "scene", "-k", 5, *more, "-o", out) == 0
    folder = out / "train" if "every:5" in more else out
    content = json.loads((folder / "transforms.json").read_text())
    listed = [frame["file_path"].removeprefix("images/") for frame in content["frames"]]
    assert sorted(path.name for path in (folder / "images").iterdir()) == sorted(listed)
    assert {entry["name"] for entry in record_of(out)["frames"]} == set(listed)
    assert [content[key] for key in ("w", "h")] == [64, 48]
    for name in listed:
        at = int(name[6:12])
        shown = image_files.load(folder / "images" / name)
        assert np.abs(shown.astype(int) - made.images[at]).mean() < 3
        found = image_files.load_mask(folder / "masks" / f"{name}.png", (255, 255))
        np.testing.assert_array_equal(found, masks[at, ..., 0] > 0)
    assert "data:image/jpeg" in (out / "report.html").read_text() or "--geometry-only" in more
