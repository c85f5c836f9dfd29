"""Parts of a capture that a selection reads, and measurements of its images, where it does."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext

import numpy as np

from fsel.captures.images.previews import Progress, in_silence
from fsel.captures.lazy import LazyCapture
from fsel.core.capture import Capture
from fsel.core.problem import Method
from fsel.selection.budget import Auto
from fsel.selection.patience import Patience
from fsel.selection.request import AUTO

Describe = Callable[[Capture], np.ndarray]
"""capture -> (N, D) float32 appearance descriptors of every frame."""
SharpnessOf = Callable[[np.ndarray], np.ndarray]
"""(n,) int64 frames -> (n,) sharpness of each, comparable within a call."""


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


def as_read(
    opened: LazyCapture,
    method: Method,
    k: int | str | Auto | None,
    patience: Patience,
    cover: int,
    *,
    bar: Progress = in_silence,
    clock: AbstractContextManager[None] | None = None,
) -> Capture:
    """The capture with what a selection reads of it.

    Methods that compare frames by appearance look at all pixels. Some methods look at points, and
    so does trying selections, which opens the images that it needs itself; finding a number of
    frames takes some points, for the depth that they tell.

    Args:
        opened: the capture.
        method, k, patience, cover: of the selection.
        bar: wraps the loop over the images.
        clock: lasts while points are read.
    """
    if "appearance" in method.reads:
        return opened.loaded(np.arange(len(opened.capture)), bar)
    with clock or nullcontext():
        if method.tracks or patience.seconds or cover:
            return opened.with_all_points()
        return opened.with_points() if k == AUTO or isinstance(k, Auto) else opened.capture
