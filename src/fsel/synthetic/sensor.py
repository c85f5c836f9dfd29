"""The camera of a shot: its rays and pixels, samples over the exposure, vignette, gain, noise."""

from __future__ import annotations

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.core.geometry import lengths, pixel_centers
from fsel.synthetic.caster import Caster
from fsel.synthetic.trajectories import Shot

GAMMA = 0.5
VIGNETTE = 0.12  # darkening of the corners
SAMPLES = (3, 18)  # least and most rays a pixel
DENSITY = 1.1  # rays a pixel of motion: below one a moving edge leaves separate ghosts
GRID = 9  # pixels between those whose motion is measured
SKY = 1e4  # metres


def film(caster: Caster, shot: Shot, rays, depth, camera: Camera, rng) -> np.ndarray:
    """Return (N, h, w, 3) uint8 images of a shot, by (h * w, 3) rays and (N, h, w) depth."""
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
