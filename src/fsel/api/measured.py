"""Measurements of a capture's images that selection methods read, made where one of them does."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from fsel.data.capture import Capture
from fsel.data.problem import Method

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
