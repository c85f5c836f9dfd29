"""Views that lie behind surfaces, as far as sparse points tell."""

from __future__ import annotations

import numpy as np

from fsel.core.capture import Views
from fsel.core.points import SparsePoints

NEAR = np.radians(4)  # from a camera, points this close to a view's direction tell the depth
FEWEST = 4  # such points
BEHIND = 0.85  # of the view's distance: points closer than this lie before it
WITNESSES = 3  # least cameras that see points before the view


def behind(views: Views, cameras: Views, points: SparsePoints) -> np.ndarray:
    """(T,) bool: more cameras see surfaces before the view's place than see past it.

    A camera counts where it sees four points or more within 4 degrees of the direction to the
    place. It counts by the points that it sees itself, so that one wall does not hide what other
    cameras saw from the other side.

    Args:
        views: T views.
        cameras: N frames.
        points: whose tracks number the frames.
    """
    balance = np.zeros((2, len(views)), np.int64)
    order = np.argsort(points.track_frame, kind="stable")
    bounds = np.searchsorted(points.track_frame[order], np.arange(len(cameras) + 1))
    for i, center in enumerate(cameras.centers):
        seen = points.xyz[points.track_point[order[bounds[i] : bounds[i + 1]]]] - center
        if len(seen) < FEWEST:
            continue
        places = views.centers - center
        reach, depth = np.linalg.norm(places, axis=1), np.linalg.norm(seen, axis=1)
        across = (places / np.maximum(reach, 1e-12)[:, None]) @ (seen / depth[:, None]).T
        close = across > np.cos(NEAR)
        known = close.sum(axis=1) >= FEWEST
        before = (close & (depth < BEHIND * reach[:, None])).sum(axis=1)
        hidden = 2 * before > close.sum(axis=1)
        balance[0] += known & hidden
        balance[1] += known & ~hidden
    return (balance[0] >= WITNESSES) & (balance[0] > balance[1])
