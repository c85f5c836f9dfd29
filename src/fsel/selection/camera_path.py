"""Camera paths from files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import OPENGL_TO_OPENCV, check_poses, invert_pose, rigid
from fsel.core.parsing import member, number, numbers, read_json, world_transform


def camera_path(path: Path, capture: Capture) -> Views:
    """Poses of a .json camera path, with the capture's first intrinsics.

    Args:
        path: nerfstudio's `camera_path` (in the frame of a `dataparser_transforms.json` beside it,
            if there is one), or `frames` with `transform_matrix` as in transforms.json.
        capture: whose world frame the poses should be in.

    Raises:
        ValueError: for a file that holds neither, or a pose that is no rigid motion.
    """
    content = read_json(path)
    key, field = ("camera_path", "camera_to_world")
    if key not in content:
        key, field = ("frames", "transform_matrix")
    listed = content.get(key)
    if not isinstance(listed, list) or not listed:
        raise ValueError(
            f"{path}: expected a list `camera_path` with `camera_to_world`, or `frames` with "
            "`transform_matrix`, of 4x4 numbers each"
        )
    poses = np.array([_matrix(view, field, path, f"{key}[{i}]") for i, view in enumerate(listed)])
    with np.errstate(over="ignore", invalid="ignore"):  # `check_poses` refuses what comes of it
        poses = _undone(poses, path, content)
        poses[:, :3, :3] = poses[:, :3, :3] @ OPENGL_TO_OPENCV
        inverse = rigid(invert_pose(poses))
    check_poses([f"{key}[{i}]" for i in range(len(inverse))], inverse, str(path))
    return Views(inverse, np.tile(capture.intrinsics[0], (len(poses), 1)), capture.size)


def _matrix(view: object, field: str, path: Path, where: str) -> np.ndarray:
    """(4, 4) of a view's sixteen numbers in a row, four rows of four, or three."""
    value = member(view, field, path, where)
    rows = len(value) if isinstance(value, list) else 0
    shape = (16,) if rows == 16 else (3, 4) if rows == 3 else (4, 4)
    pose = numbers(value, shape, path, f"{field} of {where}").reshape(-1, 4)
    if not np.isfinite(pose).all():
        raise ValueError(f"{path}: {field} of {where} must be finite, got {repr(value)[:80]}")
    return np.vstack([pose[:3], [0, 0, 0, 1]])


def _undone(poses: np.ndarray, path: Path, content: dict[str, Any]) -> np.ndarray:
    """Camera-to-world poses without the world transform that the file or its neighbour states."""
    beside = path.with_name("dataparser_transforms.json")
    scale, stored, source = 1.0, content.get("applied_transform"), path
    what = "applied_transform"
    if "camera_path" in content and beside.is_file():
        stated, source, what = read_json(beside), beside, "transform"
        scale = number(member(stated, "scale", beside), beside, "scale")
        stored = member(stated, "transform", beside)
        if scale <= 0:
            raise ValueError(f"{beside}: scale is {scale:g}; allowed: more than 0")
    if stored is None:
        return poses
    stored = stored[:3] if isinstance(stored, list) else stored
    full = np.vstack([world_transform(stored, source, what), [0, 0, 0, 1]])
    unscaled = poses.copy()
    unscaled[:, :3, 3] /= scale
    return np.linalg.inv(full) @ unscaled
