"""Plane-sweep stereo: the matching cost of a pair of frames, and depth from several pairs.

Planes are uniform in inverse depth. Pair costs are uint8, sums of them int16: rounded to half a
level of 255, well below the images' noise, at half the memory and twice the lanes of float32. The
plain twins of these kernels are in the tests.
"""

from __future__ import annotations

import cv2
import numpy as np

from fsel.utils.compiled import exact

F, S, INT = np.float32, np.int16, np.int32
U = np.uint64

LARGEST_PENALTY = 7600  # four paths of a cost, at most 510, and a penalty stay within int16
MOST_PLANES = 128  # whose costs, at most 510 each, stay within uint16
OUTSIDE = F(150)  # cost, of 255, where the source frame does not see the point
CONFIDENCE_OFFSET = F(8)  # keeps the confidence of a flat, all-matching pixel near zero


def packed(image):
    """(2h, 2w) uint64 of an (h, w, 3) float32 image of whole grey levels at twice its size.

    Bilinear weights are sixteenths, so red, green and blue, 16 bits each, are exact.
    """
    levels = np.rint(16 * cv2.resize(image, None, fx=2, fy=2)).astype(np.uint64)
    return levels[..., 0] | levels[..., 1] << U(16) | levels[..., 2] << U(32)


@exact
def pair_cost(reference, enlarged, rays, rotation, translation, k, inverse, truncation):
    """Matching cost of an ordered pair of frames at every pixel and plane.

    Args:
        reference: (h, w, 3) float32 image, grey levels 0..255.
        enlarged: (2h, 2w) uint64, the source image as `packed`: the nearest pixel at twice the
            size is as good as interpolating, at a quarter of the loads.
        rays: (2, h, w) float32, x/z and y/z of the reference's pixels.
        rotation: (3, 3) float32, reference camera to source camera.
        translation: (3,) float32, world units.
        k: (4,) float32, fx, fy, cx, cy of the source at its own size, pixels.
        inverse: (D,) float32 inverse depths, ascending.
        truncation: mean absolute difference, grey levels, that saturates the cost.

    Returns:
        (h, w, D) uint8; 255 is the truncation.
    """
    height, width = reference.shape[:2]
    planes = len(inverse)
    cost = np.empty((height, width, planes), np.uint8)
    scale = F(255.0) / (F(3 * 16) * truncation)
    flat = enlarged.reshape(enlarged.size)
    index, levels = np.empty(planes, INT), np.empty(planes, U)
    for y in range(height):
        for x in range(width):
            r, g, b = reference[y, x, 0], reference[y, x, 1], reference[y, x, 2]
            red, green, blue = INT(F(16) * r), INT(F(16) * g), INT(F(16) * b)
            ray = rays[0, y, x], rays[1, y, x]
            _project(ray, rotation, translation, k, inverse, enlarged.shape, index)
            # three loops: only the middle one, which gathers, does not vectorise
            for d in range(planes):
                levels[d] = flat[np.uint32(max(index[d], INT(0)))]
            for d in range(planes):
                at = levels[d]
                gap = abs(INT(at & U(0xFFFF)) - red) + abs(INT(at >> U(16) & U(0xFFFF)) - green)
                value = min(F(gap + abs(INT(at >> U(32)) - blue)) * scale, F(255))
                cost[y, x, d] = np.uint8(INT(value if index[d] >= 0 else OUTSIDE))
    return cost


