"""Co-visibility of a pool's frames: by sparse points, or else by the poses alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.core.compiled import exact, exact_part
from fsel.core.geometry import directions, reference_points, viewing_angles
from fsel.core.problem import Problem
from fsel.features.static import MVSNET_ANGLE, MVSNET_SPREAD

PREDICTED = 256  # points at most that stand in for missing ones


@dataclass(frozen=True)
class Tracks:
    """Points and the rows of the pool that see them, each pair once.

    Attributes:
        point_start: (M + 1,) int64, where each point's observations begin.
        row: (L,) int64, the seeing row of each observation, ascending within a point.
        point: (L,) int64, its point.
        bearing: (L, 3) float64 unit directions from the point to the camera.
        row_start: (n + 1,) int64, where each row's part of `seen` begins.
        seen: (L,) int64, observations by row.
    """

    point_start: np.ndarray
    row: np.ndarray
    point: np.ndarray
    bearing: np.ndarray
    row_start: np.ndarray
    seen: np.ndarray

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """Arrays that the kernels below take."""
        return self.point_start, self.row, self.point, self.bearing, self.row_start, self.seen


def tracks(problem: Problem, pool: np.ndarray) -> Tracks:
    """Find the points that frames of a pool, (n,) ascending, see.

    A capture without sparse points gets up to 256 in their place: the reference points of the
    pool's own frames (paper, Appendix A.1), each seen by the frames whose viewing cone holds it.
    """
    points, centers = problem.capture.points, problem.capture.centers[pool]
    place = np.full(len(problem.capture), -1)
    place[pool] = np.arange(len(pool))
    if points is None or len(points.track_point) == 0:
        xyz, point, row = _predicted(problem, pool)
    else:
        xyz, point, row = points.xyz, points.track_point, place[points.track_frame]
    _, order = grouped(row, len(pool))
    order = order[grouped(point[order], len(xyz))[1]]
    point, row = point[order], row[order]
    first = np.append(True, (np.diff(point) != 0) | (np.diff(row) != 0))[: len(point)]
    point, row = point[first], row[first]
    row_start, seen = grouped(row, len(pool))
    return Tracks(
        point_start=np.searchsorted(point, np.arange(len(xyz) + 1)),
        row=row,
        point=point,
        bearing=directions(centers[row], xyz[point]),
        row_start=row_start,
        seen=seen,
    )


def grouped(key, groups):
    """Stable counting sort: (groups + 1,) starts, and places by key; negative keys are dropped."""
    start = np.zeros(groups + 1, np.int64)
    np.cumsum(np.bincount(key[key >= 0], minlength=groups), out=start[1:])
    order = np.empty(start[-1], np.int64)
    _sort(key, start[:-1].copy(), order)
    return start, order


@exact
def _sort(key, place, order):
    for i in range(len(key)):
        if key[i] >= 0:
            order[place[key[i]]] = i
            place[key[i]] += 1


def _predicted(problem: Problem, pool: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(M, 3) points, and (L,) point and row of each pair that sees."""
    capture = problem.capture
    centers, axes = capture.centers[pool], capture.axes[pool]
    centroid = centers.mean(axis=0)
    xyz = reference_points(centers, axes, centroid)
    # thinned evenly by distance from the centroid, which no order of frames changes
    far = np.argsort(np.linalg.norm(xyz - centroid, axis=1), kind="stable")
    count = min(len(xyz), PREDICTED)
    xyz = xyz[far[np.linspace(0, len(xyz) - 1, count).astype(np.int64)]]
    half_fov = capture.views.half_fov[pool]
    seen = [viewing_angles(directions(point, centers), axes) <= half_fov for point in xyz]
    point, row = np.nonzero(np.stack(seen))
    return xyz, point, row


@exact
def shared_points(of, tracks, out):
    """Write into (n,) `out` how many points each row shares with one row; its own are counted."""
    point_start, row, point, _, row_start, seen = tracks
    out[:] = 0
    for e in range(row_start[of], row_start[of + 1]):
        p = point[seen[e]]
        for other in range(point_start[p], point_start[p + 1]):
            out[row[other]] += 1


@exact
def most_shared(tracks):
    """Return the largest number of points that two rows share."""
    n = len(tracks[4]) - 1
    counts = np.empty(n, np.int64)
    most = 0
    for i in range(n):
        shared_points(i, tracks, counts)
        for j in range(n):
            most = max(most, counts[j] if j != i else 0)
    return most


@exact_part
def _score(bearing, first, second):
    """MVSNet's score of one point from two observations (Yao et al. 2018): a Gaussian of the
    triangulation angle in degrees, 1 wide below 5 and 10 above."""
    square = 0.0
    for a in range(3):
        square += (bearing[first, a] - bearing[second, a]) ** 2
    angle = np.degrees(2 * np.arcsin(min(1.0, 0.5 * np.sqrt(square))))
    spread = MVSNET_SPREAD[0] if angle <= MVSNET_ANGLE else MVSNET_SPREAD[1]
    return np.exp(-((angle - MVSNET_ANGLE) ** 2) / (2 * spread**2))


@exact
def scores_with(of, tracks, out):
    """Write into (n,) `out` MVSNet's score of one row with every row; zero with itself."""
    point_start, row, point, bearing, row_start, seen = tracks
    out[:] = 0
    for e in range(row_start[of], row_start[of + 1]):
        own = seen[e]
        for other in range(point_start[point[own]], point_start[point[own] + 1]):
            if other != own:
                out[row[other]] += _score(bearing, own, other)


@exact
def score_rows(rows, tracks):
    """Return (b, n) float32 of (b,) rows what `scores_with` writes of each."""
    out = np.empty((len(rows), len(tracks[4]) - 1), np.float32)
    for b in range(len(rows)):
        scores_with(rows[b], tracks, out[b])
    return out


@exact
def score_sums(tracks):
    """Return (n,) every row's scores with all others, summed; each pair is met once."""
    point_start, row, _, bearing, row_start, _ = tracks
    out = np.zeros(len(row_start) - 1)
    for p in range(len(point_start) - 1):
        for first in range(point_start[p], point_start[p + 1]):
            for second in range(first + 1, point_start[p + 1]):
                score = _score(bearing, first, second)
                out[row[first]] += score
                out[row[second]] += score
    return out
