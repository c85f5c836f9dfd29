"""Scene of the report's turning view: cameras, targets and points."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import plane_basis, upwards
from fsel.core.points import SparsePoints
from fsel.core.subsets import evenly
from fsel.selection.export.record import Outcome

MOST_POINTS = 4000
TICK = 0.08  # length of a viewing direction, as a share of the view
CORE = 95  # per cent of the points that the view is scaled to, where they lie close enough
WIDEST = 1.5  # times the cameras' own reach: farther points would make one dot of the cameras


def scene_data(outcome: Outcome, frames: np.ndarray, points: SparsePoints | None) -> dict:
    """Places around the origin, with z upwards, of extent 1.

    Args:
        outcome: the selection.
        frames: (n,) whose cameras are shown.
        points: sparse points of the scene, or None.

    Returns:
        `frames` and `targets` (place and tip of the viewing direction each), the targets being
        those that are no frames, and `points` (place and colour).
    """
    capture, targets = outcome.capture, outcome.targets
    up = upwards(capture.world_to_camera)
    side, ahead = plane_basis(up)
    basis = np.stack([side, ahead, up], axis=1)
    drawn = np.zeros(0, np.int64) if len(targets.frames) else np.flatnonzero(~targets.far)
    views = targets.views.subset(drawn)
    centers, others = capture.centers @ basis, views.centers @ basis
    cloud = np.empty((0, 3)) if points is None else points.xyz @ basis
    extent, middle = _extent(np.concatenate([centers, others]), cloud)

    def placed(places: np.ndarray, axes: np.ndarray) -> list:
        put = (places - middle) / extent
        return np.stack([put, put + TICK * (axes @ basis)], axis=1).round(4).tolist()

    some = evenly(len(cloud), MOST_POINTS)
    colours = np.empty((0, 3)) if points is None else points.rgb[some]
    put = np.hstack([((cloud[some] - middle) / extent).round(4), colours]).tolist()
    return {
        "frames": placed(centers[frames], capture.axes[frames]),
        "targets": placed(others, views.axes),
        "points": put,
    }


def _extent(cameras: np.ndarray, cloud: np.ndarray) -> tuple[float, np.ndarray]:
    """Extent and middle of the view: all cameras, and near points around them."""
    middle = (cameras.min(axis=0) + cameras.max(axis=0)) / 2
    reach = float(np.linalg.norm(cameras - middle, axis=1).max())
    far = np.linalg.norm(cloud - middle, axis=1)
    core = float(np.percentile(far, CORE)) if len(far) else 0.0
    around = min(core, WIDEST * reach) if reach else core
    return max(reach, around) or 1.0, middle