@exact
def _project(ray, rotation, translation, k, inverse, shape, index):
    """Fill the flat pixel of a source image that a pixel's point at each plane falls on, or -1."""
    fx, fy, cx, cy = F(2) * k[0], F(2) * k[1], F(2) * k[2], F(2) * k[3]
    bx = fx * translation[0] + cx * translation[2]
    by = fy * translation[1] + cy * translation[2]
    bz = translation[2]
    limit_x, limit_y = F(shape[1]), F(shape[0])
    rx, ry = ray
    px = rotation[0, 0] * rx + rotation[0, 1] * ry + rotation[0, 2]
    py = rotation[1, 0] * rx + rotation[1, 1] * ry + rotation[1, 2]
    pz = rotation[2, 0] * rx + rotation[2, 1] * ry + rotation[2, 2]
    ax, ay = fx * px + cx * pz, fy * py + cy * pz
    for d in range(len(inverse)):
        z = pz + inverse[d] * bz
        w = F(1) / max(z, F(1e-9))
        u = (ax + inverse[d] * bx) * w
        v = (ay + inverse[d] * by) * w
        inside = (z > F(1e-6)) & (u >= F(0)) & (v >= F(0)) & (u < limit_x) & (v < limit_y)
        column = INT(min(max(u, F(0)), limit_x - F(1)))
        row = INT(min(max(v, F(0)), limit_y - F(1)))
        index[d] = row * INT(shape[1]) + column if inside else INT(-1)


@exact
def box_filter(cost):
    """3x3 mean over pixels, borders repeated, plane by plane; (h, w, D) uint8, rounded down."""
    height, width, planes = cost.shape
    rows = np.empty((width + 2, planes), np.uint16)
    out = np.empty_like(cost)
    for y in range(height):
        up, down = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            for d in range(planes):
                total = np.uint16(cost[up, x, d]) + np.uint16(cost[y, x, d])
                rows[x + 1, d] = np.uint16(total + np.uint16(cost[down, x, d]))
        for d in range(planes):
            rows[0, d], rows[width + 1, d] = rows[1, d], rows[width, d]
        for x in range(width):
            for d in range(planes):
                total = (
                    np.uint32(rows[x, d]) + np.uint32(rows[x + 1, d]) + np.uint32(rows[x + 2, d])
                )
                # 7282 / 65536 is a ninth, exact for sums up to 9 * 255
                out[y, x, d] = np.uint8(np.uint32(total * np.uint32(7282)) >> np.uint32(16))
    return out


@exact
def merge_costs(first, second, third, fourth, count):
    """Twice the mean of the better half of up to four pair costs, which tolerates occlusion.

    The first `count` of the four (h, w, D) uint8 arrays count; returns (h, w, D) int16, 0..510,
    rounded down.
    """
    height, width, planes = first.shape
    out = np.empty((height, width, planes), S)
    for y in range(height):
        for x in range(width):
            if count == 1:
                for d in range(planes):
                    out[y, x, d] = S(2) * S(first[y, x, d])
            elif count == 2:
                for d in range(planes):
                    p, q = S(first[y, x, d]), S(second[y, x, d])
                    out[y, x, d] = S(min(p, q) + (S(p + q) >> 1))
            elif count == 3:
                for d in range(planes):
                    p, q, r = S(first[y, x, d]), S(second[y, x, d]), S(third[y, x, d])
                    out[y, x, d] = S(p + q + r - max(p, max(q, r)))
            else:
                for d in range(planes):
                    p, q = S(first[y, x, d]), S(second[y, x, d])
                    r, s = S(third[y, x, d]), S(fourth[y, x, d])
                    low, other = min(p, q), min(r, s)
                    runner_up = min(max(low, other), min(max(p, q), max(r, s)))
                    out[y, x, d] = S(min(low, other) + runner_up)
    return out


