"""COVER: the view whose splats have been seen least from its side (Chen et al. 2026)."""

from __future__ import annotations

import numba
import numpy as np

from fsel.baselines.splat_views import Blends, greedy_on_splats, held_by
from fsel.problem import Method, Problem

BINS = 128  # directions on the sphere
EMPTY = -2.0  # score of a view that no splat reaches: below that of full coverage

_fast = numba.njit(cache=True, nogil=True, fastmath=True)


def fibonacci_sphere(count: int) -> np.ndarray:
    """(count, 3) float32 unit vectors, evenly spread on a spiral."""
    turn = np.arange(count) * np.pi * (3 - np.sqrt(5))
    z = 1 - (2 * np.arange(count) + 1) / count
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1).astype(np.float32)


class _Coverage:
    """Coverage (1 + u . b) / 2 of a splat seen along u, b being the closest direction already seen.

    A pick sees every splat inside its image, hidden or not, along the nearest of 128 directions. A
    view's coverage is its splats', blended, averaged over the pixels that they reach; a view that
    they do not reach comes last.
    """

    def __init__(self, blends: Blends) -> None:
        self.blends = blends
        self.directions = fibonacci_sphere(BINS)
        self.known = np.zeros((blends.splats.shape[1], BINS), np.bool_)
        self.best = np.zeros(len(blends.index), np.float32)
        rotation = blends.poses[:, :, :3]
        self.centers = -np.einsum("vij,vi->vj", rotation, blends.poses[:, :, 3])

    def scores(self) -> np.ndarray:
        blends = self.blends
        total = np.zeros(len(blends.covered))
        filled = np.flatnonzero(np.diff(blends.start))  # empty stretches would break reduceat
        weighted = (blends.weight * self.best).astype(np.float64)
        if len(filled):
            total[filled] = np.add.reduceat(weighted, blends.start[filled])
        mean = total / np.maximum(blends.covered, 1)
        return np.where(blends.covered > 0, -mean, EMPTY)

    def add(self, row: int) -> None:
        blends = self.blends
        held = np.flatnonzero(held_by(blends, row))
        rays = blends.splats[:3, held].T - self.centers[row]
        nearest = np.argmax(rays @ self.directions.T, axis=1)
        first = ~self.known[held, nearest]
        held, nearest = held[first], nearest[first]
        self.known[held, nearest] = True
        new = np.full(len(self.known), -1, np.int32)
        new[held] = nearest
        rest = blends.start, blends.index, self.best
        _raise(blends.splats, self.centers, self.directions, new, *rest)


@_fast
def _raise(splats, centers, directions, new, start, index, best):
    """Raise every entry's coverage to that by a newly seen direction of its splat, if any."""
    for view in range(len(centers)):
        for e in range(start[view], start[view + 1]):
            i = index[e]
            if new[i] < 0:
                continue
            cosine, square = np.float32(0), np.float32(0)
            for a in range(3):
                gap = splats[a, i] - centers[view, a]
                cosine += gap * directions[new[i], a]
                square += gap * gap
            cosine /= max(np.sqrt(square), np.float32(1e-12))
            best[e] = max(best[e], np.float32(0.5) * (np.float32(1) + cosine))


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """See `greedy_on_splats`."""
    return greedy_on_splats(problem, k, _Coverage)


METHOD = Method("cover", "COVER", "observed", nested=True, seeds=1, select=select)
