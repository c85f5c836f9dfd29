"""Methods by splats of the picks so far: FisherRF, COVER, and WarpRF."""

from __future__ import annotations

import numpy as np

from fsel.core.capture import Capture
from fsel.core.compiled import exact
from fsel.core.geometry import camera_centers, pixel_rays
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.splat_views import Blends, fitted, greedily, inside, reconstructed

DAMPING = 1e-6  # the released default of lambda
BINS = 128  # directions on the sphere
GROWTH = 0.25  # of the picks, by which they are reconstructed anew
EMPTY = -2.0  # score of a view that no splat reaches: below that of full coverage


class Information:
    """Criterion trace(H(view) (H(picks) + lambda I)^-1) with diagonal H, exact for colours.

    A pixel is linear in the colour of a splat, with its blending weight as the slope: the diagonal
    is the sum of squared weights over pixels.
    """

    def __init__(self, blends: Blends, damping: float = DAMPING) -> None:
        self.blends = blends
        self.known = np.full(blends.splats.shape[1], damping)

    def scores(self) -> np.ndarray:
        blends = self.blends
        return _information(blends.start, blends.index, blends.square, 1 / self.known)

    def add(self, row: int) -> None:
        part = slice(*self.blends.start[row : row + 2])
        self.known[self.blends.index[part]] += self.blends.square[part]


@exact
def _information(start, index, square, per_known):
    """(V,) sums of a view's squares, each divided by what is known of its splat."""
    total = np.zeros(len(start) - 1)
    for view in range(len(total)):
        for e in range(start[view], start[view + 1]):
            total[view] += square[e] * per_known[index[e]]
    return total


def fisher_rf(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick (k,) int64 frames of the pool, each the one of largest information gain: the view that
    tells most about the splats' colours (FisherRF, Jiang, Lei and Daniilidis 2024)."""
    return greedily(problem, k, lambda *seen: Information(fitted(*seen, sparse=True)))


def fibonacci_sphere(count: int) -> np.ndarray:
    """Return (count, 3) float32 unit vectors, evenly spread on a spiral."""
    turn = np.arange(count) * np.pi * (3 - np.sqrt(5))
    z = 1 - (2 * np.arange(count) + 1) / count
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1).astype(np.float32)


class Coverage:
    """Coverage (1 + u . b) / 2 of a splat seen along u, b being the closest direction already seen.

    A pick sees every splat inside its image, hidden or not, along the nearest of 128 directions. A
    view's coverage is its splats', blended, averaged over the pixels that they reach.
    """

    def __init__(self, blends: Blends) -> None:
        self.blends = blends
        self.directions = fibonacci_sphere(BINS)
        self.known = np.zeros((blends.splats.shape[1], BINS), np.bool_)
        self.centers = camera_centers(blends.poses)
        self.best = np.zeros(len(blends.index), np.float32)

    def scores(self) -> np.ndarray:
        covered = self.blends.covered
        total = _summed(self.blends.start, self.blends.weight, self.best)
        return np.where(covered > 0, -total / np.maximum(covered, 1), EMPTY)

    def add(self, row: int) -> None:
        blends = self.blends
        seen = np.flatnonzero(inside(blends, row))
        rays = blends.splats[:3, seen] - self.centers[row][:, None]
        nearest = _nearest(rays, self.directions)
        first = ~self.known[seen, nearest]
        seen, nearest = seen[first], nearest[first]
        self.known[seen, nearest] = True
        new = np.full(len(self.known), -1, np.int16)
        new[seen] = nearest
        entries = blends.start, blends.index, self.best
        _raise(new, self.directions, blends.splats, self.centers, *entries)


@exact
def _summed(start, weight, best):
    """(V,) sums over each view's entries."""
    total = np.zeros(len(start) - 1)
    for view in range(len(total)):
        for e in range(start[view], start[view + 1]):
            total[view] += weight[e] * best[e]
    return total


@exact
def _nearest(rays, directions):
    """(n,) the direction of largest cosine with each of (3, n) rays; rays inside: it vectorises."""
    n = rays.shape[1]
    out, most = np.zeros(n, np.int32), np.full(n, np.float32(-1e30))
    for g in range(len(directions)):
        x, y, z = directions[g]
        for i in range(n):
            value = rays[0, i] * x + rays[1, i] * y + rays[2, i] * z
            closer = value > most[i]
            most[i] = value if closer else most[i]
            out[i] = g if closer else out[i]
    return out


@exact
def _raise(new, directions, splats, centers, start, index, best):
    """Raise the coverage of splats' entries to that by a `new` direction of each, -1 for none."""
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


def cover(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick (k,) int64 frames of the pool, each the least covered view by the picks so far: the one
    whose splats have been seen least from its side (COVER, Chen et al. 2026)."""
    return greedily(problem, k, lambda *seen: Coverage(fitted(*seen)), GROWTH)


class Inconsistency:
    """Criterion: at each pixel the least difference from the warped renderings, summed."""

    def __init__(self, capture: Capture, pool: np.ndarray, rows: np.ndarray) -> None:
        model, views = reconstructed(capture, pool, rows)
        self.images, self.cameras = model.render(views), views.intrinsics
        self.poses = model.frame.local_poses(views.world_to_camera)
        self.points = np.empty(self.images.shape)  # that the pixels show
        depth = self.poses[:, 2, :3] @ model.splats[:3] + self.poses[:, 2, 3:]
        most = depth.max(initial=1e-9)
        shown = most * model.painted(views, lambda z: np.maximum(z, 0) / most)[..., None]
        for at, (pose, k) in enumerate(zip(self.poses, self.cameras, strict=True)):
            self.points[at] = (pixel_rays(k, *views.size) * shown[at] - pose[:, 3]) @ pose[:, :3]
        self.least = np.full(self.images.shape[:3], np.inf)

    def scores(self) -> np.ndarray:
        return self.least.sum(axis=(1, 2))

    def add(self, row: int) -> None:
        from scipy.ndimage import map_coordinates  # here: the others do without, and it is slow

        pose, k = self.poses[row], self.cameras[row]
        seen = np.einsum("vhwb,ab->vhwa", self.points, pose[:, :3]) + pose[:, 3]
        pixel = seen[..., :2] / np.maximum(seen[..., 2:], 1e-9) * k[:2] + k[2:] - 0.5
        where = np.broadcast_arrays(pixel[..., 1:], pixel[..., :1], np.arange(3.0))
        warped = map_coordinates(self.images[row], where, order=1, mode="nearest")  # at the border
        np.minimum(self.least, np.abs(warped - self.images).sum(axis=-1), out=self.least)


def warp_rf(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick (k,) int64 frames of the pool, each the view that the picks' renderings, warped into it,
    explain least (WarpRF, 2506.22433)."""
    return greedily(problem, k, Inconsistency)


FISHER_RF = Method(
    "fisher_rf", "FisherRF", "observed", nested=True, select=fisher_rf, tracks=True, begins=True
)
COVER = Method("cover", "COVER", "observed", nested=True, select=cover, tracks=True, begins=True)
WARP_RF = Method(
    "warp_rf", "WarpRF", "observed", nested=True, select=warp_rf, tracks=True, begins=True
)
