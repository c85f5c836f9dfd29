"""Consistency of the pixels of depth maps in float32: agreement, free-space violations, fusion.

Half of all comparisons are undecided, so the others are listed, and voting runs along the lists.
The loops over pixels hold no branch: they compile to plain vectors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.core.compiled import exact

F, INT = np.float32, np.int32
U, U32 = np.uint64, np.uint32  # unsigned indices: no wrapping to check

OWN = F(0.2)  # what a pixel's own matching confidence is worth beside a neighbour's agreement
DOUBT = F(0.35)  # opacity is one half where the support equals this and no neighbour disagrees
DEPTH_FLOOR = F(1e-3)


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


@exact
def compare(first, inverse, rays, neighbours, rotation, translation, ks, tolerance):
    """Carry every pixel of B depth maps in a row, from the `first` on, into their neighbours and
    compare; see `fsel.reconstruct.splats.consistency.Maps`, whose neighbours, rotations,
    translations and tolerances are of the B alone.
    """
    maps, height, width = inverse.shape
    (count, each), size = neighbours.shape, height * width
    pixels = np.empty((count, each, size + 1), U32)
    others, carried = np.empty_like(pixels), np.empty(pixels.shape, F)
    bounds = np.empty((count, each, 2), np.int64)
    flat, ray = inverse.reshape(maps, size), rays.reshape(maps, 2, size)
    at, z = np.empty(size, INT), np.empty(size, F)
    theirs, back = np.empty(size, F), np.empty(size, F)
    for i in range(count):
        own, lines = flat[first + i], ray[first + i]
        for m in range(each):
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
    return Verdicts(pixels, others, carried, bounds)


@exact
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


@exact
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


@exact
def vote(first, sure, neighbours, verdicts, against_weight):
    """Return (B, h, w) float32 opacities, 0..1, from the verdicts of neighbours by their certainty.

    `sure` is (K, h, w) float32, matching confidence or the last round's opacity; a free-space
    violation weighs `against_weight` beside an agreement.
    """
    maps, height, width = sure.shape
    count, size = len(neighbours), height * width
    flat = sure.reshape(maps, size)
    opacity = np.empty((count, size), F)
    support, against = np.empty(size, F), np.empty(size, F)
    for i in range(count):
        for p in range(size):
            support[p], against[p] = OWN * flat[first + i, p], F(0)
        for m in range(neighbours.shape[1]):
            theirs = flat[neighbours[i, m]]
            pixels, others = verdicts.pixels[i, m], verdicts.others[i, m]
            for n in range(verdicts.bounds[i, m, 0]):
                support[pixels[n]] += theirs[others[n]]
            for n in range(verdicts.bounds[i, m, 1], size + 1):
                against[pixels[n]] += theirs[others[n]]
        for p in range(size):
            opacity[i, p] = support[p] / (DOUBT + support[p] + against_weight * against[p])
    return opacity.reshape(count, height, width)


@exact
def fuse(first, inverse, opacity, neighbours, verdicts):
    """Return (B, h, w) float32 inverse depths, averaged by (K, h, w) opacity with neighbours that
    agree; see `compare` and `vote`."""
    maps, height, width = inverse.shape
    count, size = len(neighbours), height * width
    own, sure = inverse.reshape(maps, size), opacity.reshape(maps, size)
    fused = np.empty((count, size), F)
    weight = np.empty(size, F)
    for i in range(count):
        mean = fused[i]
        for p in range(size):
            weight[p] = sure[first + i, p] + DEPTH_FLOOR
            mean[p] = own[first + i, p] * weight[p]
        for m in range(neighbours.shape[1]):
            theirs, carried = sure[neighbours[i, m]], verdicts.carried[i, m]
            pixels, others = verdicts.pixels[i, m], verdicts.others[i, m]
            for n in range(verdicts.bounds[i, m, 0]):
                share = theirs[others[n]] if carried[n] > F(0) else F(0)
                mean[pixels[n]] += share * carried[n]
                weight[pixels[n]] += share
        for p in range(size):
            mean[p] /= weight[p]
    return fused.reshape(count, height, width)


@exact
def place(fused, opacity, rays, camera_to_world, images, threshold):
    """Return float32 splats (5, n) of pixels of at least `threshold` opacity, and their colours
    (n, 3), 0..255, of (K, 3, 4) poses and (K, h, w, 3) uint8 images.

    The rows are world x, y, z, opacity, and depth in the source camera.
    """
    count, height, width = fused.shape
    size = height * width
    inverse, sure = fused.reshape(count, size), opacity.reshape(count, size)
    kept, end = np.empty(count * size + 1, U32), 0
    ends = np.zeros(count + 1, np.int64)
    for i in range(count):
        for p in range(size):
            kept[end] = p
            end += sure[i, p] >= threshold
        ends[i + 1] = end
    splats, colors = np.empty((5, end), F), np.empty((end, 3), F)
    for i in range(count):
        pose, image = camera_to_world[i], images[i].reshape(size, 3)
        x, y = rays[i, 0].reshape(size), rays[i, 1].reshape(size)
        for n in range(ends[i], ends[i + 1]):
            p = kept[n]
            depth = F(1) / inverse[i, p]
            u, v = x[p] * depth, y[p] * depth
            for a in range(3):
                splats[a, n] = pose[a, 0] * u + pose[a, 1] * v + pose[a, 2] * depth + pose[a, 3]
                colors[n, a] = image[p, a]
            splats[3, n], splats[4, n] = sure[i, p], depth
    return splats, colors
