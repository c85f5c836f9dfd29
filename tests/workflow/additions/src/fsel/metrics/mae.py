"""Mean absolute error over all channels."""

from __future__ import annotations

import numpy as np

from fsel.metrics.contract import Metric


def score(rendered: np.ndarray, truth: np.ndarray, masks: np.ndarray | None) -> np.ndarray:
    """(T,) of each view, or of the part of it inside a mask."""
    error = np.abs(rendered - truth / 255).mean(axis=-1)
    return np.average(error, axis=(1, 2), weights=masks)


METRIC = Metric("mae", "MAE", False, score)
