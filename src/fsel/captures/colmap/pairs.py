"""Pairs of images to match: neighbours in time, and images that look alike, which closes loops.

Images are compared by VLAD (Jegou et al. 2010) over a vocabulary made from the capture itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.features import descriptors_of

WORDS = 32
SAMPLE = 20_000  # descriptors that the vocabulary is made of
OVERLAP = 10  # images ahead that show much the same
STEPS = (1, 2, 3, 4, 6, 8, 12)  # images ahead that each is matched with; then 16, 32, 64, ...
LOOPS, FILMED = 8, 4  # images that look most alike, beyond those, in all and of videos
ROUNDS = cv2.TERM_CRITERIA_MAX_ITER + cv2.TERM_CRITERIA_EPS

Pairs = list[tuple[int, int]]


def every_pair(count: int) -> Pairs:
    """Return all (i, j), i < j."""
    return [(i, j) for i in range(count) for j in range(i + 1, count)]


def in_sequence(count: int) -> Pairs:
    """Return (i, j), i < j: `STEPS` ahead, and 16, 32, 64, ... ahead."""
    steps = [*STEPS]
    while steps[-1] * 2 < count:
        steps.append(2 ** int(np.log2(steps[-1]) + 1))
    return sorted((i, i + step) for i in range(count) for step in steps if i + step < count)


def alike(described: np.ndarray, known: Pairs, most: int = LOOPS) -> Pairs:
    """Return (i, j), i < j, of each (n, D) unit vector and `most` like it, beyond known pairs."""
    likeness = described @ described.T
    np.fill_diagonal(likeness, -np.inf)
    rows, columns = np.array(known, np.int64).reshape(-1, 2).T
    likeness[rows, columns] = likeness[columns, rows] = -np.inf
    best = np.argsort(-likeness, axis=1, kind="stable")[:, :most]
    rows, places = np.nonzero(np.isfinite(np.take_along_axis(likeness, best, axis=1)))
    found = np.sort(np.stack([rows, best[rows, places]], axis=1), axis=1)
    return sorted({(i, j) for i, j in found.tolist()})


def described(database: Path, names: Sequence[str]) -> np.ndarray:
    """Return (n, 32 * D) float32 unit vectors of n images with D-value features in a database."""
    with pycolmap.Database.open(str(database)) as stored:
        keys = {image.name: image.image_id for image in stored.read_all_images()}
        few = max(1, SAMPLE // len(names))
        sample = [descriptors_of(stored, keys[name])[:few] for name in names]
        cv2.setRNGSeed(0)
        drawn = np.concatenate(sample)
        count = min(WORDS, len(drawn))
        if not count:  # images that show nothing
            return np.zeros((len(names), 1), np.float32)
        _, _, words = cv2.kmeans(drawn, count, None, (ROUNDS, 15, 1e-3), 1, cv2.KMEANS_PP_CENTERS)
        return np.stack([_vlad(descriptors_of(stored, keys[name]), words) for name in names])


def _vlad(features: np.ndarray, words: np.ndarray) -> np.ndarray:
    """Sums of the features' offsets from their words, each scaled to unit length, in a row."""
    if not len(features):
        return np.zeros(words.size, np.float32)
    squares = (words**2).sum(axis=1)[None] - 2 * features @ words.T
    nearest = np.argmin(squares, axis=1)
    sums = np.zeros_like(words)
    np.add.at(sums, nearest, features - words[nearest])
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-9)
    return (sums / max(np.linalg.norm(sums), 1e-9)).ravel()
