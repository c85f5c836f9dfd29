"""Poses that contradict the points that their frames see, or the path beside them."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import camera_centers, lengths, viewing_angles
from fsel.core.points import quantile_of

TIMES = 6.0  # the capture's median error that a frame's is at most
LEAST_ERROR = 0.004  # of the longer side: 2 pixels at 480
LEAST_OBSERVED = 6  # points of a frame whose pose is judged by them
PAIRS = ((-1, 1), (-2, 2), (1, 2), (2, 4), (-1, -2), (-2, -4))  # frames that predict one
LEAST_PATH = 8  # frames of a pass whose smoothness can be judged
FAR = 3.0  # typical steps that a frame lies off the path of those beside it, at most
TURNED = np.radians(5)  # that it is turned off their directions, at most
SMOOTH = 0.95  # share of the frames that lie within a part of both, on a path
PART = (0.5 / FAR, 0.5)
AWAY, FAST = 60.0, 60.0  # degrees of a jump, and degrees a second, at least
USUAL = 8.0  # times the median degrees a second, likewise


def reprojection(
    errors: np.ndarray, frame: np.ndarray, count: int, side: float
) -> tuple[np.ndarray, float, np.ndarray]:
    """Return (N,) median reprojection errors of frames, pixels, NaN for few observations, the
    largest that is usual, and (N,) shares of observations within it; (L,) errors are each of a
    frame."""
    many = np.bincount(frame, minlength=count)
    median = quantile_of(errors, frame, count, 0.5)
    median[many < LEAST_OBSERVED] = np.nan
    known = median[np.isfinite(median)]
    limit = max(TIMES * float(np.median(known)) if len(known) else 0.0, LEAST_ERROR * side)
    within = np.bincount(frame[errors <= limit], minlength=count) / np.maximum(many, 1)
    return median, limit, within


def jumps(world_to_camera: np.ndarray) -> np.ndarray:
    """Return the distances of (n, 3, 4) poses, in the order of filming, from the path of those
    beside them, over the allowed distance: above 1 for jumps. The nearest prediction, from frames
    before, after or around, counts; zeros where there is no smooth path."""
    count, nothing = len(world_to_camera), np.zeros(len(world_to_camera))
    if count < LEAST_PATH:
        return nothing
    centers = camera_centers(world_to_camera)
    step = float(np.median(lengths(np.diff(centers, axis=0))))
    moved = _off(centers) / (FAR * step) if step > 0 else np.full(count, np.inf)
    turned = np.max([_off(world_to_camera[:, row, :3]) for row in (1, 2)], axis=0) / TURNED
    off = np.quantile([moved, turned], SMOOTH, axis=1, method="lower")
    return np.maximum(moved, turned) if (off <= PART).all() else nothing


def turned_away(world_to_camera: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Return by how many degrees each frame of a video looks away from the one before; (n,), zero
    but where no camera is turned so fast.

    A scene that looks alike from two sides folds a path, and both parts agree with all they see.
    """
    axes, found = world_to_camera[:, 2, :3], np.zeros(len(seconds))
    if len(seconds) >= LEAST_PATH:
        degrees = np.degrees(viewing_angles(axes[1:], axes[:-1]))
        pace = degrees / np.diff(seconds)
        least = max(FAST, USUAL * float(np.median(pace)))
        found[1:] = np.where((degrees > AWAY) & (pace > least), degrees, 0)
    return found


def _off(vectors: np.ndarray) -> np.ndarray:
    """(n,) distances of (n, 3) vectors from what those beside them predict, by the best pair."""
    count = len(vectors)
    rows, off = np.arange(count), np.full(count, np.inf)
    for one, other in PAIRS:
        inside = rows[(rows + min(one, other) >= 0) & (rows + max(one, other) < count)]
        weight = other / (other - one)
        predicted = weight * vectors[inside + one] + (1 - weight) * vectors[inside + other]
        off[inside] = np.minimum(off[inside], lengths(vectors[inside] - predicted))
    return off
