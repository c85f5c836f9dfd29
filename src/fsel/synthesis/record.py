"""Filming a scene: the sensor, the exact depth, and the sparse points with their tracks."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from fsel.recording import Camera, Recording
from fsel.synthesis.caster import Caster
from fsel.synthesis.families import FAMILY, Shot
from fsel.synthesis.lens import project, unproject

GAMMA = 1 / 2.0
POINTS = 1500
TRACK_NOISE = 0.3  # pixels
MIN_TRACK = 3
DETECTION = 0.8  # chance that a visible point is found in a frame
ATTEMPTS = 40
SUBSAMPLES = (5, 24)  # least and most rays a pixel
SPHERE = 96


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
    if family not in FAMILY:
        raise ValueError(f"family is {family!r}; allowed: {', '.join(FAMILY)}")
    if frames < 12:
        raise ValueError(f"a capture needs at least 12 frames, got {frames}")
    rng = np.random.default_rng([zlib.crc32(family.encode()), seed])
    shot, caster = _clear_shot(family, rng, frames)
    camera = shot.camera(width, height)
    rays = unproject(camera)
    images = _film(caster, shot, rays, camera, rng)
    poses = shot.poses(np.zeros(frames))
    depth = _depth(caster, poses, rays)
    depth = depth.reshape(frames, height, width)
    xyz, rgb, tracks = _sparse_points(poses, depth, images, camera, rays, rng)
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
    )


def _clear_shot(family: str, rng: np.random.Generator, frames: int) -> tuple[Shot, Caster]:
    """A scene and a path whose every camera keeps clear of surfaces and sees some depth."""
    directions = Rotation.random(SPHERE, rng=np.random.default_rng(0)).as_matrix()[:, 0]
    setting = FAMILY[family]
    for _ in range(ATTEMPTS):
        caster = Caster(setting.scene(rng))
        for _ in range(3):
            shot = setting.shot(rng, frames)
            poses = shot.poses(np.zeros(frames))
            centers = -np.einsum("nij,ni->nj", poses[:, :, :3], poses[:, :, 3])
            if caster.clearance(centers, directions).min() < setting.clearance:
                continue
            if _ahead(caster, centers, poses[:, 2, :3]) >= setting.view:
                return shot, caster
    raise RuntimeError(f"no clear camera path found for a {family} scene in {ATTEMPTS} attempts")


def _ahead(caster: Caster, centers: np.ndarray, axes: np.ndarray) -> float:
    """Least distance straight ahead over all frames."""
    which, distance = caster.hit(centers.astype(np.float32), axes.astype(np.float32))
    return float(np.where(which < 0, np.inf, distance).min())


def _film(caster, shot: Shot, rays: np.ndarray, camera: Camera, rng) -> np.ndarray:
    """(N, h, w, 3) uint8: sub-samples in pixel and time, exposure, vignette, noise."""
    frames = len(shot.names)
    images = np.empty((frames, camera.height, camera.width, 3), np.uint8)
    x = np.linspace(-1, 1, camera.width)
    y = np.linspace(-1, 1, camera.height)[:, None]
    vignette = (1 - shot.vignette * (x**2 + y**2) / 2)[..., None].astype(np.float32)
    linear = np.zeros((frames, camera.height * camera.width, 3), np.float32)
    counts = _subsamples(shot, camera)
    for s in range(counts.max()):
        poses = shot.poses((s + 0.5) / counts - 0.5)
        for i in np.flatnonzero(counts > s):
            jitter = rng.uniform(-0.5, 0.5, 2) + 0.5 * np.array([(s % 2) - 0.5, (s // 2 % 2) - 0.5])
            origins, world = _to_world(poses[i], shot.jittered(rays, camera, jitter))
            linear[i] += caster.colors(origins, world)
    for i in range(frames):
        light = linear[i].reshape(images.shape[1:]) / counts[i] * vignette * shot.exposure[i]
        value = np.clip(light, 0, 1) ** GAMMA
        value = value + rng.normal(0, shot.noise, value.shape).astype(np.float32)
        images[i] = np.clip(np.rint(value * 255), 0, 255).astype(np.uint8)
    return images


def _subsamples(shot: Shot, camera: Camera) -> np.ndarray:
    """(N,) rays a pixel: more where the shake would else leave separate ghosts."""
    pixels = np.linalg.norm(shot.shake, axis=1) * camera.params[0]
    return np.clip(np.ceil(2 * pixels), *SUBSAMPLES).astype(int)


def _to_world(pose: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions in the world of (n, 3) camera rays, float32."""
    directions = (rays @ pose[:, :3]).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    center = (-pose[:, :3].T @ pose[:, 3]).astype(np.float32)
    return np.tile(center, (len(rays), 1)), directions


