"""Cover of sparse points by few frames: each seen several times, from different directions.

Not in the paper. Metashape's reduction of overlap is such a cover. Greedy minimum set multicover
takes at most 1 + ln(points of a frame) times the smallest number of frames (Dobson 1982).
"""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import plain
from fsel.selectors.baselines.covisibility import Tracks

ANGLE = np.radians(2)  # between two of the directions that a point is to be seen from
Arrays = tuple[np.ndarray, ...]


def multicover(seen: Tracks, times: int, share: float = 1.0) -> np.ndarray:
    """(m,) int64 rows, most useful first, so that a share of the points is seen `times` times.

    What counts are the points that so many rows see. Two rows or more are to see a point from
    directions two degrees apart, or as far apart as any two rows do. A row that widens the
    directions of a point counts as much of a sighting as it brings them nearer to that.
    """
    counted = wanted(seen, times)
    enough = int(np.ceil(share * counted.sum()))
    least = _widest(seen.arrays) if times > 1 else np.zeros(len(seen.point_start) - 1)
    return _greedy(seen.arrays, counted, least, times, enough)


def wanted(seen: Tracks, times: int) -> np.ndarray:
    """(M,) bool: points that at least so many rows see."""
    return np.diff(seen.point_start) >= times


def sightings(seen: Tracks, rows: np.ndarray) -> np.ndarray:
    """(M,) int64 how many of some rows see each point."""
    chosen = np.zeros(len(seen.row_start) - 1, dtype=bool)
    chosen[rows] = True
    return np.bincount(seen.point[chosen[seen.row]], minlength=len(seen.point_start) - 1)


@plain
def _apart(bearing: np.ndarray, a: int, b: int) -> float:
    """Radians between two directions."""
    square = 0.0
    for i in range(3):
        square += (bearing[a, i] - bearing[b, i]) ** 2
    return 2 * np.arcsin(min(1.0, 0.5 * np.sqrt(square)))


@plain
def _widest(arrays: Arrays) -> np.ndarray:
    """(M,) the largest angle between two directions of each point, two degrees at most."""
    start, _, _, bearing, _, _ = arrays
    widest = np.zeros(len(start) - 1)
    for p in range(len(widest)):
        for a in range(start[p], start[p + 1]):
            for b in range(start[p], a):
                if widest[p] < ANGLE:
                    widest[p] = min(ANGLE, max(widest[p], _apart(bearing, a, b)))
    return widest


@plain
def _widened(arrays: Arrays, own: int, picked: np.ndarray, width: float) -> float:
    """The widest angle of a point's picked directions with one more, two degrees at most."""
    start, row, point, bearing, _, _ = arrays
    p = point[own]
    for other in range(start[p], start[p + 1]):
        if picked[row[other]] and width < ANGLE:
            width = min(ANGLE, max(width, _apart(bearing, own, other)))
    return width


@plain
def _greedy(
    arrays: Arrays, counted: np.ndarray, least: np.ndarray, times: int, enough: int
) -> np.ndarray:
    """The row that adds most, the lowest of equals, until none adds anything, or, of a share of the
    points, enough of them are seen so often."""
    _, _, point, _, row_start, seen = arrays
    n = len(row_start) - 1
    picked, rows = np.zeros(n, np.bool_), np.empty(n, np.int64)
    count, width = np.zeros(len(counted), np.int64), np.zeros(len(counted))
    served, total = 0, counted.sum()
    for step in range(n):
        most, best = 0.0, -1
        for r in range(n):
            gain = 0.0
            if not picked[r]:
                for at in range(row_start[r], row_start[r + 1]):
                    p = point[seen[at]]
                    if counted[p]:
                        gain += 1.0 if count[p] < times else 0.0
                        if count[p] > 0 and width[p] < least[p]:
                            wider = _widened(arrays, seen[at], picked, width[p])
                            gain += (min(wider, least[p]) - width[p]) / least[p]
            if gain > most:
                most, best = gain, r
        if best < 0 or (enough < total and served >= enough):
            return rows[:step]
        for at in range(row_start[best], row_start[best + 1]):
            p = point[seen[at]]
            count[p] += 1
            if counted[p] and count[p] == times:
                served += 1
            width[p] = _widened(arrays, seen[at], picked, width[p])
        picked[best], rows[step] = True, best
    return rows
