"""Consistency of the pixels of depth maps in float32: agreement, free-space violations, fusion.

Half of all comparisons are undecided, so the others are listed, and voting runs along the lists.
The loops over pixels hold no branch: they compile to plain vectors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.core.compiled import exact, exact_part
from fsel.core.threads import ranges, spread

F, INT = np.float32, np.int32
U, U32 = np.uint64, np.uint32  # unsigned indices: no wrapping to check

OWN = F(0.2)  # what a pixel's own matching confidence is worth beside a neighbour's agreement
DOUBT = F(0.35)  # opacity is one half where the support equals this and no neighbour disagrees
DEPTH_FLOOR = F(1e-3)
# of verdicts in memory at once: 900 maps at 64x48, 8 neighbours each. More are made anew in
# every round
VERDICT_BYTES = 1 << 28
PAIR_BYTES = 12  # of a pixel and a neighbour, see `Verdicts`


class Verdicts(NamedTuple):
    """Comparison of the n pixels of each of B depth maps with M neighbours.

    Each list holds the pixels that agree first, and from its end those that float in front of what
    the neighbour sees; the entries between are not used. Where pixels agree, `carried` is the
    neighbour's inverse depth carried back along the pixel's ray.
    """

    pixels: np.ndarray  # (B, M, n + 1) uint32, flat
    others: np.ndarray  # (B, M, n + 1) uint32, the neighbour's flat pixels that they fall on
    carried: np.ndarray  # (B, M, n + 1) float32
    bounds: np.ndarray  # (B, M, 2) int64, end of those that agree, start of those that float


def compare(first, inverse, rays, neighbours, rotation, translation, ks, tolerance):
    """Carry every pixel of B depth maps in a row, from the `first` on, into their neighbours and
    compare; see `Maps`, whose neighbours, rotations, translations and tolerances are of the B
    alone.
    """
    shape = (*neighbours.shape, inverse[0].size + 1)
    lists = np.empty(shape, U32), np.empty(shape, U32), np.empty(shape, F)
    verdicts = Verdicts(*lists, np.empty((*neighbours.shape, 2), np.int64))
    given = neighbours, rotation, translation, ks, tolerance
    flat, ray = inverse.reshape(len(inverse), -1), rays.reshape(len(rays), 2, -1)
    _compare(first, flat, ray, *inverse.shape[:0:-1], *given, *verdicts)
    return verdicts


@exact
def _compare(
    first, flat, ray, width, height, neighbours, rotation, translation, ks, tolerance,
    pixels, others, carried, bounds,
):  # fmt: skip
    size = flat.shape[1]
    at, z = np.empty(size, INT), np.empty(size, F)
    theirs, back = np.empty(size, F), np.empty(size, F)
    for i in range(len(neighbours)):
        own, lines = flat[first + i], ray[first + i]
        for m in range(neighbours.shape[1]):
            j = neighbours[i, m]
            _locate(own, lines, rotation[i, m], translation[i, m], ks[j], width, height, at, z)
            for p in range(size):
                theirs[p] = flat[j, U32(max(at[p], INT(0)))]
            listed, paired, brought = pixels[i, m], others[i, m], carried[i, m]
            end, start = _list(own, theirs, at, z, tolerance[i], back, listed)
            for n in range(end):
                paired[n], brought[n] = at[listed[n]], back[listed[n]]
            for n in range(start, size + 1):
                paired[n] = at[listed[n]]
            bounds[i, m, 0], bounds[i, m, 1] = end, start


@exact_part
def _list(own, theirs, at, z, tolerance, back, pixels):
    """Fill the list of one map and neighbour, and what is carried back; return the bounds."""
    agree, floats = np.empty(len(own), np.uint8), np.empty(len(own), np.uint8)
    for p in range(len(own)):
        # inverse depths here and there: camera points are divided by their depth
        gap = own[p] / z[p] - theirs[p]
        back[p] = own[p] - gap * z[p] * z[p]
        agree[p] = (at[p] >= 0) & (abs(gap) <= tolerance)
        floats[p] = (at[p] >= 0) & (gap > tolerance)
    end, last = U(0), U(len(own))
    for p in range(len(own)):
        # always written, kept where it counts; the list is one longer than the pixels, so its ends
        # never meet
        pixels[end] = pixels[last] = p
        end += agree[p]
        last -= floats[p]
    return np.int64(end), np.int64(last) + 1


@exact_part
def _locate(own, ray, rotation, translation, k, width, height, at, z):
    """Fill the flat pixel that each pixel falls on in a neighbour, -1 outside, and its depth, over
    the pixel's own, which may be infinite."""
    fx, fy, cx, cy = k
    a, t = rotation, translation
    limit_x, limit_y = F(width), F(height)
    for p in range(len(own)):
        x, y, q = ray[0, p], ray[1, p], own[p]
        ahead = a[2, 0] * x + a[2, 1] * y + a[2, 2] + t[2] * q
        depth = max(ahead, F(1e-6))
        u = fx * (a[0, 0] * x + a[0, 1] * y + a[0, 2] + t[0] * q) / depth + cx
        v = fy * (a[1, 0] * x + a[1, 1] * y + a[1, 2] + t[1] * q) / depth + cy
        inside = (ahead > F(1e-6)) & (u >= 0) & (v >= 0) & (u < limit_x) & (v < limit_y)
        column = INT(min(max(u, F(0)), limit_x - F(1)))
        row = INT(min(max(v, F(0)), limit_y - F(1)))
        at[p] = row * INT(width) + column if inside else INT(-1)
        z[p] = depth