def _depth(caster: Caster, poses: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """(N, h * w) distance along the optical axis at pixel centres, mid-exposure; 0 for sky."""
    out = np.zeros((len(poses), len(rays)))
    for i, pose in enumerate(poses):
        origins, world = _to_world(pose, rays)
        which, distance = caster.hit(origins, world)
        out[i] = np.where(which >= 0, distance * (world @ pose[2, :3]), 0)
    return out


def _sparse_points(poses, depth, images, camera: Camera, rays, rng):
    """Points on textured surfaces with the frames and pixels that see them."""
    frames, height, width = depth.shape
    owner = rng.integers(frames, size=6 * POINTS)
    grey = images.astype(np.float32).mean(axis=-1)
    texture = np.stack([np.abs(cv2.Laplacian(g, cv2.CV_32F)) for g in grey])
    row, column = rng.integers(height, size=len(owner)), rng.integers(width, size=len(owner))
    z = depth[owner, row, column]
    keep = np.flatnonzero((z > 0) & (texture[owner, row, column] > 8))[:POINTS]
    owner, row, column, z = owner[keep], row[keep], column[keep], z[keep]
    ray = rays[row * width + column]
    local = ray / ray[:, 2:] * z[:, None] - poses[owner, :, 3]
    xyz = np.einsum("nji,nj->ni", poses[owner, :, :3], local)
    point, frame, xy = _observations(xyz, poses, depth, camera, rng)
    count = np.bincount(point, minlength=len(xyz))
    good = count >= MIN_TRACK
    renumber = np.cumsum(good) - 1
    used = good[point]
    rgb = images[owner, row, column]
    return xyz[good], rgb[good], (renumber[point[used]], frame[used], xy[used])


def _observations(xyz, poses, depth, camera: Camera, rng):
    """Every detected, unoccluded projection of the points."""
    found = []
    for i, pose in enumerate(poses):
        local = xyz @ pose[:, :3].T + pose[:, 3]
        xy = project(camera, local)
        inside = (local[:, 2] > 0) & (xy >= 0).all(axis=1)
        inside &= (xy < [camera.width, camera.height]).all(axis=1)
        inside &= rng.random(len(xyz)) < DETECTION
        rows = np.flatnonzero(inside)
        column, row = xy[rows].astype(int).T
        seen = depth[i, row, column]
        rows = rows[(np.abs(seen - local[rows, 2]) < 0.02 * local[rows, 2]) & (seen > 0)]
        noisy = xy[rows] + rng.normal(0, TRACK_NOISE, (len(rows), 2))
        found.append((rows, np.full(len(rows), i), noisy))
    point, frame, xy = (np.concatenate(part) for part in zip(*found, strict=True))
    return point, frame, xy


def _world(shot: Shot, rng: np.random.Generator) -> _World:
    """Metric and upright, or the arbitrary frame of a structure-from-motion model."""
    if shot.metric:
        return _World(np.eye(3), rng.normal(0, 2, 3), 1.0)
    return _World(Rotation.random(rng=rng).as_matrix(), rng.normal(0, 3, 3), rng.uniform(0.3, 3))


def _moved(poses: np.ndarray, world: _World) -> np.ndarray:
    rotation = poses[:, :, :3] @ world.rotation.T
    translation = world.scale * poses[:, :, 3] - rotation @ world.translation
    return np.concatenate([rotation, translation[:, :, None]], axis=2)
