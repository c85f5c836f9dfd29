"""Record3D: images of a recording by number, and one JSON with their poses and intrinsics."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.parsing import check_turn, member, number, numbers, read_json
from fsel.core.geometry import from_opengl

PLACES = (("metadata.json", "rgb"), ("metadata", "rgbd"))
"""JSON and images of the export as EXR and RGB, and of an .r3d archive that was unpacked."""
WRAPPER = "EXR_RGBD"
PER_FRAME = "perFrameIntrinsicCoeffs"


def read(folder: Path) -> RawCapture:
    """Read `poses` of seven numbers: a quaternion x, y, z, w and a place, camera to world with
    OpenGL axes. These are the stored image's axes, also where the phone was held upright."""
    from scipy.spatial.transform import Rotation  # here: slow to import, and seldom needed

    found = _find(folder)
    if found is None:
        allowed = " or ".join(f"{name} with {images}" for name, images in PLACES)
        raise FileNotFoundError(f"{folder}: no Record3D export; allowed: {allowed}")
    path, images = found
    content = read_json(path)
    poses = _rows(content, "poses", 7, path)
    cameras = _cameras(content, len(poses), path)
    frames, dropped = [], {}
    for at, (pose, camera) in enumerate(zip(poses, cameras, strict=True)):
        file = next((f for end in ("jpg", "png") if (f := images / f"{at}.{end}").is_file()), None)
        if file is None:
            dropped[str(at)] = "no image was exported"
            continue
        check_turn(pose[:4], path, f"poses[{at}]")
        turn = Rotation.from_quat(pose[:4]).as_matrix()
        frames.append((file, from_opengl(np.column_stack([turn, pose[4:]])), camera))
    return one_pass(frames, dropped)


def _find(folder: Path) -> tuple[Path, Path] | None:
    """Return the JSON and the folder of images."""
    for root in (folder, folder / WRAPPER):
        for name, images in PLACES:
            if (root / name).is_file() and (root / images).is_dir():
                return root / name, root / images
    return None


def _cameras(content: dict, count: int, path: Path) -> list[Camera]:
    """Return a camera a frame: its own, of a lens that focuses, or else K, which is stored column
    by column."""
    width, height = (int(number(member(content, key, path), path, key)) for key in ("w", "h"))
    if content.get(PER_FRAME):
        params = _rows(content, PER_FRAME, 4, path)
        if len(params) != count:
            raise ValueError(f"{path}: {len(params)} {PER_FRAME}; allowed: {count}, one a pose")
    else:
        k = numbers(member(content, "K", path), (9,), path, "K")
        params = np.tile([k[0], k[4], k[6], k[7]], (count, 1))
    return [Camera("PINHOLE", width, height, tuple(row)) for row in params.tolist()]


def _rows(content: dict, key: str, width: int, path: Path) -> np.ndarray:
    """Return a list of lists of so many numbers as an array."""
    rows = member(content, key, path)
    count = len(rows) if isinstance(rows, list) else 0
    return numbers(rows, (count, width), path, key)


LAYOUT = Layout("record3d", lambda folder: _find(folder) is not None, read)
