"""nerfstudio's transforms.json."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.layouts.base import (
    OPENGL_TO_OPENCV,
    Layout,
    RawCapture,
    inside,
    invert_pose,
    read_json,
)
from fsel.recording import Camera

DISTORTION = ("k1", "k2", "p1", "p2")
FISHEYE = ("k1", "k2", "k3", "k4")
FOLDERS = ("images_2", "images_4", "images_8")


def read(folder: Path) -> RawCapture:
    """A folder with transforms.json, paths relative to it."""
    return from_json(folder / "transforms.json", folder)


def from_json(
    path: Path, folder: Path, *, prefix: str = "", undo: np.ndarray | None = None
) -> RawCapture:
    """Frames of a transforms.json.

    Args:
        path: the JSON file.
        folder: the capture; image paths must stay inside it.
        prefix: folder, relative to the capture, that image names are relative to.
        undo: (3, 4) world transform that the poses carry though the file does not say so.

    Returns:
        Poses in the world before `applied_transform`, which is that of a COLMAP model beside it.
    """
    content = read_json(path)
    frames = content.get("frames")
    if not isinstance(frames, list) or not frames:
        raise ValueError(f"{path}: 'frames' must be a list of frames")
    applied = content.get("applied_transform")
    applied = undo if applied is None else np.array(applied, float)
    names, images, poses, cameras, masks, dropped = [], [], [], [], [], {}
    for frame in frames:
        name = frame["file_path"]
        if frame.get("is_bad"):
            dropped[name] = "marked bad by its owner"
            continue
        names.append(name.removeprefix("./").removeprefix("images/"))
        images.append(_existing(inside(folder, prefix + name, path), folder))
        poses.append(_pose(frame, applied, path))
        cameras.append(_camera(content, frame, path))
        if frame.get("mask_path"):
            masks.append(inside(folder, frame["mask_path"], path))
    if masks and len(masks) != len(names):
        raise ValueError(f"{path}: {len(masks)} of {len(names)} frames have a mask_path, not all")
    return RawCapture(
        names=names,
        images=images,
        world_to_camera=np.array(poses),
        cameras=cameras,
        sequences=[str(Path(name).parent) for name in names],
        masks=masks or None,
        dropped=dropped,
    )


def _existing(file: Path, folder: Path) -> Path:
    """The image, or its downscaled copy where only that was distributed."""
    if file.is_file():
        return file
    for candidate in FOLDERS:
        copy = file.parent.parent / candidate / file.name
        if copy.is_file():
            return copy
    return file


def _pose(frame: dict, applied: np.ndarray | None, path: Path) -> np.ndarray:
    matrix = np.array(frame.get("transform_matrix"), float)
    if matrix.shape != (4, 4):
        raise ValueError(f"{path}: transform_matrix of {frame['file_path']} is not 4x4")
    if applied is not None:
        full = np.vstack([applied, [0, 0, 0, 1]])
        matrix = np.linalg.inv(full) @ matrix
    matrix[:3, :3] = matrix[:3, :3] @ OPENGL_TO_OPENCV
    return invert_pose(matrix)


def _camera(content: dict, frame: dict, path: Path) -> Camera:
    """A top-level value wins over the frame's, as in nerfstudio."""
    merged = {**frame, **content}
    width, height = merged.get("w"), merged.get("h")
    focal = merged.get("fl_x")
    if focal is None and "camera_angle_x" in merged and width:
        focal = 0.5 * width / np.tan(merged["camera_angle_x"] / 2)
    if not (width and height and focal):
        raise ValueError(
            f"{path}: intrinsics of {frame['file_path']} are missing; need w, h and fl_x "
            "(or camera_angle_x), at the top level or in the frame"
        )
    cx, cy = merged.get("cx", width / 2), merged.get("cy", height / 2)
    pinhole = (focal, merged.get("fl_y", focal), cx, cy)
    fisheye = merged.get("camera_model") == "OPENCV_FISHEYE"
    extra = tuple(float(merged.get(key, 0.0)) for key in (FISHEYE if fisheye else DISTORTION))
    if fisheye:
        return Camera("OPENCV_FISHEYE", int(width), int(height), (*pinhole, *extra))
    if merged.get("k3") or merged.get("k4"):
        raise ValueError(f"{path}: k3 and k4 of a perspective camera are not supported")
    if any(extra):
        return Camera("OPENCV", int(width), int(height), (*pinhole, *extra))
    return Camera("PINHOLE", int(width), int(height), pinhole)


def to_json(camera: Camera, model: str) -> dict:
    """The intrinsic keys of a camera."""
    fx, fy, cx, cy, *extra = camera.params
    keys = FISHEYE if camera.model == "OPENCV_FISHEYE" else DISTORTION
    values = {"w": camera.width, "h": camera.height, "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy}
    return {"camera_model": model, **values, **dict(zip(keys, extra, strict=True))}


def matrix_of(world_to_camera: np.ndarray, applied: np.ndarray) -> list:
    """A transform_matrix: camera to world, OpenGL axes, in the transformed world."""
    matrix = np.eye(4)
    matrix[:3] = invert_pose(world_to_camera)
    matrix[:3, :3] = matrix[:3, :3] @ OPENGL_TO_OPENCV
    return (np.vstack([applied, [0, 0, 0, 1]]) @ matrix).tolist()


LAYOUT = Layout("nerfstudio", lambda folder: (folder / "transforms.json").is_file(), read)
