"""Subsets of frames, or of other rows: evenly spaced ones, and what tells two apart."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

BISECTIONS = 30


def evenly(count: int, most: int) -> np.ndarray:
    """Return at most `most` of `count` rows, (n,) int64, evenly spaced, from the first on."""
    return np.round(np.linspace(0, count - 1, min(count, most))).astype(np.int64)


def just_enough(count: Callable[[float], int], few: float, enough: float, k: int) -> float:
    """Return the value nearest to `few`, whose count is below k, on the side of `enough`."""
    for _ in range(BISECTIONS):
        middle = (few + enough) / 2
        few, enough = (few, middle) if count(middle) >= k else (middle, enough)
    return enough


def subset_key(frames: np.ndarray) -> tuple[int, ...]:
    """Return a key of (K,) frames that is the same in any order."""
    return tuple(np.sort(frames).tolist())
