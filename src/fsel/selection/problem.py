"""The selection problem that a request makes of a capture."""

from __future__ import annotations

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import pose_distance
from fsel.core.problem import Problem
from fsel.selection.focus import Focus
from fsel.selection.paths import with_views_beside
from fsel.selection.targets import ALL, Targets


def request_problem(
    capture: Capture,
    targets: Targets,
    sharpness: np.ndarray,
    focus: Focus | None,
    descriptors: np.ndarray | None,
) -> Problem:
    """The problem of a request: every frame may be picked, the closest ones stand for the views.

    Unlike in the experiments a proxy is a candidate too: nothing is held back for a search. Where
    the whole capture is to be rendered, views off its path are served as well as those along it;
    where an object of it is, they are not, since they may miss it.

    Args:
        capture: the capture.
        targets: what `checked_request` returned.
        sharpness: (N,) of every frame.
        focus: an object that targets must see.
        descriptors: (N, D) appearance of every frame; None where no method reads it.
    """
    pool, views, whole = targets.pool(capture), targets.views, targets.kind == ALL
    if whole and focus is None:
        views = with_views_beside(views, capture)
    distance = pose_distance(capture.centers[pool], capture.axes[pool], views.centers, views.axes)
    return Problem(
        capture=capture,
        candidates=pool,
        proxies=pool[np.argmin(distance, axis=0)],
        targets=views,
        descriptors=np.zeros((len(capture), 0), np.float32) if descriptors is None else descriptors,
        sharpness=np.asarray(sharpness, np.float64),
        focus=None if focus is None else focus.center,
        given=targets.always,
        whole=whole,
    )
