"""Quantiles of values that share a key: a point's, or a frame's."""

from __future__ import annotations

import numpy as np


def quantile_of(values: np.ndarray, keys: np.ndarray, count: int, share: float) -> np.ndarray:
    """(count,) the lower quantile of the values of each key; NaN for a key without any.

    Args:
        values: (L,), none NaN.
        keys: (L,) int64 below `count`.
        count: how many keys there are.
        share: of each key's values that lie below, 0 to 1.
    """
    order = np.lexsort((values, keys))
    bounds = np.searchsorted(keys[order], np.arange(count + 1))
    size = np.diff(bounds)
    place = bounds[:-1] + (share * np.maximum(size - 1, 0)).astype(np.int64)
    found = np.full(count, np.nan)
    found[size > 0] = values[order][place[size > 0]]
    return found
