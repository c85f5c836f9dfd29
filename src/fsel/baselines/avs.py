"""AVS: the view that is rendered worst comes next (Wang et al. 2025, arXiv 2506.19844)."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.baselines.greedy import most_central
from fsel.baselines.splat_views import START
from fsel.data.capture import Views
from fsel.data.geometry import farthest_views
from fsel.data.problem import Method, Problem
from fsel.reconstruct.splats import Splats

SIDE = 96  # pixels of the longer side, of fitted images and of renderings
TILES = 3  # across and down, whose statistics are taken apart
RIDGE = 1e-3  # of the mean variance, added to a covariance of fewer tiles than statistics


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Reconstruct from the picks, render all other frames' views, pick the worst; again and again.

    Starts with farthest views from the most central camera. Only images of picked frames are read;
    ties go to the lowest frame.
    """
    pool = problem.sequence if k <= len(problem.sequence) else problem.observed
    capture = problem.capture.subset(pool)
    first = min(k, START)
    rows = farthest_views(
        np.arange(len(pool)), capture.centers, first, most_central(capture.centers)
    ).tolist()
    while len(rows) < k:
        picked = capture.subset(np.array(rows)).resized(SIDE)
        left = np.setdiff1d(np.arange(len(pool)), rows)
        factors = np.tile(np.divide(picked.size, capture.size), 2)
        views = Views(
            capture.world_to_camera[left], capture.intrinsics[left] * factors, picked.size
        )
        rendered = Splats(picked).fit(np.arange(len(rows))).render(views)
        worst = strangeness(rendered, np.asarray(picked.images) / np.float32(255))
        rows.append(int(left[np.argmax(worst)]))
    return pool[rows]


def strangeness(images: np.ndarray, photos: np.ndarray) -> np.ndarray:
    """(T,) how far the statistics of images are from those of photos, by NIQE's distance.

    The statistics of natural scenes that BRISQUE takes (Mittal et al. 2012) are compared as NIQE
    does (Mittal et al. 2013): Mahalanobis' distance of the means under the mean of the covariances,
    the photos that were picked being the natural ones.

    Args:
        images: (T, h, w, 3) in [0, 1].
        photos: (K, h, w, 3) in [0, 1].
    """
    natural = np.concatenate([statistics(photo) for photo in photos])
    mean, spread = natural.mean(axis=0), np.cov(natural.T)
    distances = []
    for image in images:
        own = statistics(image)
        pooled = (spread + np.cov(own.T)) / 2
        pooled += RIDGE * np.trace(pooled) / len(pooled) * np.eye(len(pooled))
        gap = own.mean(axis=0) - mean
        distances.append(np.sqrt(gap @ np.linalg.solve(pooled, gap)))
    return np.array(distances)


def statistics(image: np.ndarray) -> np.ndarray:
    """(9, 36) float64 BRISQUE's statistics of the tiles of an image in [0, 1]."""
    content = np.round(image * 255).astype(np.uint8)
    height, width = (side // TILES for side in content.shape[:2])
    tiles = [
        np.ascontiguousarray(content[y * height :][:height, x * width :][:, :width])
        for y in range(TILES)
        for x in range(TILES)
    ]
    found = [cv2.quality.QualityBRISQUE.computeFeatures(tile)[0] for tile in tiles]
    return np.nan_to_num(np.array(found, np.float64))


METHOD = Method("avs", "AVS", "observed", nested=True, seeds=1, select=select, tracks=True)
