"""Filming a scene: a path that keeps clear of it, then images, exact depth and tracks."""

from __future__ import annotations

import zlib

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import SUBJECT, Recording
from fsel.core.geometry import camera_centers, lengths, pixel_centers, pose_matrices
from fsel.synthetic.caster import Caster
from fsel.synthetic.families import FAMILY, Setting
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

GAMMA = 0.5
VIGNETTE = 0.12  # darkening of the corners
SAMPLES = (3, 18)  # least and most rays a pixel
DENSITY = 1.1  # rays a pixel of motion: below one a moving edge leaves separate ghosts
GRID = 9  # pixels between those whose motion is measured
SKY = 1e4  # metres


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


def film(caster: Caster, shot: Shot, rays, depth, camera: Camera, rng) -> np.ndarray:
    """Return (N, h, w, 3) uint8 images of a shot, by (h * w, 3) rays and (N, h, w) depth: samples
    over the exposure, vignette, gain, noise."""
    frames = len(shot.names)
    grid = rays.reshape(camera.height, camera.width, 3)
    down, across = (part.reshape(-1, 3) for part in np.gradient(grid, axis=(0, 1)))
    linear = np.zeros((frames, len(rays), 3), np.float32)
    begin, end = (shot.poses(np.full(frames, moment)) for moment in (-0.5, 0.5))
    moved = motion(begin, shot.poses(np.zeros(frames)), end, depth, camera, rays)
    counts = np.clip(np.ceil(DENSITY * moved), *SAMPLES).astype(int)
    for s in range(counts.max()):
        poses = shot.poses((s + 0.5) / counts - 0.5)
        for i in np.flatnonzero(counts > s):
            quarter = np.array([s % 2, (s + s // 2) % 2])  # two rays lie on the diagonal
            shift = rng.uniform(-0.25, 0.25, 2) + 0.5 * quarter - 0.25
            origins, world = to_world(poses[i], rays + shift[0] * across + shift[1] * down)
            linear[i] += caster.colors(origins, world)
    linear /= counts[:, None, None]
    images = np.empty((*depth.shape, 3), np.uint8)
    x, y = np.linspace(-1, 1, camera.width), np.linspace(-1, 1, camera.height)[:, None]
    vignette = (1 - VIGNETTE * (x**2 + y**2) / 2)[..., None].astype(np.float32)
    for image, light, gain in zip(images, linear.reshape(images.shape), shot.exposure, strict=True):
        value = np.clip(light * vignette * gain, 0, 1) ** GAMMA
        value = value + rng.normal(0, shot.habits.noise, value.shape).astype(np.float32)
        image[:] = np.clip(np.rint(value * 255), 0, 255).astype(np.uint8)
    return images


def motion(begin, middle, end, depth, camera: Camera, rays) -> np.ndarray:
    """Return (N,) pixels that the image moves in an exposure, 95th percentile over a frame, by (N,
    3, 4) poses and the middle one's (N, h, w) depth, 0 for sky."""
    moved = np.empty(len(depth))
    some = slice(GRID // 2, None, GRID)
    for i, z in enumerate(depth.reshape(len(depth), -1)[:, some]):
        local = rays[some] * np.where(z > 0, z, SKY)[:, None] - middle[i, :, 3]
        xyz = local @ middle[i, :, :3]
        first, last = (project(camera, xyz @ p[:, :3].T + p[:, 3]) for p in (begin[i], end[i]))
        moved[i] = np.percentile(np.linalg.norm(last - first, axis=1), 95)
    return moved


def exact_depth(caster: Caster, poses: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """(N, h * w) distance along the optical axis at pixel centres, mid-exposure; 0 for sky."""
    out = np.zeros((len(poses), len(rays)))
    for i, pose in enumerate(poses):
        origins, world = to_world(pose, rays)
        which, distance = caster.hit(origins, world)
        out[i] = np.where(which >= 0, distance * (world @ pose[2, :3]), 0)
    return out


def exact_objects(caster: Caster, poses: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Return (N, h * w) uint8 numbers of the objects at pixel centres, mid-exposure; 0 for none."""
    return np.array([caster.objects(*to_world(pose, rays)) for pose in poses])


def to_world(pose: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return origins and unit directions in the world of (n, 3) camera rays, float32."""
    directions = (rays @ pose[:, :3]).astype(np.float32)
    directions /= lengths(directions)[:, None]
    center = (-pose[:, :3].T @ pose[:, 3]).astype(np.float32)
    return np.tile(center, (len(rays), 1)), directions


def unproject(camera: Camera) -> np.ndarray:
    """Return (h * w, 3) camera rays with z = 1 through the pixel centres."""
    x, y = pixel_centers(camera.width, camera.height)
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    flat = np.asarray(camera.colmap.cam_from_img(pixels))
    return np.column_stack([flat, np.ones(len(flat))])


def project(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Return (n, 2) pixels of (n, 3) camera points; those behind the camera land far outside."""
    out = np.full((len(points), 2), -1e6)
    ahead = points[:, 2] > 1e-6
    out[ahead] = np.asarray(camera.colmap.img_from_cam(points[ahead]))
    return out
