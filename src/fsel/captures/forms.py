"""One subset as trainers read it, a COLMAP model, transforms.json, Long-LRM's JSON, and viewers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.model import build_model, write_capture_model
from fsel.captures.layouts.nerfstudio import STRAIGHT, intrinsics_of, matrix_of
from fsel.core.geometry import invert_pose
from fsel.core.points import RawPoints, grouped_rows

CLOUD, TRANSFORMS = "sparse_pc.ply", "transforms.json"
VIEWERS = "cameras.json"  # of 3D Gaussian Splatting, which SuperSplat reads too
LONG_LRM, SCENES = "scene.json", "scenes.txt"
VIEWER_KEYS = {"width": "w", "height": "h", "fx": "fl_x", "fy": "fl_y"}
LONG_LRM_KEYS = {"w": "w", "h": "h", "fx": "fl_x", "fy": "fl_y", "cx": "cx", "cy": "cy"}


@dataclass(frozen=True)
class Subset:
    """Frames as they are written, by their names below images/; `masked` where masks/ has one each.

    Cameras are at the size of the images that are written; (width, height) as `stated` are what the
    pixels of the points are of, whose tracks number these frames.
    """

    names: list[str]
    cameras: list[Camera]
    stated: list[tuple[int, int]]
    world_to_camera: np.ndarray
    points: RawPoints
    masked: bool


def write_forms(subset: Subset, folder: Path, scene: str) -> None:
    """Write every form into a folder that holds images/; `scene` names it for Long-LRM."""
    write_trained(subset, folder)
    write_json(_placed(subset), folder / VIEWERS)
    if all(camera.model in STRAIGHT for camera in subset.cameras):
        write_json(_long_lrm(subset, scene), folder / LONG_LRM)
        (folder / SCENES).write_text(f"{LONG_LRM}\n", encoding="utf-8")


def write_trained(subset: Subset, folder: Path) -> None:
    """Write what most trainers read: a COLMAP model, its points, and transforms.json."""
    cloud = _write_model(subset, folder)
    listed = [f"images/{name}" for name in subset.names]
    every = dict.fromkeys(("train_filenames", "val_filenames", "test_filenames"), listed)
    write_json(transforms([(subset, "")], cloud) | every, folder / TRANSFORMS)


def write_json(content: dict | list, path: Path) -> None:
    """Write JSON as every file here has it."""
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")


def transforms(parts: Sequence[tuple[Subset, str]], cloud: bool) -> dict:
    """Content of transforms.json for subsets and their folders, with a slash behind, or nothing;
    the first one's cloud is named, if there is one."""
    frames, intrinsics = [], []
    for subset, folder in parts:
        for name, pose, camera in zip(
            subset.names, subset.world_to_camera, subset.cameras, strict=True
        ):
            matrix = matrix_of(pose, np.eye(4)[:3])
            frame = {"file_path": f"{folder}images/{name}", "transform_matrix": matrix}
            if subset.masked:
                frame["mask_path"] = f"{folder}masks/{name}.png"
            frames.append(frame)
            intrinsics.append(intrinsics_of(camera))
    shared = intrinsics[0]
    if any(values != shared for values in intrinsics):
        frames = [frame | values for frame, values in zip(frames, intrinsics, strict=True)]
        shared = {"camera_model": shared["camera_model"]}
    content = {**shared, "frames": frames}
    return content | ({"ply_file_path": f"{parts[0][1]}{CLOUD}"} if cloud else {})


def _placed(subset: Subset) -> list[dict]:
    """Content of cameras.json: places and turns, camera to world with OpenCV axes."""
    placed: list[dict] = []
    for name, pose, camera in zip(
        subset.names, invert_pose(subset.world_to_camera), subset.cameras, strict=True
    ):
        known = intrinsics_of(camera)
        lens = {key: known[own] for key, own in VIEWER_KEYS.items()}
        at = {"position": pose[:, 3].tolist(), "rotation": pose[:, :3].tolist()}
        placed.append({"id": len(placed), "img_name": name, **lens, **at})
    return placed


def _long_lrm(subset: Subset, scene: str) -> dict:
    """The scene JSON of Long-LRM (Ziwen et al. 2024), whose loader knows no distortion."""
    frames = []
    for name, pose, camera in zip(
        subset.names, subset.world_to_camera, subset.cameras, strict=True
    ):
        known = intrinsics_of(camera)
        lens = {key: known[own] for key, own in LONG_LRM_KEYS.items()}
        w2c = np.vstack([pose, [0, 0, 0, 1]]).tolist()
        frames.append({"file_path": f"images/{name}", **lens, "w2c": w2c})
    return {"scene_name": scene, "frames": frames}


def _write_model(subset: Subset, folder: Path) -> bool:
    """A COLMAP model of all of the frames and the points; returns whether there are points."""
    points, error = subset.points, subset.points.error
    rows = grouped_rows(points.track_frame, len(subset.names))
    sizes = [(camera.width, camera.height) for camera in subset.cameras]
    if error is not None:  # in pixels, as they are written
        error = np.where(error < 0, error, error * (sizes[0][0] / subset.stated[0][0]))
    model = build_model(
        subset.names,
        [camera.colmap for camera in subset.cameras],
        subset.world_to_camera,
        points.xyz,
        points.rgb,
        [points.track_point[row] for row in rows],
        [
            points.track_xy[row] * np.divide(size, stated)
            for row, size, stated in zip(rows, sizes, subset.stated, strict=True)
        ],
        error=error,
    )
    return write_capture_model(model, folder, folder / CLOUD)
