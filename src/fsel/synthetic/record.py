"""Filming a scene: a path that keeps clear of it, then images, exact depth and tracks."""

from __future__ import annotations

import zlib

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
# (400, 3) unit directions in which a camera's clearance is measured, 10 degrees apart
AROUND = Rotation.random(400, rng=np.random.default_rng(0)).as_matrix()[:, 0]
POINTS = 1500  # that a structure-from-motion run would leave, at most
NOISE = 0.3  # pixels
WORST = 0.9  # pixels beyond which an observation would have been filtered
MIN_TRACK = 3
DETECTION = 0.8  # chance that a visible point is found in a frame
TEXTURE = 8  # least absolute Laplacian, grey levels, where a point is detected
SURFACE = 0.02  # relative depth within which a projection lies on the visible surface


def record(
    family: str, seed: int, frames: int = 160, width: int = 128, height: int = 96
) -> Recording:
    """Film a generated scene in the manner of a dataset.

    Args:
        family: one of `FAMILIES`.
        seed: scenes differ by it; equal seeds give equal bytes.
        frames: length of the capture, at least 12; width, height: pixels.

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
    xyz, rgb, (point, frame, xy) = sparse_points(poses, depth, images, camera, rays, rng)
    turn, move, scale = _world(FAMILY[family].metric, rng)
    rotation = poses[:, :, :3] @ turn.T
    return Recording(
        names=shot.names,
        world_to_camera=pose_matrices(rotation, scale * poses[:, :, 3] - rotation @ move),
        camera=camera,
        images=images,
        depth=(depth * scale).astype(np.float32),
        xyz=scale * xyz @ turn.T + move,
        rgb=rgb,
        track_point=point,
        track_frame=frame,
        track_xy=xy,
        sequences=shot.sequences,
        bad=shot.bad,
        lost=shot.lost,
        objects=objects,
    )


def _world(metric: bool, rng) -> tuple[np.ndarray, np.ndarray, float]:
    """Rotation, translation and scale from the scene to the capture's upright or random world."""
    if metric:
        return np.eye(3), rng.normal(0, 2, 3), 1.0
    return Rotation.random(rng=rng).as_matrix(), rng.normal(0, 3, 3), rng.uniform(0.3, 3)


def clear_shot(family: str, seed: int, frames: int) -> tuple[Shot, Caster, np.random.Generator]:
    """Return a filming whose every camera keeps clear of the scene, its caster, and the chance."""
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
    if caster.clearance(centers, AROUND).min() < setting.clearance:
        return False
    which, ahead = caster.hit(centers.astype(np.float32), poses[:, 2, :3].astype(np.float32))
    if np.where(which < 0, np.inf, ahead).min() < setting.view:
        return False
    if SUBJECT not in caster.scene.objects:
        return True
    shown = exact_objects(caster, poses, unproject(shot.camera(*COARSE))) == SUBJECT
    return bool((shown.mean(axis=1) >= FILLED).mean() >= setting.seeing)


def sparse_points(poses, depth, images, camera: Camera, rays, rng):
    """Find (M, 3) points on textured surfaces, colours, and tracks: points, frames, pixels."""
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
    """Rows, frames and pixels of every detected, unoccluded projection of the points."""
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
    return [np.concatenate(part) for part in zip(*seen, strict=True)]
