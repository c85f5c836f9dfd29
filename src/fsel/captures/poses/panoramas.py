"""Panoramas of all directions: placed as they are, and then cut into perspective views."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera, pycolmap
from fsel.captures.colmap.model import build_model, observed, points_of
from fsel.captures.colmap.runs import SPHERE
from fsel.captures.images import files as image_files
from fsel.captures.images.previews import Progress
from fsel.core.points import grouped_rows

_QUARTER = np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])  # a quarter turn to the right
VIEWS = {
    "front": np.eye(3),
    "right": _QUARTER,
    "back": _QUARTER @ _QUARTER,
    "left": _QUARTER.T,
    "up": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
}
"""Folder of a view -> (3, 3) panorama to view, 90 degrees wide; below is who holds the camera."""


def cut(
    model: pycolmap.Reconstruction, source: Path, target: Path, progress: Progress
) -> pycolmap.Reconstruction:
    """Write the views of placed panoramas, and return the model of the views.

    Args:
        model: its images are named as files in `source`, and its cameras see all directions.
        target: receives `front/NAME`, `right/NAME`, ... of each.
    """
    images = sorted(model.images.values(), key=lambda image: image.name)
    points = points_of(observed(model), {image.image_id: i for i, image in enumerate(images)}, "")
    if points is None:
        raise ValueError(f"{source}: the placed panoramas have no points in common")
    rows = grouped_rows(points.track_frame, len(images))
    names, cameras, poses, seen, pixels = [], [], [], [], []
    for image, row in progress(list(zip(images, rows, strict=True)), len(images)):
        sphere, pose = model.cameras[image.camera_id], image.cam_from_world().matrix()
        side = sphere.width // 4
        rays = np.asarray(sphere.cam_ray_from_img(points.track_xy[row])).reshape(-1, 3)
        whole = image_files.load(source / image.name)
        for view, turn in VIEWS.items():
            names.append(f"{view}/{image.name}")
            cameras.append(Camera("PINHOLE", side, side, (side / 2,) * 4).colmap)
            poses.append(turn @ pose)
            x, y, z = turn @ rays.T
            ahead = np.flatnonzero(z > np.maximum(abs(x), abs(y)))
            seen.append(points.track_point[row][ahead])
            pixels.append(side / 2 * (1 + np.stack([x, y], axis=1)[ahead] / z[ahead, None]))
            maps = _maps(view, sphere.width, sphere.height)
            shown = cv2.remap(whole, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
            image_files.write(shown[None], target, names[-1:])
    known = points.xyz, points.rgb, seen, pixels
    return build_model(names, cameras, np.array(poses), *known, error=points.error, least=2)


@lru_cache(len(VIEWS))
def _maps(view: str, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Tables for `cv2.remap` of a view of a panorama of some pixels."""
    side = width // 4
    across = (np.arange(side) + 0.5) * 2 / side - 1
    x, y = np.meshgrid(across, across)
    rays = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3) @ VIEWS[view]
    places = Camera(SPHERE, width, height, (width, height)).colmap.img_from_cam(rays)
    u, v = np.asarray(places, np.float32).T.reshape(2, side, side) - np.float32(0.5)
    return u, v