def vote(first, sure, neighbours, verdicts, against_weight):
    """Return (B, h, w) float32 opacities, 0..1, from the verdicts of neighbours by their certainty.

    `sure` is (K, h, w) float32, matching confidence or the last round's opacity; a free-space
    violation weighs `against_weight` beside an agreement.
    """
    opacity = np.empty((len(neighbours), *sure.shape[1:]), F)
    flat, out = sure.reshape(len(sure), -1), opacity.reshape(len(opacity), -1)
    _vote(first, flat, neighbours, *verdicts, against_weight, out)
    return opacity


@exact
def _vote(first, flat, neighbours, pixels, others, _, bounds, against_weight, opacity):
    size = flat.shape[1]
    support, against = np.empty(size, F), np.empty(size, F)
    for i in range(len(neighbours)):
        for p in range(size):
            support[p], against[p] = OWN * flat[first + i, p], F(0)
        for m in range(neighbours.shape[1]):
            theirs, listed, paired = flat[neighbours[i, m]], pixels[i, m], others[i, m]
            for n in range(bounds[i, m, 0]):
                support[listed[n]] += theirs[paired[n]]
            for n in range(bounds[i, m, 1], size + 1):
                against[listed[n]] += theirs[paired[n]]
        for p in range(size):
            opacity[i, p] = support[p] / (DOUBT + support[p] + against_weight * against[p])


def fuse(first, inverse, opacity, neighbours, verdicts):
    """Return (B, h, w) float32 inverse depths, averaged by (K, h, w) opacity with neighbours that
    agree; see `compare` and `vote`."""
    fused = np.empty((len(neighbours), *inverse.shape[1:]), F)
    flat = [maps.reshape(len(maps), -1) for maps in (inverse, opacity, fused)]
    _fuse(first, *flat, neighbours, *verdicts)
    return fused


@exact
def _fuse(first, own, sure, fused, neighbours, pixels, others, carried, bounds):
    size = own.shape[1]
    weight = np.empty(size, F)
    for i in range(len(neighbours)):
        mean = fused[i]
        for p in range(size):
            weight[p] = sure[first + i, p] + DEPTH_FLOOR
            mean[p] = own[first + i, p] * weight[p]
        for m in range(neighbours.shape[1]):
            theirs, brought = sure[neighbours[i, m]], carried[i, m]
            listed, paired = pixels[i, m], others[i, m]
            for n in range(bounds[i, m, 0]):
                share = theirs[paired[n]] if brought[n] > F(0) else F(0)
                mean[listed[n]] += share * brought[n]
                weight[listed[n]] += share
        for p in range(size):
            mean[p] /= weight[p]


