"""The selection problem of a request, and what methods read of images."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import pose_distance
from fsel.core.problem import Method, Problem
from fsel.selection.focus import Focus
from fsel.selection.paths import with_views_beside
from fsel.selection.request import Describe, SharpnessOf
from fsel.selection.scene_depth import viewing_distance
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


def with_target_depths(problem: Problem) -> Problem:
    """Return the problem with how far what each target looks at is, the median depth of the sparse
    points that its proxy sees; as it is of a capture without points.

    Only where picks are no more than targets, see `Targets.as_many_as`, is `fsel` ahead by it.
    """
    capture, points = problem.capture, problem.capture.points
    nearest, place = np.unique(problem.proxies, return_inverse=True)
    seen = None if points is None else points.seen_from(nearest, len(capture))
    if seen is None or not len(seen.track_frame):
        return problem
    depths = viewing_distance(capture.view(nearest), seen)[place]
    return replace(problem, target_depths=depths) if (depths > 0).all() else problem


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
