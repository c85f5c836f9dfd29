"""The selection problem of a request, and what methods read of images."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import pose_distance
from fsel.core.problem import Method, Problem
from fsel.selection.focus import Focus
from fsel.selection.paths import with_views_beside
from fsel.selection.request import Describe, SharpnessOf
from fsel.selection.targets import ALL, Targets


def request_problem(
    capture: Capture,
    targets: Targets,
    sharpness: np.ndarray,
    focus: Focus | None,
    descriptors: np.ndarray | None,
) -> Problem:
    """Return the problem of a request: every frame may be picked, the closest stand for the views.

    Unlike in the experiments a proxy is a candidate too. Where the whole capture is to be rendered,
    views off its path are served as well as those along it; where an object is, they may miss it.

    `sharpness` is (N,) and `descriptors` (N, D), None where no method reads it.
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
        fixed_picks=targets.always,
        targets_unknown=whole,
    )


def measured(
    methods: Iterable[Method],
    capture: Capture,
    sharpness_of: SharpnessOf,
    descriptors: np.ndarray | Describe | None = None,
) -> tuple[np.ndarray, np.ndarray | None]:
    """Measure sharpness, (N,) zeros where no method reads it, and (N, D) descriptors, or None.

    Images are opened for descriptors alone; `descriptors` are known, or make them; None: `lab_hog`.
    """
    reads = {name for method in methods for name in method.reads}
    n = len(capture)
    sharpness = sharpness_of(np.arange(n)) if "sharpness" in reads else np.zeros(n)
    if "appearance" not in reads:
        return sharpness, None
    if descriptors is None:
        from fsel.features.appearance import LAB_HOG  # here: rarely read
        from fsel.features.appearance import descriptors as describe

        return sharpness, describe(np.asarray(capture.images), LAB_HOG)
    return sharpness, descriptors(capture) if callable(descriptors) else descriptors
