"""Paths as Windows writes them; see `test_core` for the modules that it lacks."""

import json
from pathlib import Path, PureWindowsPath

import pytest
from small_captures import pose_anew, write_ring

import fsel
from fsel.captures.parsing import inside, slashed


def as_windows_wrote_it(folder):
    """A nerfstudio capture whose paths have backslashes, and its names with slashes."""
    poses, _ = write_ring(folder)
    (folder / "images").rename(folder / "walk")
    (folder / "images").mkdir()
    (folder / "walk").rename(folder / "images" / "walk")
    names = [f"walk/frame_{i:03d}.jpg" for i in range(len(poses))]
    pose_anew(folder, poses, fl_y=61, cx=32, cy=24)
    content = json.loads((folder / "transforms.json").read_text())
    for frame, name in zip(content["frames"], names, strict=True):
        frame["file_path"] = str(PureWindowsPath("images", name))
    content["train_filenames"] = [frame["file_path"] for frame in content["frames"]]
    (folder / "transforms.json").write_text(json.dumps(content))
    return names


def test_paths_with_backslashes_are_read_as_with_slashes(tmp_path):
    names = as_windows_wrote_it(tmp_path / "ring")
    capture = fsel.read_capture(tmp_path / "ring", "nerfstudio", long_side=64)
    assert capture.names == tuple(names)
    assert set(capture.sequences) == {"walk"}
    held_out = tmp_path / "targets.txt"
    held_out.write_text("\r\n".join(str(PureWindowsPath(name)) for name in names[::6]) + "\r\n")
    chosen = fsel.select(capture, 5, targets=held_out, patience=0)
    assert not set(chosen.names) & set(names[::6])
    assert chosen.names == fsel.select(capture, 5, targets=names[::6], patience=0).names


@pytest.mark.parametrize("path", [r"C:\scan\0.png", "D:/scan/0.png", r"..\0.png", "/scan/0.png"])
def test_paths_that_lead_elsewhere_are_refused(path):
    with pytest.raises(ValueError, match="leads outside"):
        inside(Path("capture"), slashed(path), Path("transforms.json"))
