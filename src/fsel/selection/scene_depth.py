"""Depth of a scene by its sparse points, and distances between frames in it."""

from __future__ import annotations

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import lengths, pairwise_angles, pairwise_distances
from fsel.core.points import SparsePoints, grouped_rows
from fsel.selection.paths import attention


def viewing_distance(views: Views, points: SparsePoints | None) -> np.ndarray:
    """(T,) how far what each of T frames looks at is, world units.

    The median depth of the sparse points that it sees; of all frames' points where it sees none;
    without points, the distance of the point that the cameras look at, or their spread where
    there is no such point.
    """
    if points is not None and len(points.track_frame):
        pose = views.world_to_camera[points.track_frame]
        seen = points.xyz[points.track_point]
        depth = np.einsum("li,li->l", pose[:, 2, :3], seen) + pose[:, 2, 3]
        rows, whole = grouped_rows(points.track_frame, len(views)), np.median(depth)
        return np.array([np.median(depth[row]) if len(row) else whole for row in rows])
    centers = views.centers
    try:
        return lengths(attention(centers, views.axes) - centers)
    except ValueError:
        return np.full(len(views), lengths(centers - centers.mean(axis=0)).max())


def image_shift(frames: Views, views: Views, depth: float) -> np.ndarray:
    """(n, T) parallax and turn between n frames and T views, in fields of view.

    Parallax is the distance of the cameras over the depth of the scene.
    """
    apart = pairwise_distances(frames.centers, views.centers)
    parallax = np.divide(apart, depth, out=np.where(apart > 0, np.inf, 0.0), where=depth > 0)
    turn = pairwise_angles(frames.axes, views.axes)
    return np.hypot(parallax, turn) / (2 * views.half_fov)


def scene_distances(capture: Capture, frames: np.ndarray) -> np.ndarray:
    """Return (n, n) distances of frames' centres plus those of the points looked at, in median
    depths of the scene."""
    depth = viewing_distance(capture.views, capture.points)[frames]
    centers = capture.centers[frames]
    places = np.stack([centers, centers + depth[:, None] * capture.axes[frames]], axis=1)
    scale = float(np.median(depth))
    places = places / (scale if scale > 0 else 1.0)
    return np.stack([lengths(places - place).sum(axis=1) for place in places])
