"""Overlapping blocks of a large scene's cameras, by a spectral partition of covisibility.

Not in the paper. A trainer, or a network that takes so many frames at a time, reconstructs a large
scene in parts. Frames are halved by the second eigenvector of their normalised covisibility (Shi
and Malik 2000), and so on; each block takes the frames beside it that share most with it.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import ArpackNoConvergence, eigsh
from scipy.spatial import KDTree

from fsel.core.capture import Capture
from fsel.features.conditioned import look_embedding

OVERLAP = 0.2  # frames that a block takes of others, as a share of its own
ALIKE = 9  # frames that share a point where the capture has none: on a ring, four on each side
LEAST_FRAMES = 4  # of a part: fewer have no second eigenvector
RESTARTS = 30  # of Lanczos' iteration: 20,000 frames on a grid take fewer, 2,000 on a path more
ENOUGH = 300_000  # observations that tell covisibility: of more, those of every n-th point do


def blocks_of(capture: Capture, count: int) -> list[np.ndarray]:
    """Return the (n,) ascending frames of each block, in the order of their middles.

    Raises:
        ValueError: for fewer blocks than two, or more than there are frames for.
    """
    most = len(capture) // LEAST_FRAMES
    if not 2 <= count <= most:
        raise ValueError(f"blocks is {count}; allowed: 2 to {most}, {LEAST_FRAMES} frames each")
    shown = _sightings(capture)
    parts = sorted(_parted(shown, np.arange(len(capture)), count), key=np.mean)
    return [np.union1d(part, _beside(shown, part)) for part in parts]


def _sightings(capture: Capture) -> csr_array:
    """Return (N, M) which frame sees which point: the product with its transpose is covisibility.

    A point counts the less the more frames see it. Without points, each frame and those that look
    most like it share one; so do, besides, neighbours in order.
    """
    n, points = len(capture), capture.points
    if points is not None and len(points.track_point):
        each = -(-len(points.track_point) // ENOUGH)
        some = points.track_point % each == 0
        point, row = points.track_point[some] // each, points.track_frame[some]
    else:
        place = look_embedding(capture.centers, capture.axes)
        row = KDTree(place).query(place, min(n, ALIKE))[1].ravel()
        point = np.arange(n).repeat(len(row) // n)
    beside = np.arange(n - 1)
    point = np.concatenate([point, np.tile(beside + point.max() + 1, 2)])
    row = np.concatenate([row, beside, beside + 1])
    worth = 1 / np.sqrt(np.maximum(np.bincount(point), 1))
    return csr_array((worth[point], (row, point)), shape=(n, len(worth)))


def _parted(shown: csr_array, frames: np.ndarray, count: int) -> list[np.ndarray]:
    """Cut (n,) frames into so many parts of equal size by repeated halving."""
    if count == 1:
        return [frames]
    own = shown[frames]
    scale = 1 / np.sqrt(own @ own.sum(axis=0))
    scaled, start = diags_array(scale) @ own, np.random.default_rng(0).random(len(frames))
    alike = scaled @ scaled.T
    try:
        _, vectors = eigsh(alike, k=2, v0=start, maxiter=RESTARTS)
    except ArpackNoConvergence:  # along a path, where the inverse is quick
        _, vectors = eigsh(alike.tocsc(), k=2, sigma=1 + 1e-4, v0=start)
    order = np.argsort(vectors[:, 0] * scale, kind="stable")
    half = count // 2
    cut = len(frames) * half // count
    halves = (np.sort(frames[order[:cut]]), half), (np.sort(frames[order[cut:]]), count - half)
    return [part for rows, parts in halves for part in _parted(shown, rows, parts)]


def _beside(shown: csr_array, part: np.ndarray) -> np.ndarray:
    """Return the frames of other parts that share most of what they see with a part."""
    share = (shown @ shown[part].sum(axis=0)) / (shown @ shown.sum(axis=0))
    share[part] = 0
    best = np.argsort(-share, kind="stable")[: int(np.ceil(OVERLAP * len(part)))]
    return best[share[best] > 0]
