"""How many frames of a capture show something that no other frame shows as well."""

from __future__ import annotations

import numpy as np

from fsel.capture import Views
from fsel.geometry import lengths, viewing_angles
from fsel.points import SparsePoints
from fsel.request.paths import attention

PARALLAX = np.radians(8)  # best for stereo; frames closer than this see much the same
TURN = 0.25  # of the field of view: frames turned by less share most of what they see


def viewing_distance(views: Views, points: SparsePoints | None) -> np.ndarray:
    """(T,) how far what each view looks at is, world units.

    The median depth of the sparse points that it sees; of all frames' points where it sees none;
    without points, the distance of the point that the cameras look at, or their spread where
    there is no such point.

    Args:
        views: T frames.
        points: whose tracks number these frames.
    """
    if points is not None and len(points.track_frame):
        pose = views.world_to_camera[points.track_frame]
        seen = points.xyz[points.track_point]
        depth = np.einsum("li,li->l", pose[:, 2, :3], seen) + pose[:, 2, 3]
        found = np.full(len(views), np.median(depth))
        order = np.argsort(points.track_frame, kind="stable")
        frames, starts = np.unique(points.track_frame[order], return_index=True)
        found[frames] = [np.median(part) for part in np.split(depth[order], starts[1:])]
        return found
    centers = views.centers
    try:
        return lengths(attention(centers, views.axes) - centers)
    except ValueError:
        return np.full(len(views), lengths(centers - centers.mean(axis=0)).max())


def worth_keeping(views: Views, distance: np.ndarray) -> np.ndarray:
    """(m,) frames, ascending, such that every other frame is near one of them.

    Going through them, a frame is kept unless an earlier kept one lies within 8 degrees of
    parallax and a quarter of a field of view.

    Args:
        views: N frames.
        distance: (N,) of what each frame looks at, see `viewing_distance`.
    """
    centers, axes = views.centers, views.axes
    parallax = PARALLAX * np.maximum(distance, np.finfo(float).tiny)
    turn = 2 * TURN * views.half_fov
    near = np.zeros(len(views), bool)
    kept = []
    for frame in range(len(views)):
        if not near[frame]:
            kept.append(frame)
            apart = lengths(centers - centers[frame])
            near |= (apart < parallax) & (viewing_angles(axes, axes[frame]) < turn)
            near[frame] = True
    return np.array(kept)
