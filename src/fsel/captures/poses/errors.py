"""Errors of estimated poses against given ones."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from fsel.captures.colmap.bindings import pycolmap
from fsel.core.geometry import camera_centers


def pose_errors(estimated: np.ndarray, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Measure how far poses are from given ones, after the best similarity of their centres.

    Args:
        estimated, given: (N, 3, 4) world-to-camera of the same frames, N >= 3; the similarity
            between both worlds is taken out (Umeyama 1991).

    Returns:
        (N,) degrees between rotations, and (N,) distances of centres in per cent of the largest
        distance of a given centre from their mean.

    Raises:
        ValueError: when the centres fix no similarity.
    """
    centers, wanted = camera_centers(estimated), camera_centers(given)
    fit = pycolmap.estimate_sim3d(centers, wanted)
    if fit is None:
        raise ValueError(f"{len(estimated)} camera centres on a line or point fix no similarity")
    turned = estimated[:, :, :3] @ fit.rotation.matrix().T
    degrees = np.degrees(Rotation.from_matrix(turned @ given[:, :, :3].mT).magnitude())
    laid = fit.scale * centers @ fit.rotation.matrix().T + fit.translation
    size = np.linalg.norm(wanted - wanted.mean(axis=0), axis=1).max()
    return degrees, 100 * np.linalg.norm(laid - wanted, axis=1) / size
