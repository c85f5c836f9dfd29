"""Places of cameras and what they look at, in depths of the scene: how far frames are apart."""

from __future__ import annotations

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import lengths
from fsel.selection.scene_depth import viewing_distance


def scene_places(capture: Capture, frames: np.ndarray) -> np.ndarray:
    """(n, 2, 3) camera centres and the points looked at, over the median depth.

    Args:
        capture: whose sparse points tell the depth, see `viewing_distance`.
        frames: (n,).
    """
    depth = viewing_distance(capture.views, capture.points)[frames]
    centers = capture.centers[frames]
    places = np.stack([centers, centers + depth[:, None] * capture.axes[frames]], axis=1)
    scale = float(np.median(depth))
    return places / (scale if scale > 0 else 1.0)


def distances_to(places: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(n,) distances of centres plus those of points looked at: a turn counts by how far it moves
    what is seen.

    Args:
        places: (n, 2, 3).
        place: (2, 3).
    """
    return lengths(places - place).sum(axis=1)


def scene_distances(capture: Capture, frames: np.ndarray) -> np.ndarray:
    """(n, n) between all frames, see `distances_to`."""
    places = scene_places(capture, frames)
    return np.stack([distances_to(places, place) for place in places])
