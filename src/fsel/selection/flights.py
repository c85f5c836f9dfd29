"""Flights of a camera: any number of views along what a person asks for."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation, RotationSpline

from fsel.core.capture import Capture, Views
from fsel.core.geometry import poses_at
from fsel.selection.targets import Request, targets_of

STILL = 0.05  # of the mean way between two cameras: what a stop takes at least


def flight(capture: Capture, request: Request, count: int, long_side: int) -> Views:
    """Return views of an orbit, the smoothed camera path, a camera path's file, or between frames.

    Frames are flown through in the capture's order; a camera path's file gives no more views than
    it has. `long_side` in pixels may be more than the capture's.
    """
    targets = targets_of(capture, request, count)
    views = between(targets.views, count) if len(targets.frames) else targets.views
    scale = long_side / max(views.size)
    width, height = (max(1, round(side * scale)) for side in views.size)
    return Views(views.world_to_camera, views.intrinsics * scale, (width, height))


def between(views: Views, count: int) -> Views:
    """A smooth path through two or more views, at an even speed; one view stands still."""
    if len(views) == 1:
        return views.subset(np.zeros(count, np.int64))
    ways = np.linalg.norm(np.diff(views.centers, axis=0), axis=1)
    ways += STILL * ways.mean() or 1.0
    known = np.concatenate([[0], np.cumsum(ways)])
    times = np.linspace(0, known[-1], count)
    turns = RotationSpline(known, Rotation.from_matrix(views.world_to_camera[:, :, :3]))
    centers = PchipInterpolator(known, views.centers)(times)
    lenses = PchipInterpolator(known, views.intrinsics)(times)
    return Views(poses_at(centers, turns(times).as_matrix()), lenses, views.size)
