"""Angles, distances and reference points; float64, nothing that knows about files."""

from __future__ import annotations

import numpy as np

ROUNDING = 2.0**-46  # of the largest coordinate: what turning and shifting poses may leave behind
SAME_AXIS = 4 * ROUNDING  # unit vectors closer than this are one


def merged(points: np.ndarray) -> np.ndarray:
    """(n, 3) the same points, coordinates that only rounding tells apart made equal.

    Cameras in one place then are in one place: a column of their distances would else be noise,
    and standardising it would make the noise decide.
    """
    out = points.copy()
    limit = ROUNDING * np.abs(points).max(initial=0.0)
    for column in out.T:
        order = np.argsort(column, kind="stable")
        ordered = column[order]
        first = np.diff(ordered, prepend=-np.inf) > limit
        column[order] = ordered[first][np.cumsum(first) - 1]
    return out


def centered(points: np.ndarray) -> np.ndarray:
    """(n, d) points less their mean: exactly zero where all are equal, as (x + ... + x) / n is not
    always x."""
    offset = points - points[0]
    return offset - offset.mean(axis=0)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """(...) Euclidean norms of (..., 3) vectors; three times as fast as `np.linalg.norm`."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


def viewing_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between unit vectors, exact to rounding even where they are nearly (anti)parallel.

    Args:
        a: (..., 3) unit vectors.
        b: (..., 3) unit vectors, broadcast against `a`.

    Returns:
        (...) radians in [0, pi]: 2 atan2(|a - b|, |a + b|) (Kahan); 0 for vectors that only
        rounding tells apart.
    """
    chord = lengths(a - b)
    return 2 * np.arctan2(np.where(chord > SAME_AXIS, chord, 0.0), lengths(a + b))


def pairwise_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(A, B) radians between every two of (A, 3) and (B, 3) unit vectors."""
    return viewing_angles(a[:, None], b[None])


def pairwise_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(A, B) Euclidean distances between (A, 3) and (B, 3) points, by differences.

    The expanded square would lose everything for coordinates far from the origin.
    """
    return lengths(a[:, None] - b[None])


def pose_distance(
    centers_a: np.ndarray, axes_a: np.ndarray, centers_b: np.ndarray, axes_b: np.ndarray
) -> np.ndarray:
    """The split's distance: centre distance and viewing angle, each over its maximum.

    Args:
        centers_a, axes_a: (A, 3) camera centres and unit optical axes.
        centers_b, axes_b: (B, 3).

    Returns:
        (A, B) in [0, 2]; a maximum of zero counts as one (paper, section 3.1).
    """
    total = np.zeros((len(centers_a), len(centers_b)))
    for part in (pairwise_distances(centers_a, centers_b), pairwise_angles(axes_a, axes_b)):
        top = part.max()
        total += part / (top if top > 0 else 1.0)
    return total


def directions(points: np.ndarray, origins: np.ndarray) -> np.ndarray:
    """Unit vectors from origins to points, broadcast; zero where they coincide to rounding."""
    offset = points - origins
    length = lengths(offset)[..., None]
    least = ROUNDING * max(np.abs(points).max(initial=0.0), np.abs(origins).max(initial=0.0))
    return np.divide(offset, length, out=np.zeros_like(offset), where=length > least)


def reference_points(centers: np.ndarray, axes: np.ndarray, centroid: np.ndarray) -> np.ndarray:
    """Closest point of each forward ray (t >= 0) to the centroid of the candidates' centres.

    Args:
        centers, axes: (O, 3) of the reference views.
        centroid: (3,).

    Returns:
        (O, 3) (paper, Appendix A.1).
    """
    along = np.einsum("oi,oi->o", centroid - centers, axes)
    least = ROUNDING * np.abs(centers).max(initial=0.0)
    return centers + np.where(along > least, along, 0.0)[:, None] * axes


def farthest_views(region: np.ndarray, centers: np.ndarray, k: int, start: int) -> np.ndarray:
    """Farthest-point sampling of camera centres from a start; at most len(region) frames."""
    chosen = [start]
    gap = np.linalg.norm(centers[region] - centers[start], axis=1)
    taken = region == start
    while len(chosen) < min(k, len(region)):
        best = int(np.argmax(np.where(taken, -1.0, gap)))
        taken[best] = True
        chosen.append(int(region[best]))
        gap = np.minimum(gap, np.linalg.norm(centers[region] - centers[region[best]], axis=1))
    return np.array(chosen)
