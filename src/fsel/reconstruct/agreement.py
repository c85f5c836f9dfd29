"""Which pixels of which depth maps to believe: agreement, free-space violations, fusion.

float32 throughout: depths are compared to a plane's spacing, a thousand times their rounding.
"""

from __future__ import annotations

import numba
import numpy as np

F = np.float32
_jit = numba.njit(cache=True, fastmath=True, nogil=True)

OWN = F(0.2)  # what a pixel's own matching confidence is worth beside a neighbour's agreement
DOUBT = F(0.35)  # opacity is one half where the support equals this and nothing speaks against
DEPTH_FLOOR = F(1e-3)


@_jit
def compare(inverse, rays, neighbours, rotation, translation, ks, tolerance):
    """Carry every pixel into the neighbouring depth maps and compare.

    Args:
        inverse: (K, h, w) float32 inverse depth maps.
        rays: (K, h, w, 2) float32, x/z and y/z of every pixel.
        neighbours: (K, M) int64 rows of the depth maps to ask.
        rotation: (K, M, 3, 3) float32, camera to neighbour.
        translation: (K, M, 3) float32.
        ks: (K, 4) float32 intrinsics.
        tolerance: (K,) float32 inverse depth.

    Returns:
        verdict (K, M, h, w) int32: 1 + p where the neighbour's flat pixel p agrees, -1 - p where
        the pixel floats in front of what the neighbour sees at p, else 0; and (K, M, h, w)
        float32, the neighbour's inverse depth carried back along the pixel's ray where it agrees.
    """
    count, height, width = inverse.shape
    asked = neighbours.shape[1]
    verdict = np.zeros((count, asked, height, width), np.int32)
    carried = np.empty((count, asked, height, width), F)
    for i in range(count):
        for m in range(asked):
            j = neighbours[i, m]
            r, t = rotation[i, m], translation[i, m]
            fx, fy, cx, cy = ks[j]
            other = inverse[j]
            for y in range(height):
                for x in range(width):
                    q, rx, ry = inverse[i, y, x], rays[i, y, x, 0], rays[i, y, x, 1]
                    # camera points divided by their depth, so that infinity is harmless
                    z = r[2, 0] * rx + r[2, 1] * ry + r[2, 2] + t[2] * q
                    if z <= F(1e-6):
                        continue
                    w = F(1) / z
                    u = fx * (r[0, 0] * rx + r[0, 1] * ry + r[0, 2] + t[0] * q) * w + cx
                    v = fy * (r[1, 0] * rx + r[1, 1] * ry + r[1, 2] + t[1] * q) * w + cy
                    if not (u >= 0 and v >= 0 and u < width and v < height):
                        continue
                    at = np.int32(v) * np.int32(width) + np.int32(u)
                    gap = q * w - other[int(v), int(u)]
                    if gap > tolerance[i]:
                        verdict[i, m, y, x] = np.int32(-1) - at
                    elif gap > -tolerance[i]:
                        verdict[i, m, y, x] = np.int32(1) + at
                        carried[i, m, y, x] = q - gap * z * z
    return verdict, carried


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
    opacity = np.empty((count, height, width), F)
    support, against = np.empty(size, F), np.empty(size, F)
    for i in range(count):
        support[:] = OWN * sure[i].reshape(size)
        against[:] = 0
        for m in range(neighbours.shape[1]):
            theirs = sure[neighbours[i, m]].reshape(size)
            said = verdict[i, m].reshape(size)
            for p in range(size):
                if said[p] > 0:
                    support[p] += theirs[said[p] - 1]
                elif said[p] < 0:
                    against[p] += theirs[-1 - said[p]]
        out = opacity[i].reshape(size)
        for p in range(size):
            out[p] = support[p] / (DOUBT + support[p] + against_weight * against[p])
    return opacity


@_jit
def splat_positions(
    inverse, opacity, neighbours, verdict, carried, rays, camera_to_world, threshold, out
):
    """Fuse the depths that agree and place the pixels that are opaque enough in the world.

    Args:
        inverse, neighbours, verdict, carried, rays: as in `compare`.
        opacity: (K, h, w) float32.
        camera_to_world: (K, 3, 4) float32.
        threshold: least opacity to keep.
        out: (K * h * w, 5) float32 to fill: x, y, z, opacity, depth in the source camera.

    Returns:
        (kept,) int64 flat pixels (frame, row, column) of the rows filled.
    """
    count, height, width = inverse.shape
    kept = np.empty(count * height * width, np.int64)
    n = 0
    for i in range(count):
        pose = camera_to_world[i]
        for y in range(height):
            for x in range(width):
                if opacity[i, y, x] < threshold:
                    continue
                weight = opacity[i, y, x] + DEPTH_FLOOR
                mean = inverse[i, y, x] * weight
                for m in range(neighbours.shape[1]):
                    said = verdict[i, m, y, x]
                    if said > 0 and carried[i, m, y, x] > 0:
                        row, column = (said - 1) // width, (said - 1) % width
                        theirs = opacity[neighbours[i, m], row, column]
                        mean += theirs * carried[i, m, y, x]
                        weight += theirs
                depth = weight / mean
                px, py = rays[i, y, x, 0] * depth, rays[i, y, x, 1] * depth
                for a in range(3):
                    out[n, a] = pose[a, 0] * px + pose[a, 1] * py + pose[a, 2] * depth + pose[a, 3]
                out[n, 3], out[n, 4] = opacity[i, y, x], depth
                kept[n] = (i * height + y) * width + x
                n += 1
    return kept[:n]
