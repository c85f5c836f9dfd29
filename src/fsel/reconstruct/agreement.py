"""Which pixels of which depth maps to believe: agreement, free-space violations, fusion.

float32 throughout: depths are compared to a plane's spacing, a thousand times their rounding.
The loops over pixels hold no branch, so that they compile to gathers and masked arithmetic.
"""

from __future__ import annotations

import numba
import numpy as np

F, INT = np.float32, np.int32
_jit = numba.njit(cache=True, fastmath=True, nogil=True)

OWN = F(0.2)  # what a pixel's own matching confidence is worth beside a neighbour's agreement
DOUBT = F(0.35)  # opacity is one half where the support equals this and nothing speaks against
DEPTH_FLOOR = F(1e-3)


@_jit
def compare(inverse, rays, neighbours, rotation, translation, ks, tolerance):
    """Carry every pixel into the neighbouring depth maps and compare.

    Args:
        inverse: (K, h, w) float32 inverse depth maps.
        rays: (K, 2, h, w) float32, x/z and y/z of every pixel.
        neighbours: (K, M) int64 rows of the depth maps to ask.
        rotation: (K, M, 3, 3) float32, camera to neighbour.
        translation: (K, M, 3) float32.
        ks: (K, 4) float32 intrinsics.
        tolerance: (K,) float32 inverse depth.

    Returns:
        verdict (K, M, h, w) int32: 1 + p where the neighbour's flat pixel p agrees, -1 - p where
        the pixel floats in front of what the neighbour sees at p, else 0; and (K, M, h, w)
        float32, the neighbour's inverse depth carried back along the pixel's ray, which means
        something only where it agrees.
    """
    count, height, width = inverse.shape
    asked, size = neighbours.shape[1], height * width
    verdict = np.empty((count, asked, size), np.int32)
    carried = np.empty((count, asked, size), F)
    flat, ray = inverse.reshape(count, size), rays.reshape(count, 2, size)
    at, z = np.empty(size, np.int32), np.empty(size, F)
    for i in range(count):
        own, gate = flat[i], tolerance[i]
        for m in range(asked):
            j = neighbours[i, m]
            _locate(own, ray[i], rotation[i, m], translation[i, m], ks[j], width, height, at, z)
            theirs, said, back = flat[j], verdict[i, m], carried[i, m]
            for p in range(size):
                # inverse depths here and there: camera points are divided by their depth
                gap = own[p] / z[p] - theirs[max(at[p], INT(0))]
                back[p] = own[p] - gap * z[p] * z[p]
                heard = INT(1) + at[p] if gap > -gate else INT(0)
                heard = INT(-1) - at[p] if gap > gate else heard
                said[p] = heard if at[p] >= 0 else INT(0)
    shape = (count, asked, height, width)
    return verdict.reshape(shape), carried.reshape(shape)


@_jit
def _locate(own, ray, rotation, translation, k, width, height, at, z):
    """Fill the flat pixel that each pixel falls on in a neighbour, -1 outside, and its depth.

    The depth is that of the pixel's point divided by its own depth, so that infinity is harmless.
    """
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


@_jit
def vote(sure, neighbours, verdict, against_weight):
    """Opacity of every pixel from its neighbours' verdicts, each weighted by its own certainty.

    Args:
        sure: (K, h, w) float32, 0..1; matching confidence, or the last round's opacity.
        neighbours: (K, M) int64.
        verdict: as `compare` returns.
        against_weight: what a free-space violation weighs beside an agreement.

    Returns:
        (K, h, w) float32 in 0..1.
    """
    count, height, width = sure.shape
    size = height * width
    flat, heard = sure.reshape(count, size), verdict.reshape(count, -1, size)
    opacity = np.empty((count, size), F)
    support, against = np.empty(size, F), np.empty(size, F)
    for i in range(count):
        support[:] = OWN * flat[i]
        against[:] = 0
        for m in range(neighbours.shape[1]):
            theirs, said = flat[neighbours[i, m]], heard[i, m]
            for p in range(size):
                weight = theirs[max(abs(said[p]) - INT(1), INT(0))]
                support[p] += weight if said[p] > 0 else F(0)
                against[p] += weight if said[p] < 0 else F(0)
        for p in range(size):
            opacity[i, p] = support[p] / (DOUBT + support[p] + against_weight * against[p])
    return opacity.reshape(count, height, width)


@_jit
def fuse(inverse, opacity, neighbours, verdict, carried):
    """Inverse depth of every pixel, averaged with the neighbours that agree, by their opacity.

    Args:
        inverse, neighbours, verdict, carried: as in `compare`.
        opacity: (K, h, w) float32.

    Returns:
        (K, h, w) float32.
    """
    count, height, width = inverse.shape
    size = height * width
    own, sure = inverse.reshape(count, size), opacity.reshape(count, size)
    heard, brought = verdict.reshape(count, -1, size), carried.reshape(count, -1, size)
    fused = np.empty((count, size), F)
    weight = np.empty(size, F)
    for i in range(count):
        mean = fused[i]
        for p in range(size):
            weight[p] = sure[i, p] + DEPTH_FLOOR
            mean[p] = own[i, p] * weight[p]
        for m in range(neighbours.shape[1]):
            theirs, said, back = sure[neighbours[i, m]], heard[i, m], brought[i, m]
            for p in range(size):
                good = (said[p] > 0) & (back[p] > F(0))
                share = theirs[max(said[p] - INT(1), INT(0))] if good else F(0)
                mean[p] += share * (back[p] if good else F(0))
                weight[p] += share
        for p in range(size):
            mean[p] /= weight[p]
    return fused.reshape(count, height, width)


@_jit
def place(fused, opacity, rays, camera_to_world, threshold):
    """Splats of the pixels that are opaque enough.

    Args:
        fused: (K, h, w) float32 inverse depth.
        opacity: (K, h, w) float32.
        rays: (K, 2, h, w) float32.
        camera_to_world: (K, 3, 4) float32.
        threshold: least opacity to keep.

    Returns:
        (5, n) float32: rows of world x, y, z, opacity, depth in the source camera; and (n,)
        int64 their flat pixels (frame, row, column).
    """
    count, height, width = fused.shape
    size = height * width
    kept = np.flatnonzero(opacity.reshape(count * size) >= threshold)
    splats = np.empty((5, len(kept)), F)
    inverse, sure = fused.reshape(count * size), opacity.reshape(count * size)
    ray = rays.reshape(count, 2, size)
    for n in range(len(kept)):
        i, p = kept[n] // size, kept[n] % size
        depth = F(1) / inverse[kept[n]]
        x, y = ray[i, 0, p] * depth, ray[i, 1, p] * depth
        for a in range(3):
            pose = camera_to_world[i, a]
            splats[a, n] = pose[0] * x + pose[1] * y + pose[2] * depth + pose[3]
        splats[3, n], splats[4, n] = sure[kept[n]], depth
    return splats, kept
