"""Errors of camera poses: put in at random, and measured between two sets."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from fsel.core.geometry import camera_centers


def scene_size(world_to_camera: np.ndarray) -> float:
    """Largest distance of a camera centre from the mean of all, world units.

    Args:
        world_to_camera: (N, 3, 4).
    """
    centers = camera_centers(world_to_camera)
    return float(np.linalg.norm(centers - centers.mean(axis=0), axis=1).max())


def perturbed(
    world_to_camera: np.ndarray, degrees: float, percent: float, rng: np.random.Generator
) -> np.ndarray:
    """Rigid poses with Gaussian noise.

    Every camera turns about its own centre, by a normal angle about an axis drawn evenly from the
    sphere, and its centre moves by an isotropic normal offset. Both are drawn in the camera's own
    axes and in units of the scene, so that the world's frame and unit have no effect. Equal `rng`
    give equal axes and directions at every level, which makes levels comparable.

    Args:
        world_to_camera: (N, 3, 4).
        degrees: root mean square of the angles.
        percent: root mean square length of the offsets, per cent of `scene_size`.
        rng: the only source of chance.

    Returns:
        (N, 3, 4); the same numbers where both levels are 0.
    """
    count = len(world_to_camera)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    angles = np.radians(degrees) * rng.normal(size=(count, 1))
    length = percent / 100 * scene_size(world_to_camera) / np.sqrt(3)
    moved = world_to_camera.copy()
    moved[:, :, 3] -= length * rng.normal(size=(count, 3))
    return Rotation.from_rotvec(angles * axes).as_matrix() @ moved


def pose_errors(estimated: np.ndarray, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Measure how far poses are from given ones, their camera centres laid onto each other.

    Args:
        estimated, given: (N, 3, 4) world-to-camera of the same frames, N >= 3, in worlds that
            differ by a similarity; the best one of the centres is taken out (Umeyama 1991).

    Returns:
        (N,) degrees between rotations, and (N,) distances of centres in per cent of the given
        poses' `scene_size`.

    Raises:
        ValueError: when no similarity is fixed by the centres.
    """
    from fsel.captures.colmap.bindings import (
        pycolmap,  # here: selecting from noisy poses does not need it
    )

    centers, wanted = camera_centers(estimated), camera_centers(given)
    fit = pycolmap.estimate_sim3d(centers, wanted)
    if fit is None:
        raise ValueError(f"{len(estimated)} camera centres on a line or point fix no similarity")
    turned = estimated[:, :, :3] @ fit.rotation.matrix().T
    off = Rotation.from_matrix(turned @ given[:, :, :3].transpose(0, 2, 1)).magnitude()
    laid = fit.scale * centers @ fit.rotation.matrix().T + fit.translation
    distance = np.linalg.norm(laid - wanted, axis=1)
    return np.degrees(off), 100 * distance / scene_size(given)
