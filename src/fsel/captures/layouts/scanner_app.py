"""3D Scanner App, exported as all data: frame_00000.jpg and .json, as ARKit tracked them."""

from __future__ import annotations

from pathlib import Path

from fsel.captures.colmap.camera import Camera
from fsel.captures.images import files as image_files
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.parsing import member, numbers, read_json
from fsel.core.geometry import from_opengl

POSE = "cameraPoseARFrame"


def read(folder: Path) -> RawCapture:
    """Read the frames that have an image; depth alone is stored of the others.

    Poses are camera to world with OpenGL axes, row by row, and intrinsics of the image's size.
    """
    frames, dropped = [], {}
    for path in sorted(folder.glob("frame_*.json")):
        file = path.with_suffix(".jpg")
        if not file.is_file():
            dropped[path.stem] = "no image was exported"
            continue
        content = read_json(path)
        pose = numbers(member(content, POSE, path), (16,), path, POSE).reshape(4, 4)
        k = numbers(member(content, "intrinsics", path), (9,), path, "intrinsics")
        params = (k[0], k[4], k[2], k[5])
        camera = Camera("PINHOLE", *image_files.size_of(file), tuple(map(float, params)))
        frames.append((file, from_opengl(pose), camera))
    return one_pass(frames, dropped)


def recognises(folder: Path) -> bool:
    """Look for a frame in JSON with the pose that ARKit gave it."""
    first = next(folder.glob("frame_*.json"), None)
    return first is not None and POSE.encode() in first.read_bytes()


LAYOUT = Layout("scanner_app", recognises, read)
