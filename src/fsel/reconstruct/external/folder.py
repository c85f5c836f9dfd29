"""Folder that a program is given: what it finds there, and what it must leave.

    images/000000.png ...   the selected frames, undistorted, in the capture's order
    masks/000000.png ...    white where a pixel counts, when the capture has masks
    transforms.json         their cameras as nerfstudio states them, in the capture's own world
    sparse/0/*.bin          their cameras as COLMAP states them, and the points that two of them see
    sparse_pc.ply           those points
    targets.json            cameras to render, without images
    renderings/000000.png   to be written: one 8-bit RGB image a target, of the target's size

`targets.json` has `frames`, a list of `file` (below `renderings`), `w`, `h`, `fl_x`, `fl_y`, `cx`,
`cy` in pixels (the top left pixel's centre is 0.5, 0.5), `transform_matrix` (4x4 camera to world,
OpenGL axes) and `world_to_camera` (4x4, OpenCV axes).
"""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.bindings import pycolmap
from fsel.captures.colmap.model import build_model, write_capture_model
from fsel.core.capture import Capture, Views
from fsel.core.geometry import invert_pose
from fsel.core.points import NO_POINTS, grouped_rows
from fsel.core.programs.outcome import MISSING, SIZE, Unfinished

RENDERINGS, CLOUD = "renderings", "sparse_pc.ply"
OPENGL = np.diag([1.0, -1, -1, 1])


def write_inputs(folder: Path, capture: Capture) -> None:
    """Write all but the targets.

    Args:
        folder: empty.
        capture: of the selected frames alone, with points that two of them or more see.
    """
    names = [f"{row:06d}.png" for row in range(len(capture))]
    content = _lens(capture.views, 0) | {"camera_model": "OPENCV", "frames": []}
    for row, name in enumerate(names):
        _write(folder / "images" / name, np.asarray(capture.images[row])[:, :, ::-1])
        frame = {"file_path": f"images/{name}", **_camera(capture.views, row)}
        if capture.masks is not None:
            _write(folder / "masks" / name, np.asarray(capture.masks[row]).astype(np.uint8) * 255)
            frame["mask_path"] = f"masks/{name}"
        content["frames"].append(frame)
    if _write_model(folder, capture, names):
        content["ply_file_path"] = CLOUD
    for split in ("train", "val", "test"):
        content[f"{split}_filenames"] = [frame["file_path"] for frame in content["frames"]]
    (folder / "transforms.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


def write_targets(folder: Path, views: Views) -> None:
    """Write targets.json, and an empty folder for the renderings."""
    frames = []
    for row in range(len(views)):
        pose = np.vstack([views.world_to_camera[row], [0, 0, 0, 1]])
        camera = _camera(views, row) | {"world_to_camera": pose.tolist()}
        frames.append({"file": f"{row:06d}.png", **camera})
    (folder / RENDERINGS).mkdir()
    (folder / "targets.json").write_text(json.dumps({"frames": frames}, indent=1), encoding="utf-8")


def read_renderings(folder: Path, views: Views) -> np.ndarray:
    """(T, h, w, 3) float32 images in [0, 1] that the program left.

    Raises:
        Unfinished: for an image that is missing, unreadable, no 8-bit RGB, or of another size.
    """
    width, height = views.size
    out = np.empty((len(views), height, width, 3), np.float32)
    for row in range(len(views)):
        path = folder / RENDERINGS / f"{row:06d}.png"
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) if path.is_file() else None
        if image is None:
            there = "is no image" if path.is_file() else "is missing"
            raise Unfinished(MISSING, f"target {row} of {len(views)}: {path.name} {there}")
        if image.dtype != np.uint8 or image.shape != (height, width, 3):
            raise Unfinished(
                SIZE,
                f"{path.name} has shape {image.shape} and type {image.dtype}; expected "
                f"({height}, {width}, 3) and uint8",
            )
        out[row] = image[:, :, ::-1].astype(np.float32) / 255
    return out


def _write(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    if not cv2.imwrite(str(path), image):
        raise OSError(f"{path}: could not be written")


def _lens(views: Views, row: int) -> dict:
    fx, fy, cx, cy = views.intrinsics[row].tolist()
    width, height = views.size
    return {"w": width, "h": height, "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy}


def _camera(views: Views, row: int) -> dict:
    matrix = np.vstack([invert_pose(views.world_to_camera[row]), [0, 0, 0, 1]]) @ OPENGL
    return _lens(views, row) | {"transform_matrix": matrix.tolist()}


def _write_model(folder: Path, capture: Capture, names: list[str]) -> bool:
    """A COLMAP model: a pinhole camera a lens, and the points where the cameras see them.

    Returns:
        Whether there are points.
    """
    points = capture.points or NO_POINTS
    rows_of = grouped_rows(points.track_frame, len(capture))
    seen = [points.track_point[rows] for rows in rows_of]
    width, height = capture.size
    pixels = []
    for rows, pose, params in zip(seen, capture.world_to_camera, capture.intrinsics, strict=True):
        local = points.xyz[rows] @ pose[:, :3].T + pose[:, 3]
        pixels.append(local[:, :2] / local[:, 2:] * params[:2] + params[2:])
    cameras = [
        pycolmap.Camera(model="PINHOLE", width=width, height=height, params=params)
        for params in capture.intrinsics
    ]
    poses = capture.world_to_camera
    model = build_model(names, cameras, poses, points.xyz, points.rgb, seen, pixels)
    return write_capture_model(model, folder, folder / CLOUD)
