"""A sharp frame in the middle of each stretch of equal motion: AliceVision's smart keyframes."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np

from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly, just_enough
from fsel.selectors.baselines.drift import grey_images

WINDOW = 200 / 720  # its side as a share of the image's width
CELLS = 8  # over the width, each of which has one motion
DIGITS = 3  # of motions in pixels
FLOW = (0.5, 3, 15, 3, 5, 1.2, 0)  # Farneback's, as OpenCV's examples have it


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Raise the motion of a stretch as long as there are k or more; of more, evenly spaced ones.

    A frame's sharpness counts twice in the middle of its stretch, once at its ends.
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


METHOD = Method(
    "alicevision", "AliceVision smart", "observed", nested=False, select=select, reads=("images",)
)
