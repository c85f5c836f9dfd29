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
    """The problem of a request: every frame may be picked, the closest ones stand for the views.

    Unlike in the experiments a proxy is a candidate too: nothing is held back for a search. Where
    the whole capture is to be rendered, views off its path are served as well as those along it;
    where an object of it is, they are not, since they may miss it.

    Args:
        capture: the capture.
        targets: of a checked request.
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
        fixed_picks=targets.always,
        targets_unknown=whole,
    )


def described(capture: Capture) -> np.ndarray:
    """(N, D) float32 appearance descriptors of every frame, which need no weights."""
    from fsel.features.appearance import LAB_HOG, descriptors  # here: few methods read them

    return descriptors(np.asarray(capture.images), LAB_HOG)


def measured(
    methods: Iterable[Method],
    capture: Capture,
    sharpness_of: SharpnessOf,
    descriptors: np.ndarray | Describe | None = None,
) -> tuple[np.ndarray, np.ndarray | None]:
    """Sharpness and descriptors of every frame, where one of the methods reads them.

    Args:
        methods: that will select.
        capture: the capture; its images are opened for descriptors alone.
        sharpness_of: measures the sharpness of some frames.
        descriptors: those that are known, or what makes them; None for `described`.

    Returns:
        (N,) float64, zeros where no method reads it, and (N, D), None where no method reads them.
    """
    reads = {name for method in methods for name in method.reads}
    everything = np.arange(len(capture))
    sharpness = sharpness_of(everything) if "sharpness" in reads else np.zeros(len(capture))
    if "appearance" not in reads:
        return sharpness, None
    if descriptors is None or callable(descriptors):
        descriptors = (descriptors or described)(capture)
    return sharpness, descriptors
