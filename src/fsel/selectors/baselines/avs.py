"""AVS: the view that is rendered worst comes next (Wang et al. 2025, arXiv 2506.19844)."""

from __future__ import annotations

import cv2
import numpy as np

from fsel.core.capture import Views
from fsel.core.geometry import farthest_views
from fsel.core.problem import Method, Problem
from fsel.reconstruct.splats import Splats
from fsel.selectors.baselines.greedy import most_central
from fsel.selectors.baselines.splat_views import START

SIDE = 96  # pixels of the longer side, of fitted images and of renderings
TILES = 3  # of a photo, across and down, whose statistics are natural ones
RIDGE, TINY = 1e-3, 1e-12  # of the mean variance, and alone: a covariance may be singular


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Reconstruct from the picks, render all other frames' views, pick the worst; again and again.

    Starts with farthest views from the most central camera. Only images of picked frames are read;
    ties go to the lowest frame.
    """
    pool = problem.sequence if k <= len(problem.sequence) else problem.observed
    capture, centers = problem.capture, problem.capture.centers[pool]
    start = farthest_views(np.arange(len(pool)), centers, min(k, START), most_central(centers))
    frames: list[int] = pool[start].tolist()
    while len(frames) < k:
        picked = capture.subset(np.array(frames)).resized(SIDE)
        left = np.setdiff1d(pool, frames)
        scaled = capture.intrinsics[left] * np.tile(np.divide(picked.size, capture.size), 2)
        views = Views(capture.world_to_camera[left], scaled, picked.size)
        rendered = Splats(picked).fit(np.arange(len(frames))).render(views)
        worst = strangeness(rendered, np.asarray(picked.images))
        frames.append(int(left[np.argmax(worst)]))
    return np.array(frames)


def strangeness(images: np.ndarray, photos: np.ndarray) -> np.ndarray:
    """(T,) how far the statistics of images are from those of photos.

    The statistics of natural scenes that BRISQUE takes (Mittal et al. 2012) are compared by
    Mahalanobis' distance, as NIQE does (Mittal et al. 2013); the natural ones are the tiles of the
    photos.

    Args:
        images: (T, h, w, 3) in [0, 1].
        photos: (K, h, w, 3) uint8.
    """
    natural = np.array([statistics(tile) for photo in photos for tile in tiles(photo)])
    spread = np.cov(natural.T)
    spread += (RIDGE * np.trace(spread) / len(spread) + TINY) * np.eye(len(spread))
    gaps = np.array([statistics(np.round(image * 255).astype(np.uint8)) for image in images])
    gaps -= natural.mean(axis=0)
    return np.einsum("td,dt->t", gaps, np.linalg.solve(spread, gaps.T))


def tiles(photo: np.ndarray) -> list[np.ndarray]:
    """Cut (h, w, 3) into nine parts."""
    bands = np.array_split(photo, TILES)
    return [part for band in bands for part in np.array_split(band, TILES, axis=1)]


def statistics(image: np.ndarray) -> np.ndarray:
    """(36,) float64 BRISQUE's statistics of (h, w, 3) uint8; zeros stand for undefined ones."""
    found = cv2.quality.QualityBRISQUE.computeFeatures(np.ascontiguousarray(image))
    return np.nan_to_num(found[0].astype(np.float64))


METHOD = Method("avs", "AVS", "observed", nested=True, select=select, tracks=True)
