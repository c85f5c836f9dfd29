"""Splats fitted to the picks so far, and how much of every frame's view each of them fills."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.compiled import exact, exact_part
from fsel.core.geometry import centered, farthest_views, pose_matrices
from fsel.core.problem import Problem
from fsel.reconstruct.splats import SplatModel, Splats
from fsel.selectors.baselines.covisibility import grouped
from fsel.selectors.baselines.greedy import most_central

FIT_SIDE = 32  # pixels of the longer side, of fitted images and of views
OPACITY = 0.1  # of sparse points, as Gaussians begin with (Kerbl et al. 2023)
START = 4  # farthest views before the first reconstruction, as in FisherRF's schedule
FAINT = np.float32(1e-2)  # of a pixel: splats that fill less of a view are left out
MANTISSA = 13  # bits of a depth that are dropped to order splats: steps of a thousandth remain


@dataclass(frozen=True)
class Blends:
    """Splats and the views that they fill; entries of a view lie together.

    Attributes:
        splats: (4, n) float32: rows of x, y, z and opacity, in the first pick's camera and in units
            of the cameras' radius.
        poses: (V, 3, 4) float32 world to camera, of that world.
        intrinsics: (V, 4) float32 pixels.
        size: (width, height) pixels.
        start: (V + 1,) int64, where each view's entries begin.
        index: (L,) int32, the splat of each entry.
        weight: (L,) float32, its blending weights a T summed over pixels.
        square: (L,) float32, the sum of their squares.
        covered: (V,) int64 pixels that any splat reaches.
    """

    splats: np.ndarray
    poses: np.ndarray
    intrinsics: np.ndarray
    size: tuple[int, int]
    start: np.ndarray
    index: np.ndarray
    weight: np.ndarray
    square: np.ndarray
    covered: np.ndarray


class Criterion(Protocol):
    """The value of a further view, given the picks."""

    def scores(self) -> np.ndarray:
        """Return (V,) of every view; the largest is picked."""

    def add(self, row: int) -> None:
        """Count a view as picked."""


def reconstructed(capture: Capture, pool: np.ndarray, rows: np.ndarray) -> tuple[SplatModel, Views]:
    """Fit splats to some rows of a (V,) pool, and return them with the views of the whole pool."""
    picked = capture.subset(pool[rows]).resized(FIT_SIDE)
    intrinsics = capture.intrinsics[pool] * np.tile(np.divide(picked.size, capture.size), 2)
    views = Views(capture.world_to_camera[pool], intrinsics, picked.size)
    return Splats(picked).fit(np.arange(len(rows))), views


def fitted(capture: Capture, pool: np.ndarray, rows: np.ndarray, *, sparse: bool = False) -> Blends:
    """Fit splats to some rows of a (V,) pool, and blend them into the views of the whole pool.

    `sparse` adds the capture's points that the pool sees: they lie where no pick looks, too.
    """
    model, views = reconstructed(capture, pool, rows)
    splats = np.vstack([model.positions.T, model.splats[3]])
    points = capture.points
    if sparse and points is not None:
        shown = np.unique(points.seen_from(pool, len(capture)).track_point)
        faint = np.full((1, len(shown)), OPACITY)
        splats = np.hstack([splats, np.vstack([points.xyz[shown].T, faint])])
    splats = splats.astype(np.float32)
    poses = views.world_to_camera.astype(np.float32)
    intrinsics = views.intrinsics.astype(np.float32)
    filled = blend(splats, poses, intrinsics, *views.size)
    return Blends(splats, poses, intrinsics, views.size, *filled)


def greedily(
    problem: Problem,
    k: int,
    criterion: Callable[[Capture, np.ndarray, np.ndarray], Criterion],
    growth: float = 1.0,
) -> np.ndarray:
    """Pick views one by one; the splats are fitted anew whenever the picks have grown by a share.

    Starts with farthest views from the most central camera; or with `Problem.fixed_picks`, and then
    fits after every pick, as FisherRF's protocol does. Only images of picked frames are read. For
    every fit a criterion is made of the capture, the pool and the rows, and given all picks so far.
    """
    pool = problem.observed
    centers = problem.capture.centers[pool]
    given = np.searchsorted(pool, problem.fixed_picks)
    start, count = (given, max(len(given), 2)) if len(given) else (most_central(centers), START)
    rows = farthest_views(np.arange(len(pool)), centers, min(k, count), start).tolist()
    capture = _canonical(problem.capture, pool, pool[rows[0]])
    while len(rows) < k:
        worth = criterion(capture, pool, np.array(rows))
        for row in rows:
            worth.add(row)
        more = 1 if len(given) else max(int(growth * len(rows)), 1)
        for _ in range(min(k - len(rows), more)):
            scores = worth.scores()
            scores[rows] = -np.inf
            rows.append(int(np.argmax(scores)))
            worth.add(rows[-1])
    return pool[rows]


def _canonical(capture: Capture, pool: np.ndarray, origin: int) -> Capture:
    """The same capture in one camera's frame and in units of the radius of a pool's cameras: the
    world's own have no effect, not even by rounding to float32."""
    centers, base = capture.centers[pool], capture.world_to_camera[origin]
    radius = np.linalg.norm(centered(centers), axis=1).max()
    unit = radius if radius > 0 else 1.0
    turned = capture.world_to_camera[:, :, :3] @ base[:, :3].T
    shift = (capture.world_to_camera[:, :, 3] - turned @ base[:, 3]) / unit
    points = capture.points
    if points is not None:
        points = replace(points, xyz=(points.xyz @ base[:, :3].T + base[:, 3]) / unit)
    return replace(capture, world_to_camera=pose_matrices(turned, shift), points=points)


