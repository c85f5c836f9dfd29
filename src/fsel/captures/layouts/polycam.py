"""Polycam's raw data: an image and a camera in JSON for each keyframe."""

from __future__ import annotations

from pathlib import Path

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts import bare
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.parsing import member, number, numbers, read_json
from fsel.core.geometry import from_opengl

FOLDERS = (("corrected_images", "corrected_cameras"), ("images", "cameras"))
"""In keyframes/: images and cameras as Polycam optimised them, else as ARKit tracked them."""
POSE = [f"t_{row}{column}" for row in range(3) for column in range(4)]
PINHOLE = ("fx", "fy", "cx", "cy")


def read(folder: Path, min_blur_score: float = 0.0) -> RawCapture:
    """Read the keyframes, without those whose `blur_score` is lower; sharp images have a high one.

    Poses are camera to world with OpenGL axes. The phone's images lie on their side where it was
    held upright, and so do their cameras: nothing is to be turned.
    """
    found = _find(folder)
    if found is None:
        raise FileNotFoundError(f"{folder}: no {FOLDERS} in keyframes. Hint: export the raw data")
    frames, dropped = [], {}
    for file in bare.find(found[0]):
        path = found[1] / f"{file.stem}.json"
        if not path.is_file():
            dropped[file.name] = "no camera of this name"
            continue
        content = read_json(path)
        if number(content.get("blur_score", min_blur_score), path, "blur_score") < min_blur_score:
            dropped[file.name] = f"blur_score below {min_blur_score:g}"
            continue
        pose = numbers([member(content, key, path) for key in POSE], (12,), path, "t_00 to t_23")
        width, height = (
            int(number(member(content, k, path), path, k)) for k in ("width", "height")
        )
        params = tuple(number(member(content, key, path), path, key) for key in PINHOLE)
        camera = Camera("PINHOLE", width, height, params)
        frames.append((file, from_opengl(pose.reshape(3, 4)), camera))
    return one_pass(frames, dropped)


def _find(folder: Path) -> tuple[Path, Path] | None:
    """Return the folders of images and of their cameras."""
    pairs = [
        (folder / "keyframes" / images, folder / "keyframes" / cameras)
        for images, cameras in FOLDERS
    ]
    return next((pair for pair in pairs if pair[0].is_dir() and pair[1].is_dir()), None)


LAYOUT = Layout(
    "polycam", lambda folder: _find(folder) is not None, read, None, ("min_blur_score",)
)
