"""Equal drifts of tracked keypoints from pick to pick, as keyframes of VidMap are spaced."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np

from fsel.core.problem import Method, Problem

KEYPOINTS, QUALITY, APART = 200, 0.01, 5  # of each image: number, least response, pixels
LOST = 0.25  # of the longer side: the drift of a keypoint that is not found again


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick the frames nearest to equal steps of the drift that sums up in capture order."""
    path = np.append(0, np.cumsum([drift(*pair) for pair in pairwise(grey_images(problem))]))
    picks: list[int] = []
    for at, goal in enumerate(np.linspace(0, path[-1], k)):
        rows = np.arange(picks[-1] + 1 if picks else 0, len(path) - (k - 1 - at))
        picks.append(int(rows[np.argmin(np.abs(path[rows] - goal))]))
    return problem.observed[picks]


def grey_images(problem: Problem) -> list[np.ndarray]:
    """Return (h, w) uint8 images of the observed frames."""
    images = (np.ascontiguousarray(problem.capture.images[i]) for i in problem.observed)
    return [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in images]


def drift(first: np.ndarray, second: np.ndarray) -> float:
    """Return the median motion of the keypoints of an (h, w) grey image, as a share of its side.

    They are corners (Shi and Tomasi 1994), followed by pyramidal Lucas-Kanade.
    """
    points = cv2.goodFeaturesToTrack(first, KEYPOINTS, QUALITY, APART)
    if points is None:
        return LOST
    moved, found, _ = cv2.calcOpticalFlowPyrLK(first, second, points, None)
    motion = np.linalg.norm((moved - points)[:, 0], axis=1) / max(first.shape)
    return float(np.median(np.where(found[:, 0] == 1, np.minimum(motion, LOST), LOST)))


METHOD = Method(
    "drift", "Keypoint drift", "observed", nested=False, select=select, reads=("images",)
)