def inside(blends: Blends, row: int) -> np.ndarray:
    """Return (n,) whether each splat lies within a view's image, hidden or not."""
    across, down, key = _room(blends.splats.shape[1])
    k = blends.intrinsics[row]
    _project(blends.splats, blends.poses[row], k, *blends.size, across, down, key)
    return key >= 0


def blend(
    splats: np.ndarray, poses: np.ndarray, intrinsics: np.ndarray, width: int, height: int
) -> tuple[np.ndarray, ...]:
    """Alpha-blend splats into views, front to back, each over 2x2 pixels bilinearly.

    Arguments, and the start, index, weight, square and covered that are returned: see `Blends`.
    """
    n, views = splats.shape[1], len(poses)
    across, down, key = _room(n)
    index, weight, square = np.empty(n, np.int32), *np.empty((2, n), np.float32)
    counts, covered = np.empty((2, views), np.int64)
    entries: list[list[np.ndarray]] = [[], [], []]
    for view in range(views):
        _project(splats, poses[view], intrinsics[view], width, height, across, down, key)
        clear, seen = np.ones((height, width), np.float32), key >= 0
        least, most = (key[seen].min(), key.max()) if seen.any() else (0, -1)
        _, order = grouped(np.where(seen, key - least, -1), most - least + 1)
        count = _blend(order, splats[3], across, down, clear, index, weight, square)
        counts[view], covered[view] = count, (clear < 1).sum()
        for part, values in zip(entries, (index, weight, square), strict=True):
            part.append(values[:count].copy())
    start = np.append(0, np.cumsum(counts))
    # one after the other: the parts of an array go when it is whole
    return start, *(np.concatenate(entries.pop(0)) for _ in range(3)), covered


def _room(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Arrays that `_project` writes n pixel coordinates and keys to."""
    return np.empty(n, np.float32), np.empty(n, np.float32), np.empty(n, np.int64)


@exact
def _project(splats, pose, k, width, height, across, down, key):
    """Write pixel coordinates less one half, and keys that grow with depth; -1 out of the view.

    Positive float32 numbers are ordered as their bits are: the leading ones are the key.
    """
    n = splats.shape[1]
    depth = np.empty(n, np.float32)
    for i in range(n):
        x, y, z = splats[0, i], splats[1, i], splats[2, i]
        depth[i] = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
        w = np.float32(1) / max(depth[i], np.float32(1e-9))
        u = k[0] * (pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3])
        v = k[1] * (pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3])
        across[i] = u * w + k[2] - np.float32(0.5)
        down[i] = v * w + k[3] - np.float32(0.5)
    bits = depth.view(np.int32)
    for i in range(n):
        inside = (across[i] >= -0.5) & (across[i] < width - 0.5)
        inside &= (down[i] >= -0.5) & (down[i] < height - 0.5)
        key[i] = bits[i] >> MANTISSA if inside & (depth[i] > 0) else -1


@exact
def _blend(order, opacity, across, down, clear, index, weight, square):
    """Write the entries of one view, front to back, and the light that passes; count them."""
    count = 0
    for i in order:
        total, squares = _fill(clear, across[i], down[i], opacity[i])
        if total > FAINT:
            index[count], weight[count], square[count] = i, total, squares
            count += 1
    return count


@exact_part
def _fill(clear, across, down, opacity):
    """Blend one splat into the light that still passes; sum its weights and their squares."""
    height, width = clear.shape
    left, top = int(np.floor(across)), int(np.floor(down))
    fu, fv = across - np.float32(left), down - np.float32(top)
    total, square = np.float32(0), np.float32(0)
    for y in range(max(top, 0), min(top + 2, height)):
        row = opacity * (fv if y > top else np.float32(1) - fv)
        for x in range(max(left, 0), min(left + 2, width)):
            alpha = row * (fu if x > left else np.float32(1) - fu)
            part = alpha * clear[y, x]
            clear[y, x] -= part
            total += part
            square += part * part
    return total, square
