"""The best N sharp and well spread frames (sharp-frames 0.4, `selection_methods.py`)."""

from __future__ import annotations

import numpy as np

from fsel.core.problem import Method, Problem

GAP = 4  # frames from one pick to the next at least, where so many leave room
SHARPNESS, POSITION = 0.7, 0.3  # shares of the score


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick from each of k equal stretches of the pool the frame of the best score.

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


METHOD = Method(
    "best_n", "Sharp-frames best-N", "observed", nested=False, select=select, reads=("sharpness",)
)
