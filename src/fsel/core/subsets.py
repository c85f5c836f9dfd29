"""Subsets of frames, or of other rows: evenly spaced ones, and what tells two apart."""

from __future__ import annotations

import numpy as np


def evenly(count: int, most: int) -> np.ndarray:
    """Return at most `most` of `count` rows, (n,) int64, evenly spaced, from the first on."""
    return np.round(np.linspace(0, count - 1, min(count, most))).astype(np.int64)


def subset_key(frames: np.ndarray) -> tuple[int, ...]:
    """Return a key of (K,) frames that is the same in any order."""
    return tuple(np.sort(frames).tolist())
