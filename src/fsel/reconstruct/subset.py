"""Part of a capture that a reconstruction may see: the selected frames, and points they share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.points import SparsePoints


def distinct(frames: np.ndarray) -> np.ndarray:
    """(K,) int64 frames as given, K >= 2.

    Raises:
        ValueError: for fewer than two, which hold no parallax, or repeated ones.
    """
    frames = np.asarray(frames, np.int64)
    if len(frames) < 2 or len(np.unique(frames)) < len(frames):
        raise ValueError(f"need two or more distinct frames, got {frames.tolist()}")
    return frames


def restricted(capture: Capture, frames: np.ndarray) -> Capture:
    """The capture of the given frames alone, with the points that at least two of them see.

    Args:
        capture: any.
        frames: (K,) int64, distinct.
    """
    own = capture.subset(frames)
    return own if own.points is None else replace(own, points=_shared(own.points))


def _shared(points: SparsePoints) -> SparsePoints:
    """The points that two frames or more see, and their tracks without repetitions."""
    track = np.unique(np.stack([points.track_point, points.track_frame]), axis=1)
    kept = np.bincount(track[0], minlength=len(points.xyz)) >= 2
    row = np.cumsum(kept) - 1
    track = track[:, kept[track[0]]]
    return SparsePoints(points.xyz[kept], points.rgb[kept], row[track[0]], track[1])
