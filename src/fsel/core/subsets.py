"""Subsets of frames, or of other rows: evenly spaced ones, and what tells two apart."""

from __future__ import annotations

import numpy as np


def evenly(count: int, most: int) -> np.ndarray:
    """(n,) int64 at most so many of `count` rows, evenly spaced, ascending, from the first on."""
    return np.round(np.linspace(0, count - 1, min(count, most))).astype(np.int64)


def subset_key(frames: np.ndarray) -> tuple[int, ...]:
    """The same for the same frames in any order: (K,) frames, ascending."""
    return tuple(np.sort(frames).tolist())
