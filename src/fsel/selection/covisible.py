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
Served = tuple[np.ndarray, ...]
"""`Pairs`, and of each observation its weight, its three best values by picks, and whose."""


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
    return np.sort(_exchanged(pairs, weight, k, taken))


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
def _added(value: float, first: float, second: float) -> float:
    """What a pick adds to an observation that others serve by so much, best first."""
    if value > first:
        return (1 - SECOND) * (value - first) + SECOND * (first - second)
    return SECOND * max(value - second, 0.0)


@plain
def _add(r: int, i: int, served: Served) -> None:
    """Note the three best values of every observation, and whose, with a row as the i-th pick."""
    start, partner, worth, _, best, by = served
    for at in range(start[r], start[r + 1]):
        e, value, place = partner[at], worth[at], 3
        while place > 0 and value > best[e, place - 1]:
            place -= 1
            if place < 2:
                best[e, place + 1], by[e, place + 1] = best[e, place], by[e, place]
        if place < 3:
            best[e, place], by[e, place] = value, i


@plain
def _greedy(
    picks: np.ndarray, picked: np.ndarray, gains: np.ndarray, known: np.ndarray, served: Served
) -> None:
    """Fill the picks one by one by what they add, which falls with every pick (Minoux 1978):
    `gains` are upper bounds, -1 where `picked`, and `known` before which pick they were found."""
    start, partner, worth, weight, best, _ = served
    for i in range(len(picks)):
        r = gains.argmax()
        while known[r] < i:
            gains[r], known[r] = 0.0, i
            for at in range(start[r], start[r + 1]):
                e = partner[at]
                gains[r] += weight[e] * _added(worth[at], best[e, 0], best[e, 1])
            r = gains.argmax()
        picks[i], picked[r], gains[r] = r, True, -1.0
        _add(r, i, served)


@plain
def _exchanges(served: Served, gains: np.ndarray, low: int, high: int) -> None:
    """Fill, for the rows `low` to `high`, what each adds to all picks but each, in one pass as by
    FastPAM (Schubert and Rousseeuw 2021): without a pick, what it served is served by the next."""
    start, partner, worth, weight, best, by = served
    for r in range(low, high):
        all_ = 0.0
        for at in range(start[r], start[r + 1]):
            e, value = partner[at], worth[at]
            first, second, third = best[e, 0], best[e, 1], best[e, 2]
            if value > third:
                beside = weight[e] * _added(value, first, second)
                all_ += beside
                gains[r, by[e, 0]] += weight[e] * _added(value, second, third) - beside
                gains[r, by[e, 1]] += weight[e] * _added(value, first, third) - beside
        for i in range(gains.shape[1]):  # a row as a whole would take 3 s to compile
            gains[r, i] += all_


def _exchanged(pairs: Pairs, weight: np.ndarray, k: int, picked: np.ndarray) -> np.ndarray:
    """(k,) rows: the greedy ones, each exchanged for a better free one as long as there is any."""
    picks, gains = np.empty(k, np.int64), np.empty((len(picked), k + 1))
    best = np.zeros((len(weight), 3), np.float32)
    by = np.full(best.shape, k, np.int32)  # where fewer see it, a column that nobody reads
    served, since = (*pairs, weight, best, by), 0
    _greedy(picks, picked, np.where(picked, -1.0, np.inf), np.full(len(picked), -1), served)
    for at in range(ROUNDS * k):
        if since == at:  # no gains are known of these picks
            gains[:] = 0
            spread(partial(_exchanges, served, gains), ranges(len(gains), FEWEST))
        i = at % k
        free = np.where(picked, -1.0, gains[:, i])
        row = int(free.argmax())
        if free[row] > gains[picks[i], i] * (1 + RISE):
            picked[picks[i]], picked[row] = False, True
            picks[i], since = row, at + 1
            best[:], by[:] = 0, k
            for j in range(k):
                _add(picks[j], j, served)
        elif at - since + 1 >= k:
            break
    return picks
