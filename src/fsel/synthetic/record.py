"""Filming a scene: a path that keeps clear of it, then images, exact depth and tracks."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import SUBJECT, Recording
from fsel.core.geometry import camera_centers, pose_matrices
from fsel.synthetic.caster import Caster
from fsel.synthetic.families import FAMILY, Setting
from fsel.synthetic.sensor import exact_depth, exact_objects, film, project, unproject
from fsel.synthetic.trajectories import Shot

ATTEMPTS = 40
PATHS = 3  # tried in each scene
COARSE = (32, 24)  # pixels of the images in which the subject is looked for
FILLED = 0.04  # of them, in a frame that sees the subject
SPHERE = 400  # directions in which a camera's clearance is measured, 10 degrees apart
POINTS = 1500  # that a structure-from-motion run would leave, at most
NOISE = 0.3  # pixels
WORST = 0.9  # pixels beyond which an observation would have been filtered
MIN_TRACK = 3
DETECTION = 0.8  # chance that a visible point is found in a frame
TEXTURE = 8  # least absolute Laplacian, grey levels, where a point is detected
SURFACE = 0.02  # relative depth within which a projection lies on the visible surface


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


def sparse_points(poses, depth, images, camera: Camera, rays, rng):
    """Find points on textured surfaces, with the frames and pixels that see them.

    Returns:
        (M, 3) points, (M, 3) uint8 colours, and the tracks: (L,) point numbers, (L,) frames,
        (L, 2) pixels.
    """
    frames, height, width = depth.shape
    owner = rng.integers(frames, size=6 * POINTS)
    grey = images.astype(np.float32).mean(axis=-1)
    texture = np.stack([np.abs(cv2.Laplacian(g, cv2.CV_32F)) for g in grey])
    row, column = rng.integers(height, size=len(owner)), rng.integers(width, size=len(owner))
    z = depth[owner, row, column]
    keep = np.flatnonzero((z > 0) & (texture[owner, row, column] > TEXTURE))[:POINTS]
    owner, row, column, z = owner[keep], row[keep], column[keep], z[keep]
    local = rays[row * width + column] * z[:, None] - poses[owner, :, 3]
    xyz = np.einsum("nji,nj->ni", poses[owner, :, :3], local)
    point, frame, xy = _observations(xyz, poses, depth, camera, rng)
    good = np.bincount(point, minlength=len(xyz)) >= MIN_TRACK
    renumber = np.cumsum(good) - 1
    used = good[point]
    rgb = images[owner, row, column]
    return xyz[good], rgb[good], (renumber[point[used]], frame[used], xy[used])


def _observations(xyz, poses, depth, camera: Camera, rng):
    """Every detected, unoccluded projection of the points."""
    seen = []
    for i, pose in enumerate(poses):
        local = xyz @ pose[:, :3].T + pose[:, 3]
        xy = project(camera, local)
        inside = (local[:, 2] > 0) & (xy >= 0).all(axis=1)
        inside &= (xy < [camera.width, camera.height]).all(axis=1)
        inside &= rng.random(len(xyz)) < DETECTION
        rows = np.flatnonzero(inside)
        column, row = xy[rows].astype(int).T
        z = local[rows, 2]
        rows = rows[np.abs(depth[i, row, column] - z) < SURFACE * z]
        noise = rng.normal(0, NOISE, (len(rows), 2))
        noise /= np.maximum(np.linalg.norm(noise, axis=1, keepdims=True) / WORST, 1)
        seen.append((rows, np.full(len(rows), i), xy[rows] + noise))
    point, frame, xy = (np.concatenate(part) for part in zip(*seen, strict=True))
    return point, frame, xy
