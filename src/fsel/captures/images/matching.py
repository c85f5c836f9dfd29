"""Matching a few pairs of frames, and how far the matches lie from the poses' epipolar lines."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.core.geometry import camera_centers, pairwise_angles, pairwise_distances
from fsel.core.subsets import evenly

RATIO = 0.8  # of the nearest descriptor's distance to the second nearest's (Lowe 2004)
FEATURES = 2000
RANSAC_PIXELS = 2.0
MIN_INLIERS = 15  # of a fundamental matrix, below which a pair is not used
MAX_ANGLE = np.radians(25)
BASELINE = 0.1  # of the extent of the camera centres: wide enough to fix a line, near to match
FOCAL_RANGE = (0.3, 3.0)  # focal length over image width


def choose_pairs(world_to_camera: np.ndarray, count: int) -> list[tuple[int, int]]:
    """Return pairs of `count` frames, spread evenly over a capture of (N, 3, 4) poses, with others
    that look the same way from apart.

    The partner of a frame is the one within 25 degrees of it whose distance comes nearest to a
    tenth of the capture's extent.
    """
    rotation = world_to_camera[:, :, :3]
    centers = camera_centers(world_to_camera)
    wanted = BASELINE * np.linalg.norm(np.ptp(centers, axis=0))
    some = evenly(len(centers), count)
    distance = pairwise_distances(centers[some], centers)
    angle = pairwise_angles(rotation[some, 2], rotation[:, 2])
    fit = np.where((angle < MAX_ANGLE) & (distance > 0.2 * wanted), abs(distance - wanted), np.inf)
    best, usable = np.argmin(fit, axis=1), np.isfinite(fit).any(axis=1)
    pairs = zip(some[usable].tolist(), best[usable].tolist(), strict=True)
    return sorted({(min(pair), max(pair)) for pair in pairs})


def match(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (n, 2) pixels of two (h, w, 3) images that agree with one fundamental matrix, none
    where too few agree."""
    sift, nothing = cv2.SIFT.create(FEATURES), np.empty((0, 2))
    (a, descriptors_a), (b, descriptors_b) = (
        sift.detectAndCompute(cv2.cvtColor(i, cv2.COLOR_RGB2GRAY), None) for i in (first, second)
    )
    if min(len(a), len(b)) < MIN_INLIERS:
        return nothing, nothing
    there = _nearest(descriptors_a, descriptors_b)
    back = _nearest(descriptors_b, descriptors_a)
    mutual = [(i, j) for i, j in there.items() if back.get(j) == i]
    if len(mutual) < MIN_INLIERS:
        return nothing, nothing
    xa = np.array([a[i].pt for i, _ in mutual]) + 0.5
    xb = np.array([b[j].pt for _, j in mutual]) + 0.5
    inlier = agreeing(xa, xb)
    return (xa[inlier], xb[inlier]) if inlier.sum() >= MIN_INLIERS else (nothing, nothing)


def agreeing(xa: np.ndarray, xb: np.ndarray) -> np.ndarray:
    """(n,) bool, which of (n, 2) matching pixels agree with one fundamental matrix, if there is."""
    try:
        _, kept = cv2.findFundamentalMat(xa, xb, cv2.USAC_ACCURATE, RANSAC_PIXELS, 0.999, 2000)
    except cv2.error:  # what OpenCV does where no sample of the matches gives a matrix
        kept = None
    return np.zeros(len(xa), bool) if kept is None else kept.ravel().astype(bool)


def _nearest(queries: np.ndarray, others: np.ndarray) -> dict[int, int]:
    """Query -> its nearest descriptor, where that is clearly nearer than the second."""
    pairs = cv2.BFMatcher(cv2.NORM_L2).knnMatch(queries, others, k=2)
    return {p[0].queryIdx: p[0].trainIdx for p in pairs if p[0].distance < RATIO * p[1].distance}


def epipolar_distances(
    xa: np.ndarray,
    xb: np.ndarray,
    pose_a: np.ndarray,
    pose_b: np.ndarray,
    ka: np.ndarray,
    kb: np.ndarray,
) -> np.ndarray:
    """Return (n,) mean pixels from each match, (n, 2) in both images, to the two epipolar lines
    that (3, 4) poses and (4,) intrinsics predict."""
    rotation = pose_b[:, :3] @ pose_a[:, :3].T
    t = pose_b[:, 3] - rotation @ pose_a[:, 3]
    cross = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]])
    inverse_a, inverse_b = np.linalg.inv(_matrix(ka)), np.linalg.inv(_matrix(kb))
    fundamental = inverse_b.T @ cross @ rotation @ inverse_a
    a, b = (np.column_stack([x, np.ones(len(x))]) for x in (xa, xb))
    line_b, line_a = a @ fundamental.T, b @ fundamental
    algebraic = np.abs(np.sum(b * line_b, axis=1))
    lengths = [np.maximum(np.linalg.norm(line[:, :2], axis=1), 1e-300) for line in (line_a, line_b)]
    return algebraic * (1 / lengths[0] + 1 / lengths[1]) / 2


def _matrix(k: np.ndarray) -> np.ndarray:
    return np.array([[k[0], 0, k[2]], [0, k[1], k[3]], [0, 0, 1.0]])


def focal_from_poses(
    matches: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]], size: tuple[int, int]
) -> float:
    """Return the pixels of focal length that lay matches onto the epipolar lines of known poses.

    It minimises the median distance over 0.3 to 3 image widths: the best of a grid, then a bounded
    search around it. The principal point is taken to be the centre.

    Args:
        matches: (xa, xb, pose_a, pose_b) of each pair.
        size: (width, height) of the images.
    """
    from scipy.optimize import minimize_scalar  # here: slow to import, and seldom needed

    width, height = size

    def cost(log_focal: float) -> float:
        focal = width * np.exp(log_focal)
        k = np.array([focal, focal, width / 2, height / 2])
        return float(np.median(np.concatenate([epipolar_distances(*m, k, k) for m in matches])))

    grid = np.linspace(np.log(FOCAL_RANGE[0]), np.log(FOCAL_RANGE[1]), 40)
    best = grid[np.argmin([cost(value) for value in grid])]
    step = grid[1] - grid[0]
    minimum = minimize_scalar(cost, bounds=(best - step, best + step), method="bounded")
    return float(width * np.exp(minimum.x))
