"""Filming a scene: a path that keeps clear of it, then images, exact depth and tracks."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from fsel.captures.layouts.contract import SUBJECT, Recording
from fsel.core.geometry import camera_centers, pose_matrices
from fsel.synthetic.caster import Caster
from fsel.synthetic.families import FAMILY, Setting
from fsel.synthetic.lens import unproject
from fsel.synthetic.sensor import exact_depth, exact_objects, film
from fsel.synthetic.shot import Shot
from fsel.synthetic.tracks import sparse_points

ATTEMPTS = 40
PATHS = 3  # tried in each scene
COARSE = (32, 24)  # pixels of the images in which the subject is looked for
FILLED = 0.04  # of them, in a frame that sees the subject
SPHERE = 400  # directions in which a camera's clearance is measured, 10 degrees apart


@dataclass(frozen=True)
class _World:
    """Similarity from the scene's metres to the capture's own frame."""

    rotation: np.ndarray
    translation: np.ndarray
    scale: float


def record(
    family: str, seed: int, frames: int = 160, width: int = 128, height: int = 96
) -> Recording:
    """Film a generated scene in the manner of a dataset.

    Args:
        family: one of `FAMILIES`.
        seed: scenes differ by it; equal seeds give equal bytes.
        frames: length of the capture, at least 12.
        width: pixels.
        height: pixels.

    Raises:
        ValueError: for an unknown family or too few frames.
        RuntimeError: when no path keeps clear of the scene's objects.
    """
    shot, caster, rng = clear_shot(family, seed, frames)
    camera = shot.camera(width, height)
    rays = unproject(camera)
    poses = shot.poses(np.zeros(frames))
    depth = exact_depth(caster, poses, rays).reshape(frames, height, width)
    objects = None
    if caster.scene.objects:
        objects = exact_objects(caster, poses, rays).reshape(depth.shape)
    images = film(caster, shot, rays, depth, camera, rng)
    xyz, rgb, tracks = sparse_points(poses, depth, images, camera, rays, rng)
    world = _world(shot, rng)
    return Recording(
        names=shot.names,
        world_to_camera=_moved(poses, world),
        camera=camera,
        images=images,
        depth=(depth * world.scale).astype(np.float32),
        xyz=world.scale * xyz @ world.rotation.T + world.translation,
        rgb=rgb,
        track_point=tracks[0],
        track_frame=tracks[1],
        track_xy=tracks[2],
        sequences=shot.sequences,
        bad=shot.bad,
        lost=shot.lost,
        objects=objects,
    )


def clear_shot(family: str, seed: int, frames: int) -> tuple[Shot, Caster, np.random.Generator]:
    """A scene, a path whose every camera keeps clear of it and sees some depth, and the chance.

    Raises: as `record`.
    """
    if family not in FAMILY:
        raise ValueError(f"family is {family!r}; allowed: {', '.join(FAMILY)}")
    if frames < 12:
        raise ValueError(f"a capture needs at least 12 frames, got {frames}")
    rng = np.random.default_rng([zlib.crc32(family.encode()), seed])
    setting = FAMILY[family]
    for _ in range(ATTEMPTS):
        caster = Caster(setting.scene(rng))
        for _ in range(PATHS):
            shot = setting.shot(rng, frames)
            if _clear(caster, shot, setting):
                return shot, caster, rng
    raise RuntimeError(f"no clear camera path found for a {family} scene in {ATTEMPTS} attempts")


def _clear(caster: Caster, shot: Shot, setting: Setting) -> bool:
    """Check that every camera keeps clear of the scene, sees some depth and, often, the subject."""
    poses = shot.poses(np.zeros(len(shot.names)))
    centers = camera_centers(poses)
    return bool(
        caster.clearance(centers, _around()).min() >= setting.clearance
        and _ahead(caster, centers, poses[:, 2, :3]) >= setting.view
        and _seeing(caster, shot, poses) >= setting.seeing
    )


@cache
def _around() -> np.ndarray:
    """(SPHERE, 3) unit directions."""
    return Rotation.random(SPHERE, rng=np.random.default_rng(0)).as_matrix()[:, 0]


def _ahead(caster: Caster, centers: np.ndarray, axes: np.ndarray) -> float:
    """Least distance straight ahead over all frames."""
    which, distance = caster.hit(centers.astype(np.float32), axes.astype(np.float32))
    return float(np.where(which < 0, np.inf, distance).min())


def _seeing(caster: Caster, shot: Shot, poses: np.ndarray) -> float:
    """Share of the frames in which the scene's subject fills `FILLED` of the image."""
    if SUBJECT not in caster.scene.objects:
        return 1.0
    shown = exact_objects(caster, poses, unproject(shot.camera(*COARSE))) == SUBJECT
    return float((shown.mean(axis=1) >= FILLED).mean())


def _world(shot: Shot, rng: np.random.Generator) -> _World:
    """Metric and upright, or the arbitrary frame of a structure-from-motion model."""
    if shot.habits.metric:
        return _World(np.eye(3), rng.normal(0, 2, 3), 1.0)
    return _World(Rotation.random(rng=rng).as_matrix(), rng.normal(0, 3, 3), rng.uniform(0.3, 3))


def _moved(poses: np.ndarray, world: _World) -> np.ndarray:
    rotation = poses[:, :, :3] @ world.rotation.T
    translation = world.scale * poses[:, :, 3] - rotation @ world.translation
    return pose_matrices(rotation, translation)
