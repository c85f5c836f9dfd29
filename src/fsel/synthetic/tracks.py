"""Sparse points of a recording and the tracks that a structure-from-motion run would leave."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.synthetic.lens import project

POINTS = 1500
NOISE = 0.3  # pixels
WORST = 0.9  # pixels beyond which an observation would have been filtered
MIN_TRACK = 3
DETECTION = 0.8  # chance that a visible point is found in a frame
TEXTURE = 8  # least absolute Laplacian, grey levels, where a point is detected
SURFACE = 0.02  # relative depth within which a projection lies on the visible surface


def sparse_points(poses, depth, images, camera: Camera, rays, rng):
    """Points on textured surfaces with the frames and pixels that see them.

    Args:
        poses: (N, 3, 4) world-to-camera.
        depth: (N, h, w) along the optical axis, 0 for none.
        images: (N, h, w, 3) uint8.
        camera: of all frames.
        rays: (h * w, 3) camera rays with z = 1.
        rng: the only source of chance.

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
