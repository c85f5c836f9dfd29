"""Picks that see what every frame sees, from directions near the frame's own.

Not in the paper. A pick serves a frame to the degree that it sees the sparse points that the frame
sees, at small angles. The best pick of each observation counts 0.7 and the second best 0.3, so that
stereo partners are worth something. Picks are made greedily and then exchanged one by one while
that helps.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from fsel.core.compiled import plain
from fsel.core.problem import Problem
from fsel.core.threads import ranges, spread
from fsel.selectors.baselines.covisibility import Tracks, tracks

FOLD = np.radians(15)  # between directions to a point: a pick's worth falls to 1/e over it
SECOND = 0.3  # share of the second best pick
PAIRS = 4_000_000  # of observations of one point, at most: 32 MB
FEWEST = 16  # rows of a range
ROUNDS = 4  # over all picks, each of which may be exchanged
RISE = 1e-6  # share by which an exchange must raise the value: sums are not more exact

Pairs = tuple[np.ndarray, np.ndarray, np.ndarray]
"""What `_pairs` returns."""


def covisible(
    problem: Problem, pool: np.ndarray, k: int, targets: np.ndarray | None = None
) -> np.ndarray:
    """(k,) ascending rows of a pool, (n,) ascending frames, that serve the frames of the pool best.

    `targets`, (n,) bool, are frames that are served and not picked; None where all are both.
    """
    seen = tracks(problem, pool)
    pairs = _pairs(seen.arrays, _kept(seen), FOLD)
    # the observations that are kept count one together for each frame
    weight, kept = np.zeros(len(seen.row)), np.unique(pairs[1])
    weight[kept] = 1 / np.bincount(seen.row[kept], minlength=len(pool))[seen.row[kept]]
    taken = np.zeros(len(pool), bool)
    if targets is not None:
        weight, taken = weight * targets[seen.row], targets.copy()
    return np.sort(_exchanged(pairs, weight, k, ROUNDS, taken))


def _kept(seen: Tracks) -> np.ndarray:
    """(M,) bool: points of which all pairs of observations are few enough, drawn always alike."""
    squares = np.diff(seen.point_start) ** 2
    order = np.random.default_rng(0).permutation(len(squares))
    kept = np.zeros(len(squares), dtype=bool)
    kept[order[np.cumsum(squares[order]) <= PAIRS]] = True
    return kept


@plain
def _pairs(arrays: tuple[np.ndarray, ...], kept: np.ndarray, fold: float) -> Pairs:
    """List for each row the observations of the points it sees, its own too, and its worths.

    Return (n + 1,) starts of the rows' parts, (P,) int32 observations, (P,) float32 worths.
    """
    point_start, _, point, bearing, row_start, seen = arrays
    n = len(row_start) - 1
    start = np.zeros(n + 1, np.int64)
    for r in range(n):
        start[r + 1] = start[r]
        for at in range(row_start[r], row_start[r + 1]):
            p = point[seen[at]]
            if kept[p]:
                start[r + 1] += point_start[p + 1] - point_start[p]
    partner, worth = np.empty(start[n], np.int32), np.empty(start[n], np.float32)
    for r in range(n):
        to = start[r]
        for at in range(row_start[r], row_start[r + 1]):
            own = seen[at]
            p = point[own]
            if not kept[p]:
                continue
            for other in range(point_start[p], point_start[p + 1]):
                square = 0.0
                for a in range(3):
                    square += (bearing[own, a] - bearing[other, a]) ** 2
                angle = 2 * np.arcsin(min(1.0, 0.5 * np.sqrt(square)))
                partner[to], worth[to] = other, np.exp(-angle / fold)
                to += 1
    return start, partner, worth


@plain
def _gain(r: int, pairs: Pairs, weight: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """Value that a row adds to that of the picks, which serve each observation as noted."""
    start, partner, worth = pairs
    total = 0.0
    for at in range(start[r], start[r + 1]):
        e, value = partner[at], worth[at]
        if value > first[e]:
            total += weight[e] * (
                (1 - SECOND) * (value - first[e]) + SECOND * (first[e] - second[e])
            )
        elif value > second[e]:
            total += weight[e] * SECOND * (value - second[e])
    return total


@plain
def _add(r: int, pairs: Pairs, first: np.ndarray, second: np.ndarray) -> None:
    """Note the best and second best value of every observation with one pick more."""
    start, partner, worth = pairs
    for at in range(start[r], start[r + 1]):
        e, value = partner[at], worth[at]
        if value > first[e]:
            second[e], first[e] = first[e], value
        elif value > second[e]:
            second[e] = value


@plain
def _gains(
    picked: np.ndarray,
    pairs: Pairs,
    weight: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    gains: np.ndarray,
    low: int,
    high: int,
) -> None:
    """Fill what the rows `low` to `high` add, less than nothing where they are picked."""
    for r in range(low, high):
        gains[r] = -1.0 if picked[r] else _gain(r, pairs, weight, first, second)


@plain
def _others(picks: np.ndarray, i: int, pairs: Pairs, first: np.ndarray, second: np.ndarray) -> None:
    """Note the values of every observation by all picks but one."""
    first[:] = 0
    second[:] = 0
    for j in range(len(picks)):
        if j != i:
            _add(picks[j], pairs, first, second)


def _exchanged(
    pairs: Pairs, weight: np.ndarray, k: int, rounds: int, picked: np.ndarray
) -> np.ndarray:
    """(k,) rows: the greedy ones, each exchanged for a better free one as long as there is any."""
    picks, gains = np.empty(k, np.int64), np.empty(len(picked))
    first, second = np.zeros((2, len(weight)), np.float32)
    fill = partial(_gains, picked, pairs, weight, first, second, gains)
    for i in range(k):
        spread(fill, ranges(len(gains), FEWEST))
        picks[i] = gains.argmax()
        picked[picks[i]] = True
        _add(picks[i], pairs, first, second)
    for _ in range(rounds):
        before = picks.copy()
        for i in range(k):
            _others(picks, i, pairs, first, second)
            own = _gain(picks[i], pairs, weight, first, second)
            spread(fill, ranges(len(gains), FEWEST))
            best = int(gains.argmax())
            if gains[best] > own * (1 + RISE):
                picked[picks[i]], picked[best] = False, True
                picks[i] = best
        if (picks == before).all():
            break
    return picks
