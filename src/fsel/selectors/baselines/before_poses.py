"""What tools do before poses are known: nothing but the images, in capture order, is looked at."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np

from fsel.core.geometry import farthest_views
from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly, just_enough

GAP = 4  # frames from one pick of best-N to the next at least, where so many leave room
SHARPNESS, POSITION = 0.7, 0.3  # shares of its score
WINDOW = 200 / 720  # AliceVision's: its side as a share of the image's width
CELLS = 8  # over the width, each of which has one motion
DIGITS = 3  # of motions in pixels
FLOW = (0.5, 3, 15, 3, 5, 1.2, 0)  # Farneback's, as OpenCV's examples have it


def grey_images(problem: Problem) -> list[np.ndarray]:
    """Return (h, w) uint8 images of the observed frames."""
    images = (np.ascontiguousarray(problem.capture.images[i]) for i in problem.observed)
    return [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in images]


def best_n(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick from each of k equal stretches of the pool the frame of the best score (sharp-frames
    0.4, `selection_methods.py`).

    It is 0.7 of the sharpness, scaled to 0..1, and 0.3 of a triangle that peaks in the middle of
    the stretch. A stretch without a frame far enough from the last pick takes any that leaves room
    for the rest.
    """
    pool = problem.observed
    n, sharp = len(pool), problem.sharpness[pool]
    sharp = sharp / max(np.ptp(sharp), 1e-12)
    gap = min(GAP, (n - 1) // max(k - 1, 1))
    picks: list[int] = []
    for stretch in range(k):
        first, last = stretch * n // k, (stretch + 1) * n // k - 1
        earliest = picks[-1] + gap if picks else 0
        latest = n - 1 - (k - 1 - stretch) * gap
        start, end = max(first, earliest), min(last, latest)
        rows = np.arange(start, end + 1) if start <= end else np.arange(earliest, latest + 1)
        off = np.abs(rows - (first + last) / 2) / max(1, (last - first + 1) / 2)
        score = SHARPNESS * sharp[rows] + POSITION * np.maximum(0, 1 - off)
        picks.append(int(rows[np.argmax(score)]))
    return pool[picks]


def thumbnail(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the frame nearest to the mean histogram of each of k batches as equal as can be:
    ffmpeg's `thumbnail`, as in nerfstudio; ties go to the lowest."""
    counts = {frame: histogram(problem.capture.images[frame]) for frame in problem.observed}
    picks = []
    for batch in np.array_split(problem.observed, k):
        of_batch = np.array([counts[frame] for frame in batch])
        off = np.square(of_batch - of_batch.mean(axis=0)).sum(axis=1)
        picks.append(batch[np.argmin(off)])
    return np.array(picks)


def histogram(image: np.ndarray) -> np.ndarray:
    """Return (3 * 256,) int64 pixels of an (h, w, 3) uint8 image at each level of a channel."""
    return np.bincount((image + np.array([0, 256, 512])).ravel(), minlength=3 * 256)


def alicevision(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick a sharp frame in the middle of each stretch of equal motion: AliceVision's smart
    keyframes.

    The motion of a stretch is raised as long as there are k or more; of more, evenly spaced ones. A
    frame's sharpness counts twice in the middle of its stretch, once at its ends.
    """
    images = grey_images(problem)
    moved = np.array([motion(image, before) for before, image in pairwise(images)])
    least = just_enough(lambda step: len(stretches(moved, step)), moved.sum() + 1, 0.0, k)
    rows = stretches(moved, least)
    rows = [rows[i] for i in evenly(len(rows), k)]
    sharp = np.array([sharpness(image) for image in images])
    return problem.observed[[row[np.argmax(sharp[row] * weights(len(row)))] for row in rows]]


def stretches(moved: np.ndarray, step: float) -> list[np.ndarray]:
    """Return the rows of each stretch, which ends before the motion since its start reaches a step,
    given (n - 1,) motions from row to row."""
    starts, total = [0], 0.0
    for row, one in enumerate(moved, start=1):
        total += one
        if total >= step:
            starts.append(row)
            total = 0.0
    return np.split(np.arange(len(moved) + 1), starts[1:])


def weights(count: int) -> np.ndarray:
    """Return (count,) weights, 2 for the frame or the two in the middle, falling to the ends."""
    off = np.abs(np.arange(count) - (count - 1) / 2) - (count + 1) % 2 / 2
    return 2 - off * 2 / max(count - 1, 1)


def sharpness(image: np.ndarray) -> float:
    """Return the largest standard deviation of the Laplacian in a window of an (h, w) image."""
    side = max(1, min(round(WINDOW * image.shape[1]), *image.shape))
    sums = cv2.integral2(cv2.Laplacian(image, cv2.CV_64F))
    once, square = (
        t[side:, side:] + t[:-side, :-side] - t[side:, :-side] - t[:-side, side:] for t in sums
    )
    return float(np.sqrt(max(0.0, (square - once**2 / side**2).max() / side**2)))


def motion(image: np.ndarray, previous: np.ndarray) -> float:
    """Return the median over cells of the length of their mean optical flow, in pixels.

    It is Farneback's; AliceVision's is DeepFlow, which takes twenty times as long.
    """
    flow = cv2.calcOpticalFlowFarneback(image, previous, None, *FLOW)
    cells = CELLS, max(1, round(CELLS * image.shape[0] / image.shape[1]))
    means = cv2.resize(flow, cells, interpolation=cv2.INTER_AREA).astype(np.float64)
    # what is smaller is the arithmetic's own, which differs among processors
    return round(float(np.median(np.linalg.norm(means, axis=2))), DIGITS)


def farthest(descriptors: np.ndarray, k: int) -> np.ndarray:
    """Return (k,) rows of (n, d) unit descriptors: that which all others resemble most, then the
    least like those before it, as VGGSfM and VGGT choose frames to begin with."""
    described = np.asarray(descriptors, np.float64)
    central = int(np.argmax(np.einsum("nd,d->n", described, described.sum(axis=0))))
    return farthest_views(np.arange(len(described)), described, k, central).astype(np.int64)


def _method(name: str, label: str, select, reads: str = "images") -> Method:
    return Method(name, label, "observed", nested=False, select=select, reads=(reads,))


BEST_N = _method("best_n", "Sharp-frames best-N", best_n, "sharpness")
ALICEVISION = _method("alicevision", "AliceVision smart", alicevision)
THUMBNAIL = _method("thumbnail", "ffmpeg thumbnail", thumbnail)
