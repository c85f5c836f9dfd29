"""Polycam's raw data: an image and a camera in JSON for each keyframe."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts import bare
from fsel.captures.layouts.contract import Layout, RawCapture, existing, one_pass
from fsel.captures.parsing import number, read_json, stated
from fsel.core.geometry import from_opengl

FOLDERS = [(f"keyframes/{kind}images", f"keyframes/{kind}cameras") for kind in ("corrected_", "")]
"""Images and cameras: as Polycam optimised them, else as ARKit tracked them."""
POSE = [f"t_{row}{column}" for row in range(3) for column in range(4)]
PINHOLE = ("fx", "fy", "cx", "cy")


def read(folder: Path, min_blur_score: float = 0.0) -> RawCapture:
    """Read the keyframes, without those whose `blur_score` is lower; sharp images have a high one.

    Poses are camera to world with OpenGL axes. The phone's images lie on their side where it was
    held upright, and so do their cameras: nothing is to be turned.
    """
    found = existing(folder, FOLDERS)
    if not found:
        raise FileNotFoundError(f"{folder}: none of {FOLDERS}. Hint: export the raw data")
    images, cameras = found[0]
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
        pose = np.array([stated(content, key, path) for key in POSE])
        width, height = (int(stated(content, key, path)) for key in ("width", "height"))
        params = tuple(stated(content, key, path) for key in PINHOLE)
        camera = Camera("PINHOLE", width, height, params)
        frames.append((file, from_opengl(pose.reshape(3, 4)), camera))
    return one_pass(frames, dropped)


LAYOUT = Layout("polycam", lambda at: bool(existing(at, FOLDERS)), read, None, ("min_blur_score",))