@exact
def aggregate(cost, grey, small, large):
    """Semi-global aggregation along four axes (Hirschmueller, PAMI 2008).

    Textureless pixels take the depth of their surroundings; jumps are cheaper across edges.

    Args:
        cost: (h, w, D) int16, 0..510.
        grey: (h, w) float32, 0..255.
        small: penalty of a change by one plane, int16.
        large: penalty of a jump on a flat image, float32, at most `LARGEST_PENALTY`.

    Returns:
        (h, w, D) int16, summed over the paths.
    """
    height, width, planes = cost.shape
    total = np.zeros((height, width, planes), S)
    # all lines advance together: their steps do not wait for each other. Indexed in place,
    # without row views, whose reference counts would cost more than the sums; every sum is cut
    # back to int16 at once, or the loop would not vectorise
    lines = max(height, width)
    jumps = _jumps(grey, small, large)
    path, lows = np.full((2, lines, planes + 2), S(20000)), np.empty(lines, S)
    for direction in range(4):
        horizontal, forward = direction < 2, direction % 2 == 0
        steps = width if horizontal else height
        for line in range(lines):
            lows[line] = 0
            for d in range(planes):
                path[0, line, d + 1] = 0
        for s in range(steps):
            at = s if forward else steps - 1 - s
            last = at if s == 0 else (at - 1 if forward else at + 1)
            old, new = s & 1, 1 - (s & 1)
            for line in range(height if horizontal else width):
                y, x = (line, at) if horizontal else (at, line)
                jump = jumps[0, y, max(at, last)] if horizontal else jumps[1, max(at, last), x]
                low = lows[line]
                for d in range(planes):
                    near = S(min(path[old, line, d], path[old, line, d + 2]) + small)
                    least = min(S(min(path[old, line, d + 1], near) - low), jump)
                    path[new, line, d + 1] = S(cost[y, x, d] + least)
                low = S(20000)
                for d in range(planes):
                    reached = path[new, line, d + 1]
                    low = min(low, reached)
                    total[y, x, d] = S(total[y, x, d] + reached)
                lows[line] = low
    return total


@exact
def _jumps(grey, small, large):
    """(2, h, w) int16 penalties of a jump between a pixel and the one before it, in its row and in
    its column; 0 without one before.
    """
    height, width = grey.shape
    jumps = np.zeros((2, height, width), S)
    least = F(small) + F(1)
    for y in range(height):
        for x in range(1, width):
            edge = abs(grey[y, x] - grey[y, x - 1])
            jumps[0, y, x] = S(INT(np.rint(max(least, large / (F(1) + F(0.1) * edge)))))
    for y in range(1, height):
        for x in range(width):
            edge = abs(grey[y, x] - grey[y - 1, x])
            jumps[1, y, x] = S(INT(np.rint(max(least, large / (F(1) + F(0.1) * edge)))))
    return jumps


@exact
def winner(total, cost, inverse):
    """Winner-take-all with a parabola through the minimum, and how far the minimum stands out.

    Args:
        total: (h, w, D) int16 aggregated cost.
        cost: (h, w, D) int16 matching cost.
        inverse: (D,) float32 inverse depths.

    Returns:
        (h, w) float32 inverse depth, and (h, w) float32 confidence in 0..1: near zero where every
        plane matches alike, as on a blank wall or the sky.
    """
    height, width, planes = total.shape
    depth = np.empty((height, width), F)
    sure = np.empty((height, width), F)
    step = (inverse[planes - 1] - inverse[0]) / F(max(planes - 1, 1))
    for y in range(height):
        for x in range(width):
            low, summed, best = S(32767), np.uint16(0), S(planes)
            for d in range(planes):
                low = min(low, total[y, x, d])
                summed = np.uint16(summed + np.uint16(cost[y, x, d]))  # of MOST_PLANES at most
            for d in range(planes):
                best = min(best, S(d) if total[y, x, d] <= low else S(planes))
            mean = F(summed) / F(planes)
            offset = F(0)
            if 0 < best < planes - 1:
                left, right = F(total[y, x, best - 1]), F(total[y, x, best + 1])
                curve = left + right - F(2) * F(low)
                if curve > 0:
                    offset = F(0.5) * (left - right) / curve
            depth[y, x] = inverse[best] + offset * step
            sure[y, x] = max(F(0), (mean - F(cost[y, x, best])) / (mean + CONFIDENCE_OFFSET))
    return depth, sure
