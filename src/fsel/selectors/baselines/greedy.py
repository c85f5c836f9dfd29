"""Greedy maximisation that recomputes a gain only where it could change the pick."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fsel.core.compiled import exact
from fsel.core.geometry import centered

TIE = 1e-5  # gains closer than this share are equal: sums of float32 values are not more exact
BLOCK = 256  # rows whose values are in memory at a time


def lazy_greedy(
    bounds: np.ndarray,
    gains: Callable[[np.ndarray], np.ndarray],
    add: Callable[[int], None],
    k: int,
) -> np.ndarray:
    """Pick the row of the largest gain, k times.

    Gains must never grow as picks are added (Minoux 1978): an old gain then bounds the new one,
    and a row whose fresh gain is above every bound is the best. Within a step the most promising
    gains are computed in batches of 1, 2, 4, ...

    Args:
        bounds: (n,) no less than every row's gain before the first pick.
        gains: rows -> their gains now, none negative.
        add: called with each pick, before the next gain is computed.
    """
    bounds = bounds.astype(np.float64)
    fresh = np.zeros(len(bounds), dtype=bool)
    picks = np.empty(k, dtype=np.int64)
    for step in range(k):
        size = 1
        while True:
            best = np.flatnonzero(bounds >= bounds.max() * (1 - TIE))
            if fresh[best].all():
                break
            promising = np.argpartition(-bounds, size - 1)[:size]
            stale = np.union1d(best, promising)
            stale = stale[~fresh[stale]]
            bounds[stale], fresh[stale] = gains(stale), True
            size = min(2 * size, len(bounds))
        picks[step] = best[0]
        add(int(best[0]))
        bounds[best[0]] = -np.inf
        fresh[:] = False
        fresh[picks[: step + 1]] = True
    return picks


def locate(values: Callable[[np.ndarray], np.ndarray], bounds: np.ndarray, k: int) -> np.ndarray:
    """Locate facilities greedily: the rows S that raise sum_i max_{j in S} values(j)[i] most.

    Args:
        values: (b,) rows -> (b, n) float32, none negative; computed in blocks, never all at once.
        bounds: (n,) no less than the sum of every row's values; infinity will do.
        k: at most n.
    """
    served = np.zeros(len(bounds), np.float32)

    def gains(rows: np.ndarray) -> np.ndarray:
        blocks = [rows[i : i + BLOCK] for i in range(0, len(rows), BLOCK)]
        return np.concatenate([_gained(values(block), served) for block in blocks])

    def add(row: int) -> None:
        np.maximum(served, values(np.array([row]))[0], out=served)

    return lazy_greedy(bounds, gains, add, k)


@exact
def _gained(values, served):
    """(b,) sums of what (b, n) values add to the best so far."""
    total = np.zeros(len(values))
    for b in range(len(values)):
        for i in range(len(served)):
            total[b] += max(values[b, i] - served[i], np.float32(0))
    return total


def most_central(points: np.ndarray) -> int:
    """Return the row of the (n, d) point nearest to the mean of all."""
    return int(np.argmin(np.linalg.norm(centered(points), axis=1)))
