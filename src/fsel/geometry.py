"""Angles, distances and reference points of cameras; nothing that knows about files.

Everything is float64. Angles are radians in [0, pi], taken as 2 atan2(|a - b|, |a + b|) of unit
vectors, which keeps full precision near 0 and pi where the arccos of a dot product loses half.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

COINCIDENT = 1e-12  # share of the longest vector under which a vector has no direction


def pairwise_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(N, M) Euclidean distances between (N, 3) and (M, 3) points, in their unit."""
    return cdist(np.asarray(a, np.float64), np.asarray(b, np.float64))


def viewing_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(N, M) angles in radians between (N, 3) and (M, 3) unit vectors."""
    return 2 * np.arctan2(pairwise_distances(a, b), pairwise_distances(a, -np.asarray(b)))


def pose_distance(
    centers_a: np.ndarray, axes_a: np.ndarray, centers_b: np.ndarray, axes_b: np.ndarray
) -> np.ndarray:
    """Distance of camera poses: centre distance and viewing angle, each over its maximum.

    The maxima are over all pairs given, so that both parts weigh the same (paper, section 3.1).
    A maximum of zero counts as one.

    Args:
        centers_a: (A, 3) camera centres, world units.
        axes_a: (A, 3) unit optical axes.
        centers_b: (B, 3).
        axes_b: (B, 3).

    Returns:
        (A, B) float64 in [0, 2].
    """
    distance = pairwise_distances(centers_a, centers_b)
    angle = viewing_angles(axes_a, axes_b)
    return distance / _positive_max(distance) + angle / _positive_max(angle)


def _positive_max(values: np.ndarray) -> float:
    return values.max(initial=0.0) or 1.0


def reference_points(centers: np.ndarray, axes: np.ndarray, centroid: np.ndarray) -> np.ndarray:
    """The point of each forward ray that passes closest to a centroid (paper, Appendix A.1).

    Args:
        centers: (O, 3) camera centres, world units.
        axes: (O, 3) unit optical axes.
        centroid: (3,) centroid of the candidates' camera centres.

    Returns:
        (O, 3) points; a camera that looks away from the centroid keeps its own centre.
    """
    along = np.einsum("oi,oi->o", centroid - centers, axes)
    return centers + np.maximum(along, 0)[:, None] * axes


def directions(vectors: np.ndarray, scale: float) -> np.ndarray:
    """Unit vectors; one no longer than 1e-12 of `scale` has no direction and becomes zero.

    Args:
        vectors: (..., 3) float64.
        scale: length that the scene is made of, in the vectors' unit.
    """
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > COINCIDENT * scale)


def paired_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(...) angles in radians between matching (..., 3) unit vectors; 0 where either is zero."""
    angle = 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return np.where(a.any(axis=-1) & b.any(axis=-1), angle, 0.0)
