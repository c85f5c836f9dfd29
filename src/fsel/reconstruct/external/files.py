"""What a worker gets: arrays in mapped files, and images with cameras as trainers read them.

images/000000.png ...   the selected frames, undistorted, in the capture's order
masks/000000.png ...    white where a pixel counts, when the capture has masks
transforms.json         their cameras as nerfstudio states them, in the capture's own world
sparse/0/*.bin          their cameras as COLMAP states them, and the points that two of them see
sparse_pc.ply           those points
"""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.model import build_model, write_capture_model
from fsel.core.capture import Capture, Views
from fsel.core.geometry import invert_pose
from fsel.core.points import NO_POINTS, grouped_rows

POINTS = ("xyz", "rgb", "track_point", "track_frame")
CLOUD = "sparse_pc.ply"
OPENGL = np.diag([1.0, -1, -1, 1])


class Arrays:
    """A new folder of `.npy` files that stay mapped: making files takes milliseconds."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self.folder = folder
        self._mapped: dict[str, np.memmap] = {}

    def path(self, name: str) -> Path:
        """Return the file of an array."""
        return self.folder / f"{name}.npy"

    def room(self, name: str, shape: tuple[int, ...], kind: np.dtype) -> np.memmap:
        """Return a mapped array, with its former content."""
        found = self._mapped.get(name)
        if found is None or found.shape != shape or found.dtype != kind:
            path = self.path(name)
            path.unlink(missing_ok=True)
            found = np.lib.format.open_memmap(path, mode="w+", dtype=kind, shape=shape)
            self._mapped[name] = found
        return found

    def put(self, name: str, array: np.ndarray) -> Path:
        """Write an array; return its file."""
        self.room(name, array.shape, array.dtype)[...] = array
        return self.path(name)

    def put_frames(self, capture: Capture, points: bool) -> None:
        """Write the frames' images, masks and cameras, and the sparse points."""
        for name in ("images", "masks", "world_to_camera", "intrinsics"):
            if (array := getattr(capture, name)) is not None:
                self.put(name, array)
        if points and capture.points is not None:
            for name in POINTS:
                self.put(name, getattr(capture.points, name))

    def put_views(self, views: Views) -> Path:
        """Write a row for each view: its pose, then its intrinsics."""
        poses = views.world_to_camera.reshape(-1, 12)
        return self.put("views", np.concatenate([poses, views.intrinsics], axis=1))


def write_files(folder: Path, capture: Capture) -> None:
    """Write what the head of this module lists, of a capture of the selected frames alone."""
    names = [f"{row:06d}.png" for row in range(len(capture))]
    content = _lens(capture.views, 0) | {"camera_model": "OPENCV", "frames": []}
    for row, name in enumerate(names):
        _write(folder / "images" / name, np.asarray(capture.images[row])[:, :, ::-1])
        matrix = np.vstack([invert_pose(capture.world_to_camera[row]), [0, 0, 0, 1]]) @ OPENGL
        frame = {"file_path": f"images/{name}", **_lens(capture.views, row)}
        frame["transform_matrix"] = matrix.tolist()
        if capture.masks is not None:
            _write(folder / "masks" / name, np.asarray(capture.masks[row]).astype(np.uint8) * 255)
            frame["mask_path"] = f"masks/{name}"
        content["frames"].append(frame)
    if _write_model(folder, capture, names):
        content["ply_file_path"] = CLOUD
    for split in ("train", "val", "test"):
        content[f"{split}_filenames"] = [frame["file_path"] for frame in content["frames"]]
    (folder / "transforms.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


def _write(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    if not cv2.imwrite(str(path), image):
        raise OSError(f"{path}: could not be written")


def _lens(views: Views, row: int) -> dict:
    fx, fy, cx, cy = views.intrinsics[row].tolist()
    width, height = views.size
    return {"w": width, "h": height, "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy}


def _write_model(folder: Path, capture: Capture, names: list[str]) -> bool:
    """Write a COLMAP model of pinhole cameras and points; return whether there are points."""
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
