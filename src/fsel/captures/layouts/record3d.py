"""Record3D: images of a recording by number, and one JSON with their poses and intrinsics."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import Layout, RawCapture, existing, one_pass
from fsel.captures.parsing import check_turn, member, numbers, read_json, stated
from fsel.core.geometry import from_opengl

PLACES = (
    ("metadata.json", "rgb"),
    ("EXR_RGBD/metadata.json", "EXR_RGBD/rgb"),
    ("metadata", "rgbd"),
)
"""JSON and images: of the export as EXR and RGB, and of an .r3d archive that was unpacked."""
PER_FRAME = "perFrameIntrinsicCoeffs"


def read(folder: Path) -> RawCapture:
    """Read `poses` of seven numbers: a quaternion x, y, z, w and a place, camera to world with
    OpenGL axes. These are the stored image's axes, also where the phone was held upright."""
    from scipy.spatial.transform import Rotation  # here: slow to import, and seldom needed

    found = existing(folder, PLACES)
    if not found:
        raise FileNotFoundError(f"{folder}: none of {PLACES}. Hint: export EXR and RGB")
    path, images = found[0]
    content = read_json(path)
    poses = member(content, "poses", path)
    poses = numbers(poses, (len(poses) if isinstance(poses, list) else 0, 7), path, "poses")
    frames, dropped = [], {}
    for at, (pose, camera) in enumerate(
        zip(poses, _cameras(content, len(poses), path), strict=True)
    ):
        file = images / f"{at}.jpg"
        if not file.is_file():
            dropped[str(at)] = "no image was exported"
            continue
        check_turn(pose[:4], path, f"poses[{at}]")
        turn = Rotation.from_quat(pose[:4]).as_matrix()
        frames.append((file, from_opengl(np.column_stack([turn, pose[4:]])), camera))
    return one_pass(frames, dropped)


def _cameras(content: dict, count: int, path: Path) -> list[Camera]:
    """Return a camera a pose: its own, of a lens that focuses, or K, stored column by column."""
    width, height = (int(stated(content, key, path)) for key in ("w", "h"))
    if content.get(PER_FRAME):
        params = numbers(content[PER_FRAME], (count, 4), path, PER_FRAME)
    else:
        k = numbers(member(content, "K", path), (9,), path, "K")
        params = np.tile([k[0], k[4], k[6], k[7]], (count, 1))
    return [Camera("PINHOLE", width, height, tuple(row)) for row in params.tolist()]


LAYOUT = Layout("record3d", lambda folder: bool(existing(folder, PLACES)), read)
