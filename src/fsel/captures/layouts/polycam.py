"""Polycam's raw data: an image and a camera in JSON for each keyframe."""

from __future__ import annotations

from pathlib import Path

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts import bare
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.parsing import member, number, numbers, read_json
from fsel.core.geometry import from_opengl

FOLDERS = (("corrected_images", "corrected_cameras"), ("images", "cameras"))
"""Images and cameras as Polycam optimised them, else as ARKit tracked them."""
POSE = [f"t_{row}{column}" for row in range(3) for column in range(4)]
PINHOLE = ("fx", "fy", "cx", "cy")


def read(folder: Path, min_blur_score: float = 0.0) -> RawCapture:
    """Read the keyframes, without those whose `blur_score` is lower; sharp images have a high one.

    Poses are camera to world with OpenGL axes. The phone's images lie on their side where it was
    held upright, and so do their cameras: nothing is to be turned.
    """
    images, cameras = _folders(folder)
    frames, dropped = [], {}
    for file in bare.find(images):
        path = cameras / f"{file.stem}.json"
        if not path.is_file():
            dropped[file.name] = "no camera of this name"
            continue
        content = read_json(path)
        if number(content.get("blur_score", min_blur_score), path, "blur_score") < min_blur_score:
            dropped[file.name] = f"blur_score below {min_blur_score:g}"
            continue
        pose = numbers([member(content, key, path) for key in POSE], (12,), path, "t_00 to t_23")
        size = [int(number(member(content, key, path), path, key)) for key in ("width", "height")]
        params = tuple(number(member(content, key, path), path, key) for key in PINHOLE)
        camera = Camera("PINHOLE", size[0], size[1], params)
        frames.append((file, from_opengl(pose.reshape(3, 4)), camera))
    return one_pass(frames, dropped)


def _folders(folder: Path) -> tuple[Path, Path]:
    """Return the folders of images and of their cameras, the corrected ones if both are there."""
    inner = folder / "keyframes" if (folder / "keyframes").is_dir() else folder
    for images, cameras in FOLDERS:
        if (inner / images).is_dir() and (inner / cameras).is_dir():
            return inner / images, inner / cameras
    allowed = " or ".join(" and ".join(pair) for pair in FOLDERS)
    raise FileNotFoundError(f"{inner}: no folders {allowed}. Hint: export Polycam's raw data")


def recognises(folder: Path) -> bool:
    """Look for folders of cameras, which hold a JSON file each."""
    places = [folder / "keyframes" / cameras for _, cameras in FOLDERS]
    places += [folder / cameras for _, cameras in FOLDERS]
    return any(place.is_dir() and any(place.glob("*.json")) for place in places)


LAYOUT = Layout("polycam", recognises, read, options=("min_blur_score",))
