"""True views off the path of an embedded capture, cast as exactly as its scene allows."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fsel.core.capture import Capture, Views
from fsel.core.geometry import camera_centers, moved_aside, pixel_rays
from fsel.experiments.studies.true_depth import recording_of
from fsel.synthetic.caster import Caster
from fsel.synthetic.sensor import GAMMA, to_world

ASIDE = 0.12  # of the cameras' reach: standard deviation of a view's shift along each axis
TURN = 7.0  # degrees: of its turn about each axis
CLEAR = 0.4  # metres that a view keeps from what is straight ahead
SAMPLES = (-0.25, 0.25)  # of a pixel, in both directions
ATTEMPTS = 2000


def views_beside(capture: Capture, count: int, **generated: Any) -> tuple[Views, np.ndarray]:
    """Views shifted and turned from frames of an embedded capture, and what they truly show.

    No view lies behind a surface as seen from its frame. Exposure is the scene's own, and there is
    no noise: the frames' drift of exposure costs every selection alike.

    Args:
        capture, generated: see `true_depth.recording_of`; at the size that is compared.
        count: how many views.

    Returns:
        The views, in the capture's world, and their (count, h, w, 3) uint8 images.

    Raises:
        RuntimeError: when the scene leaves no room beside the path.
    """
    caster, metric, unit = recording_of(capture, **generated)
    centers = camera_centers(metric)
    reach = np.linalg.norm(centers - centers.mean(axis=0), axis=1).max()
    rng = np.random.default_rng(generated["seed"])
    poses, shown = [], []
    for _ in range(ATTEMPTS):
        frame = int(rng.integers(len(capture)))
        aside = rng.normal(0, ASIDE * reach, 3)
        turn = Rotation.from_rotvec(np.radians(rng.normal(0, TURN, 3))).as_matrix()
        pose = moved_aside(metric[frame], turn, aside)
        if not _free(caster, centers[frame], pose):
            continue
        poses.append(moved_aside(capture.world_to_camera[frame], turn, unit * aside))
        shown.append(_image(caster, pose, capture.intrinsics[frame], capture.size))
        if len(poses) == count:
            intrinsics = np.tile(capture.intrinsics[0], (count, 1))
            return Views(np.array(poses), intrinsics, capture.size), np.array(shown)
    raise RuntimeError(f"{capture.source}: no room for {count} views beside its path")


def _free(caster: Caster, start: np.ndarray, pose: np.ndarray) -> bool:
    """Say whether nothing lies between a place and a view, nor right before the view."""
    center = -pose[:, :3].T @ pose[:, 3]
    way = start - center
    length = np.linalg.norm(way)
    rays = np.stack([way / max(length, 1e-9), pose[2, :3]]).astype(np.float32)
    which, distance = caster.hit(np.tile(center, (2, 1)).astype(np.float32), rays)
    open_way = which[0] < 0 or distance[0] > length
    return bool(open_way and (which[1] < 0 or distance[1] > CLEAR))


def _image(
    caster: Caster, pose: np.ndarray, intrinsics: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """(h, w, 3) uint8 by four rays a pixel."""
    width, height = size
    rays = pixel_rays(intrinsics, width, height).reshape(-1, 3)
    linear = np.zeros((len(rays), 3))
    for down in SAMPLES:
        for across in SAMPLES:
            shift = np.array([across / intrinsics[0], down / intrinsics[1], 0])
            linear += caster.colors(*to_world(pose, rays + shift))
    bright = (linear / len(SAMPLES) ** 2) ** GAMMA
    return np.round(np.clip(bright, 0, 1) * 255).astype(np.uint8).reshape(height, width, 3)