def place(fused, opacity, rays, camera_to_world, images, threshold):
    """Return float32 splats (5, n) of pixels of at least `threshold` opacity, and their colours
    (n, 3), 0..255, of (K, 3, 4) poses and (K, h, w, 3) uint8 images.

    The rows are world x, y, z, opacity, and depth in the source camera.
    """
    count = len(fused)
    frame, pixel = np.nonzero(opacity.reshape(count, -1) >= threshold)
    splats, colors = np.empty((5, len(frame)), F), np.empty((len(frame), 3), F)
    maps = [made.reshape(count, -1) for made in (fused, opacity)]
    rays, images = rays.reshape(count, 2, -1), images.reshape(count, -1, 3)
    poses = np.ascontiguousarray(camera_to_world)
    _place(frame, pixel, *maps, rays, poses, images, splats, colors)
    return splats, colors


@exact
def _place(frame, pixel, inverse, sure, rays, poses, images, splats, colors):
    for n in range(len(frame)):
        i, p = frame[n], pixel[n]
        depth = F(1) / inverse[i, p]
        u, v = rays[i, 0, p] * depth, rays[i, 1, p] * depth
        for a in range(3):
            near = poses[i, a, 0] * u + poses[i, a, 1] * v + poses[i, a, 2] * depth
            splats[a, n] = near + poses[i, a, 3]
            colors[n, a] = images[i, p, a]
        splats[3, n], splats[4, n] = sure[i, p], depth


class Maps(NamedTuple):
    """K depth maps, and how each is carried into the M that it is compared with."""

    inverse: np.ndarray  # (K, h, w) float32 inverse depth
    rays: np.ndarray  # (K, 2, h, w) float32, x/z and y/z of every pixel
    neighbours: np.ndarray  # (K, M) int64 rows
    rotation: np.ndarray  # (K, M, 3, 3) float32, camera to neighbour
    translation: np.ndarray  # (K, M, 3) float32
    ks: np.ndarray  # (K, 4) float32 intrinsics
    tolerance: np.ndarray  # (K,) float32 inverse depth


def agreed(
    maps: Maps, opacity: np.ndarray, rounds: int, against: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return (K, h, w) float32 inverse depths, averaged with those that agree, and opacities, voted
    for in some rounds, from how sure matching is of each pixel, 0..1; see `SplatSettings`.

    Blocks change no bit.
    """
    count, neighbours = maps.neighbours.shape
    each = neighbours * (maps.inverse[0].size + 1) * PAIR_BYTES
    most = max(1, VERDICT_BYTES // each)
    few = max(1, most // len(ranges(count, 1, 1)))
    blocks = [(first, min(first + few, count)) for first in range(0, count, few)]
    rows = ranges(count, 1) if count <= most else blocks

    def compared(first: int, last: int) -> Verdicts:
        own = slice(first, last)
        there = maps.neighbours[own], maps.rotation[own], maps.translation[own]
        given = first, maps.inverse, maps.rays, *there, maps.ks, maps.tolerance[own]
        return compare(*given)

    known = dict(zip(rows, spread(compared, rows), strict=True)) if count <= most else {}

    def voted(first: int, last: int) -> np.ndarray:
        verdicts = known.get((first, last)) or compared(first, last)
        given = maps.neighbours[first:last], verdicts, np.float32(against)
        return vote(first, opacity, *given)

    def fused(first: int, last: int) -> np.ndarray:
        verdicts = known.get((first, last)) or compared(first, last)
        return fuse(first, maps.inverse, opacity, maps.neighbours[first:last], verdicts)

    for _ in range(rounds):
        opacity = np.concatenate(spread(voted, rows))
    return np.concatenate(spread(fused, rows)), opacity
